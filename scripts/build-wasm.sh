#!/usr/bin/env bash
# Builds the library as WebAssembly, for live pages: target/extricate.wasm.gz, or the file that is named. Then
#
#     EXTRICATE_WASM=$PWD/target/extricate.wasm.gz cargo build --release -p extricate-cli
#
# builds a program that has it in it. Needs rustup's cargo; adds the target where it is missing.
set -euo pipefail
cd "$(dirname "$0")/.."
out=${1:-target/extricate.wasm.gz}
target=wasm32-unknown-unknown
# Most bytes of the gzipped file; a page carries it in base64, which adds a third.
most=900000

rustup target list --installed | grep -qx "$target" || rustup target add "$target"
# The library needs no random numbers of the system, because every sampler has a seed. All current browsers have 128-bit vectors.
export RUSTFLAGS='--cfg getrandom_backend="unsupported" -C target-feature=+simd128'
cargo build --locked --package extricate-wasm --lib --profile wasm --target "$target"
built=${CARGO_TARGET_DIR:-target}/$target/wasm/extricate_wasm.wasm
mkdir -p "$(dirname "$out")"
gzip --best --no-name --stdout "$built" > "$out"
bytes=$(stat -c %s "$out")
echo "$out: $bytes bytes, $(stat -c %s "$built") unpacked"
[ "$bytes" -le "$most" ] || { echo "expected at most $most bytes" >&2; exit 1; }
