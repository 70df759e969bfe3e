#!/usr/bin/env bash
# The site with the reference of Rust in it, checked: what publish-site.sh publishes. EXTRICATE_SITE and EXTRICATE_PYTHON are as in
# check-docs.sh. Needs cargo, Python 3.10 or newer with pip, and a network.
set -euo pipefail
cd "$(dirname "$0")/.."
rm -rf target/rustdoc/doc
RUSTDOCFLAGS="-D warnings" cargo doc --quiet --no-deps --locked --package extricate --target-dir target/rustdoc
scripts/check-docs.sh
