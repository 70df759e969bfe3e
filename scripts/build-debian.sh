#!/usr/bin/env bash
# A Debian source package with all crates in it, and the package that it builds without a network; lintian checks both.
#
#     scripts/build-debian.sh [FOLDER]          default: target/debian
#
# Needs dpkg-dev, debhelper, lintian, git and cargo; a network to fetch the crates. Debian's cargo may be too old; then the one that is
# first in PATH builds. DEB_BUILD_OPTIONS=noopt builds quickly. EXTRICATE_SOURCE_ONLY=1 makes the source package alone.
set -euo pipefail
cd "$(dirname "$0")/.."
out=$(realpath -m "${1:-target/debian}")
version=$(sed -n 's/^version = "\(.*\)"/\1/p' Cargo.toml | head -n 1)
rm -rf "$out"
mkdir -p "$out"
scripts/build-source.sh "$out/parts"
tar -xzf "$out/parts/extricate-source-$version.tar.gz" -C "$out"
python3 scripts/write-packaging.py --artefacts "$out/parts" --out "$out/recipes" --allow-missing 2>/dev/null
cd "$out/extricate-$version"
mkdir -p .cargo
cargo vendor --quiet --locked --versioned-dirs vendor >/dev/null
printf '[source.crates-io]\nreplace-with = "vendored"\n\n[source.vendored]\ndirectory = "vendor"\n' >.cargo/config.toml
tar -czf "../extricate_$version.orig.tar.gz" -C .. "extricate-$version"
cp -r ../recipes/debian debian
if [ -n "${EXTRICATE_SOURCE_ONLY:-}" ]; then
    dpkg-buildpackage --build=source --no-check-builddeps --unsigned-source --unsigned-changes
else
    dpkg-buildpackage --no-check-builddeps --unsigned-source --unsigned-changes
    lintian --fail-on error --tag-display-limit 0 ../extricate_"$version"-1_*.deb
    dpkg-deb --contents ../extricate_"$version"-1_*.deb >../contents
    for name in usr/bin/extricate doc/extricate/copyright doc/extricate/third-party-licences.txt man1/extricate-query; do
        grep -q "$name" ../contents || { echo "the package has no $name" >&2; exit 1; }
    done
fi
