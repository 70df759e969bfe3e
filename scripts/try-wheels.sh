#!/usr/bin/env bash
# Installs the wheel for this machine into an empty environment of each Python that is there, and runs the tests in it.
#
#     scripts/try-wheels.sh FOLDER
#
# EXTRICATE_PYTHONS names the interpreters (default: those of python3.9 to python3.14 that are there).
set -euo pipefail
cd "$(dirname "$0")/.."
wheels=${1:?expected the folder of the wheels}
# Most seconds of an installation, with all that it needs in a folder.
most=10

tried=0
for python in ${EXTRICATE_PYTHONS:-python3.9 python3.10 python3.11 python3.12 python3.13 python3.14}; do
    if ! "$python" -c "" 2>/dev/null; then
        echo "NOT TRIED: $python, which is not there" >&2
        continue
    fi
    venv=$(mktemp -d)
    "$python" -m venv "$venv"
    run=$venv/bin/python
    # Windows has another layout.
    [ -e "$run" ] || run=$venv/Scripts/python.exe
    pip() { "$run" -m pip --quiet --disable-pip-version-check "$@"; }
    pip download --dest "$venv/needed" --find-links "$wheels" extricate
    started=$(date +%s.%N)
    pip install --no-index --find-links "$venv/needed" extricate
    took=$(awk -v from="$started" -v to="$(date +%s.%N)" 'BEGIN { printf "%.1f", to - from }')
    echo "$("$run" --version): installed in $took s"
    awk -v took="$took" -v most="$most" 'BEGIN { exit took > most }' || { echo "expected at most $most s" >&2; exit 1; }
    pip install pytest
    "$run" -m pytest --quiet crates/extricate-python/tests
    rm -rf "$venv"
    tried=$((tried + 1))
done
[ "$tried" -gt 0 ] || { echo "no interpreter was there to install into" >&2; exit 1; }
