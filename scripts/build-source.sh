#!/usr/bin/env bash
# The sources of the last commit as an archive, which recipes of packaging/ build from.
#
#     scripts/build-source.sh FOLDER
set -euo pipefail
cd "$(dirname "$0")/.."
out=${1:?expected a folder}
version=$(sed -n 's/^version = "\(.*\)"/\1/p' Cargo.toml | head -n 1)
mkdir -p "$out"
git archive --format=tar.gz --prefix="extricate-$version/" --output="$out/extricate-source-$version.tar.gz" HEAD
echo "$out/extricate-source-$version.tar.gz"
