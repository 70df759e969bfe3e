#!/usr/bin/env bash
# Wheels as they would be published: manylinux2014, for x86-64 and aarch64, by zig; and proof that the one for this machine installs into
# empty environments and passes the tests there. Takes long; .ci/run does not call it.
#
#     scripts/build-wheels.sh [FOLDER]          default: target/wheels
#
# EXTRICATE_PYTHONS names the interpreters to try (default: those of python3.9 to python3.13 that are there).
set -euo pipefail
cd "$(dirname "$0")/.."
out=${1:-target/wheels}
tools=$PWD/target/wheel-tools
manifest=crates/extricate-python/Cargo.toml
# Most seconds of an installation into an empty environment, with all that it needs in a folder.
most=10
mkdir -p "$out"
rm -f "$out"/*.whl "$out"/*.tar.gz
[ -x "$tools/bin/pip" ] || python3 -m venv "$tools"
"$tools/bin/pip" install --quiet --disable-pip-version-check "maturin>=1.9.4,<2" ziglang auditwheel twine
export PATH=$tools/bin:$PATH

for target in x86_64-unknown-linux-gnu aarch64-unknown-linux-gnu; do
    rustup target list --installed | grep -qx "$target" || rustup target add "$target"
    maturin build --locked --profile dist --manifest-path "$manifest" --target "$target" --zig --compatibility manylinux2014 --out "$out"
done
maturin sdist --manifest-path "$manifest" --out "$out"
twine check --strict "$out"/*

for wheel in "$out"/*.whl; do
    shown=$(auditwheel show "$wheel" | tr '\n' ' ')
    # A wheel that also runs on older systems names their tags too; the first one counts.
    tag=$(grep -o '"manylinux[^"]*"' <<<"$shown" | head -n 1)
    case $tag in
        '"manylinux_2_17_'*) echo "$(basename "$wheel"): $tag" ;;
        *) echo "$wheel: auditwheel says ${shown}, expected manylinux_2_17" >&2; exit 1 ;;
    esac
    python3 -m zipfile --list "$wheel" | grep "licenses/LICENSE-MIT" >/dev/null || { echo "$wheel has no licence text" >&2; exit 1; }
done

tried=0
for python in ${EXTRICATE_PYTHONS:-python3.9 python3.10 python3.11 python3.12 python3.13}; do
    if ! "$python" -c "" 2>/dev/null; then
        echo "NOT TRIED: $python, which is not there" >&2
        continue
    fi
    venv=$(mktemp -d)
    "$python" -m venv "$venv"
    pip() { "$venv/bin/pip" --quiet --disable-pip-version-check "$@"; }
    pip download --dest "$venv/needed" --find-links "$out" extricate
    started=$EPOCHREALTIME
    pip install --no-index --find-links "$venv/needed" extricate
    took=$(awk -v from="$started" -v to="$EPOCHREALTIME" 'BEGIN { printf "%.1f", to - from }')
    echo "$("$venv/bin/python" --version): installed in $took s"
    awk -v took="$took" -v most="$most" 'BEGIN { exit took > most }' || { echo "expected at most $most s" >&2; exit 1; }
    pip install pytest
    "$venv/bin/python" -m pytest --quiet crates/extricate-python/tests
    rm -rf "$venv"
    tried=$((tried + 1))
done
[ "$tried" -gt 0 ] || { echo "no interpreter was there to install into" >&2; exit 1; }
