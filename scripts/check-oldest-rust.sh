#!/usr/bin/env bash
# Checks that the oldest Rust which the manifest promises (`rust-version`) compiles everything. Needs rustup, and a network if that Rust
# is not installed.
set -euo pipefail
cd "$(dirname "$0")/.."
oldest=$(sed -n 's/^rust-version = "\(.*\)"/\1/p' Cargo.toml)
rustup toolchain list | grep -q "^$oldest" || rustup toolchain install --profile minimal "$oldest"
cargo "+$oldest" check --workspace --locked
