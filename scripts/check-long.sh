#!/usr/bin/env bash
# What takes too long for every change, and is run before a release: live pages, C and C++, packages, other platforms. Needs what
# .ci/run has built, rustup, a C++17 compiler, Python 3.9 or newer with pip, and a network.
set -euo pipefail
cd "$(dirname "$0")/.."
program="${CARGO_TARGET_DIR:-target}/debug/extricate"

step() { printf '\n== %s\n' "$*"; }

step "live pages: the library in a browser, and its size"
wasm=target/extricate.wasm.gz
scripts/build-wasm.sh "$wasm"
python3 scripts/check-view.py "$program" --live "$wasm" "$(dirname "$program")/examples/native"
scripts/write-live-page.sh "$program" "$wasm"

step "C and C++: installed, under sanitizers, with OMPL"
scripts/check-c.sh

step "what would be published"
scripts/check-packages.sh

step "other platforms"
scripts/check-platforms.sh

step "all passed"
