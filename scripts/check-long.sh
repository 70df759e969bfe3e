#!/usr/bin/env bash
# What takes too long for every change, and is run before a release. Needs what .ci/run has built, rustup, a C++17 compiler, libssl-dev, Chromium, Python
# 3.9 or newer with pip, and a network. Nothing is left out silently.
#
#     scripts/check-long.sh [STEP...]           all of: live c packages platforms wheels fleet fuzz
set -euo pipefail
cd "$(dirname "$0")/.."
program="${CARGO_TARGET_DIR:-target}/debug/extricate"
wheels=target/wheels

step() { printf '\n== %s\n' "$*"; }

live() {
    step "live pages: the library in a browser, its size, and the page that the documentation begins with"
    local wasm=target/extricate.wasm.gz site=target/site
    scripts/build-wasm.sh "$wasm"
    scripts/write-live-page.sh "$program" "$wasm"
    EXTRICATE_SITE=$site scripts/check-docs.sh
    python3 scripts/fetch-robots.py panda_description
    python3 scripts/check-view.py "$program" --native "$(dirname "$program")/examples/native" --live "$wasm" "$(dirname "$program")/examples/native" --robots robots --site "$site"
}

c() {
    step "C and C++: installed by cargo-c, under sanitizers and valgrind, with OMPL"
    local tools=$PWD/target/tools
    export PATH="$tools/bin:$PATH"
    # This version is for Rust 1.95; newer ones need a newer Rust.
    cargo cinstall --version >/dev/null 2>&1 || cargo install --quiet --locked --root "$tools" cargo-c@0.10.24
    # With CI set, missing programs are installed.
    CI=1 EXTRICATE_VALGRIND=1 scripts/check-c.sh
}

packages() {
    step "what would be published, built as its users build it"
    EXTRICATE_PACKAGES_BUILT=1 scripts/check-packages.sh
}

platforms() {
    step "other platforms"
    scripts/check-platforms.sh
}

wheels() {
    step "wheels: manylinux2014, installed into empty environments"
    scripts/build-wheels.sh "$wheels"
}

fleet() {
    step "learning of many scenes on a cluster that loses a node"
    scripts/check-fleet.sh "$wheels"
}

fuzz() {
    step "fuzz targets under libFuzzer"
    scripts/check-fuzz.sh
}

[ $# -gt 0 ] || set -- live c packages platforms wheels fleet fuzz
for name in "$@"; do
    case $name in
        live | c | packages | platforms | wheels | fleet | fuzz) "$name" ;;
        *) echo "got the step $name, expected live, c, packages, platforms, wheels, fleet or fuzz" >&2; exit 2 ;;
    esac
done
step "all passed: $*"
