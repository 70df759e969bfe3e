#!/usr/bin/env bash
# Builds the C and C++ library and installs it below a folder: headers, shared and static library, pkg-config, CMake.
#
#     scripts/install-c.sh PREFIX            builds a release
#     scripts/install-c.sh PREFIX FOLDER     takes the libraries from a folder where they are built already
set -euo pipefail
cd "$(dirname "$0")/.."
prefix=${1:?usage: scripts/install-c.sh PREFIX [FOLDER]}
built=${2:-}
crate=crates/extricate-c
if [ -z "$built" ]; then
    cargo build --locked --release --package extricate-c
    built=${CARGO_TARGET_DIR:-target}/release
fi
version=$(cargo metadata --no-deps --format-version 1 --locked | python3 -c '
import json, sys
print(next(p["version"] for p in json.load(sys.stdin)["packages"] if p["name"] == "extricate-c"))')
IFS=. read -r major minor _ <<<"$version"
# The version is the one in build.rs: before 1.0 every minor version may change the interface.
if [ "$major" = 0 ]; then number=0.$minor; else number=$major; fi

mkdir -p "$prefix/include" "$prefix/lib/pkgconfig" "$prefix/lib/cmake/extricate" "$prefix/share/licenses/extricate"
install -m 644 "$crate/include/extricate.h" "$crate/include/extricate.hpp" "$crate/include/extricate_moveit.hpp" "$prefix/include"
install -m 644 LICENSE-MIT LICENSE-APACHE "$prefix/share/licenses/extricate"
case $(uname -s) in
    Darwin) real=libextricate_c.$number.dylib plain=libextricate_c.dylib ;;
    *) real=libextricate_c.so.$number plain=libextricate_c.so ;;
esac
install -m 755 "$built/$plain" "$prefix/lib/$real"
ln -sf "$real" "$prefix/lib/$plain"
install -m 644 "$built/libextricate_c.a" "$prefix/lib"
filled() { sed -e "s/@VERSION@/$version/g; s/@MAJOR@/$major/g; s/@MINOR@/$minor/g; s/@SHARED@/$real/g" "$crate/cmake/$1"; }
filled extricate.pc >"$prefix/lib/pkgconfig/extricate.pc"
for name in extricateConfig.cmake extricateConfigVersion.cmake; do
    filled "$name" >"$prefix/lib/cmake/extricate/$name"
done
echo "installed extricate $version below $prefix"
