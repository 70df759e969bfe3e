#!/usr/bin/env bash
# Wheels as they would be published: manylinux2014, for x86-64 and aarch64, by zig; and proof that the one for this machine installs into
# empty environments. Takes long; .ci/run does not call it.
#
#     scripts/build-wheels.sh [FOLDER]          default: target/wheels
#
# EXTRICATE_PYTHONS names the interpreters to try (default: those of python3.9 to python3.13 that are there).
set -euo pipefail
cd "$(dirname "$0")/.."
out=${1:-target/wheels}
tools=target/wheel-tools
manifest=crates/extricate-python/Cargo.toml
mkdir -p "$out"
rm -f "$out"/*.whl "$out"/*.tar.gz
[ -x "$tools/bin/maturin" ] || python3 -m venv "$tools"
"$tools/bin/pip" install --quiet --disable-pip-version-check "maturin>=1.9.4,<2" ziglang auditwheel twine
export PATH=$PWD/$tools/bin:$PATH

for target in x86_64-unknown-linux-gnu aarch64-unknown-linux-gnu; do
    rustup target add "$target"
    maturin build --locked --profile release --manifest-path "$manifest" --target "$target" --zig --compatibility manylinux2014 --out "$out"
done
maturin sdist --manifest-path "$manifest" --out "$out"
twine check --strict "$out"/*
for wheel in "$out"/*.whl; do
    auditwheel show "$wheel" | tr '\n' ' ' | grep -o 'platform tag: "[^"]*"' || true
    python3 -m zipfile --list "$wheel" | grep -q "licenses/LICENSE-MIT" || { echo "$wheel has no licence text" >&2; exit 1; }
done

for python in ${EXTRICATE_PYTHONS:-python3.9 python3.10 python3.11 python3.12 python3.13}; do
    command -v "$python" >/dev/null && "$python" -c "" 2>/dev/null || continue
    venv=$(mktemp -d)
    "$python" -m venv "$venv"
    "$venv/bin/pip" install --quiet --disable-pip-version-check numpy pytest
    started=$(date +%s.%N)
    "$venv/bin/pip" install --quiet --disable-pip-version-check --no-index --find-links "$out" extricate
    echo "$("$venv/bin/python" --version): installed in $(echo "$(date +%s.%N) - $started" | bc) s"
    "$venv/bin/python" -m pytest --quiet crates/extricate-python/tests
    rm -rf "$venv"
done
