#!/usr/bin/env bash
# Checks that the interfaces of the crates break no more than the version says, against the tag (`v1.2.3`) before this commit. Before the first tag there
# is nothing to compare. Needs cargo and git; installs cargo-semver-checks if it is missing.
set -euo pipefail
cd "$(dirname "$0")/.."
last=$(git describe --tags --abbrev=0 --match 'v[0-9]*' HEAD^ 2>/dev/null || true)
if [ -z "$last" ]; then
    echo "NOT CHECKED: there is no tag yet to compare with" >&2
    exit 0
fi
tools=$PWD/target/tools
export PATH="$tools/bin:$PATH"
cargo semver-checks --version >/dev/null 2>&1 || cargo install --quiet --locked --root "$tools" cargo-semver-checks
cargo semver-checks --baseline-rev "$last" --package extricate --package extricate-view
