#!/usr/bin/env bash
# Library and command line for other platforms, checked without building: aarch64 Linux, macOS, Windows, and the library for WebAssembly
# too. Called by .ci/run; needs rustup and a network.
set -euo pipefail
cd "$(dirname "$0")/.."
native=(aarch64-unknown-linux-gnu aarch64-apple-darwin x86_64-pc-windows-msvc)
wasm=wasm32-unknown-unknown
if command -v rustup >/dev/null; then
    installed=$(rustup target list --installed)
    for target in "${native[@]}" "$wasm"; do
        grep -qx "$target" <<<"$installed" || rustup target add "$target"
    done
fi
export RUSTFLAGS="-D warnings"
cargo check --quiet --locked --package extricate --package extricate-cli --package extricate-c "${native[@]/#/--target=}"
cargo check --quiet --locked --package extricate --package extricate-cli --target "$wasm"
echo "checked for ${native[*]} $wasm"
