#!/usr/bin/env bash
# Builds the site, strictly, and checks what mkdocs does not: links of README.md, remote parts of pages, and the prose. Needs Python 3.10 or newer
# with pip, and a network.
#
# EXTRICATE_PYTHON names the interpreter (default: python3). EXTRICATE_SITE names a folder that the site is left in.
set -euo pipefail
cd "$(dirname "$0")/.."
python=${EXTRICATE_PYTHON:-python3}
venv=target/docs-venv
site=${EXTRICATE_SITE:-}
if [ -z "$site" ]; then
    site=$(mktemp -d)
    trap 'rm -rf "$site"' EXIT
fi

if ! cmp -s docs/requirements.txt "$venv/installed"; then
    rm -rf "$venv"
    "$python" -m venv "$venv"
    "$venv/bin/pip" install --quiet --disable-pip-version-check --requirement docs/requirements.txt
    cp docs/requirements.txt "$venv/installed"
fi

NO_MKDOCS_2_WARNING=1 "$venv/bin/mkdocs" build --strict --quiet --site-dir "$(realpath -m "$site")"
"$python" scripts/check-links.py README.md CONTRIBUTING.md RELEASING.md packaging/README.md crates/*/README.md ARCHITECTURE.md CHANGELOG.md

"$python" scripts/check-api-pages.py "$site"

# Pages are readable offline: they load nothing from elsewhere. (Links that people follow may lead anywhere.)
if grep -rnoE --include='*.html' '<(script|img|iframe|link rel="(stylesheet|preconnect|icon)")[^>]* (src|href)="(https?:)?//[^"]*"' "$site"; then
    echo "pages load something from elsewhere" >&2
    exit 1
fi
if grep -rlE --include='*.html' 'class="(mermaid|arithmatex)' "$site"; then
    echo "diagrams or formulas would load a script from elsewhere" >&2
    exit 1
fi

"$python" scripts/check-prose.py --self-test
"$python" scripts/check-prose.py
