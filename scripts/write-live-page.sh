#!/usr/bin/env bash
# Writes target/live-demo.html, the live page that the documentation begins with: the built-in arm before a shelf, with a small model.
#
#     scripts/write-live-page.sh PROGRAM WASM
#
# PROGRAM is `extricate`, WASM what scripts/build-wasm.sh made. Without the page the documentation says that it is not there.
set -euo pipefail
program=$(realpath "$1")
wasm=$(realpath "$2")
cd "$(dirname "$0")/.."
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
(
    cd "$work"
    "$program" demo --export cell
    "$program" learn cell/shelf-arm.toml -o shelf-arm.model --labels 20000 --seed 1
    "$program" view shelf-arm.model -n 4 --seed 3 --live --wasm "$wasm" -o live-demo.html
)
mkdir -p target
mv "$work/live-demo.html" target/live-demo.html
