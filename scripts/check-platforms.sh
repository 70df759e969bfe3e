#!/usr/bin/env bash
# Library and command line for other platforms, checked without building: aarch64 Linux, macOS, Windows, and the library for WebAssembly
# too. Called by check-long.sh; needs rustup and a network.
set -euo pipefail
cd "$(dirname "$0")/.."
native=(aarch64-unknown-linux-gnu aarch64-apple-darwin x86_64-pc-windows-msvc)
wasm=wasm32-unknown-unknown
there=()
for target in "${native[@]}" "$wasm"; do
    if rustup target list --installed | grep -qx "$target" || rustup target add "$target"; then
        there+=("$target")
    else
        echo "NOT CHECKED: $target, because it cannot be installed here" >&2
    fi
done
export RUSTFLAGS="-D warnings"
for target in "${there[@]}"; do
    packages=(--package extricate --package extricate-cli)
    [ "$target" = "$wasm" ] || packages+=(--package extricate-c)
    cargo check --quiet --locked "${packages[@]}" --target "$target"
done
echo "checked for ${there[*]:-none}"
