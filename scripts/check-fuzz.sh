#!/usr/bin/env bash
# Builds the targets of fuzz/ under libFuzzer with the stable toolchain and runs each on its corpus for a while. Needs a C++ compiler.
#
#     scripts/check-fuzz.sh [SECONDS [TARGET...]]       20 seconds of each of all
set -euo pipefail
cd "$(dirname "$0")/../fuzz"
seconds="${1:-20}"
shift || true
[ $# -gt 0 ] || set -- $(sed -n 's/^name = "\(.*\)"/\1/p' Cargo.toml | grep -v libfuzzer)
host="$(rustc -vV | sed -n 's/^host: //p')"
target="${CARGO_TARGET_DIR:-$PWD/target}"
export CARGO_TARGET_DIR="$target"

cargo run --quiet --release --locked --manifest-path ../Cargo.toml -p extricate-fuzz -- corpus corpus
# The flags of `cargo fuzz`, without the address sanitizer, which needs a nightly toolchain.
export RUSTC_BOOTSTRAP=1 RUSTFLAGS="-Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4 \
    -Cllvm-args=-sanitizer-coverage-inline-8bit-counters -Cllvm-args=-sanitizer-coverage-pc-table \
    -Cllvm-args=-sanitizer-coverage-trace-compares"
cargo build --quiet --release --locked --target "$host"
for name in "$@"; do
    printf '%s: ' "$name"
    log="$(mktemp)"
    if ! "$target/$host/release/$name" "corpus/$name" -timeout=10 -rss_limit_mb=2048 -max_len=200000 \
        -max_total_time="$seconds" -artifact_prefix="$(mkdir -p "artifacts/$name" && echo "artifacts/$name/")" 2> "$log"; then
        tail -40 "$log" >&2
        exit 1
    fi
    grep '^Done ' "$log"
    rm "$log"
done
