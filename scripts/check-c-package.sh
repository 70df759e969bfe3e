#!/usr/bin/env bash
# What `cargo cinstall` installs, used by projects outside of the source tree: by find_package, by pkg-config, and linked into the program.
# The libraries are installed into lib, lib64 and the folder of Debian's multiarch; then for Windows. Called by check-c.sh.
#
# Needs cargo-c, a C++17 compiler, pkg-config, CMake and binutils (readelf); for Windows rustup's target x86_64-pc-windows-gnu and mingw-w64.
set -euo pipefail
cd "$(dirname "$0")/.."
cargo cinstall --version >/dev/null || { echo "cargo-c is missing: cargo install cargo-c --locked" >&2; exit 1; }
unset LD_LIBRARY_PATH PKG_CONFIG_PATH
crate=$PWD/crates/extricate-c
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

version=$(sed -n 's/^version = "\(.*\)"/\1/p' Cargo.toml | head -n 1)
IFS=. read -r major minor _ <<<"$version"
# Before 1.0 every minor version may change the interface.
if [ "$major" = 0 ]; then number=0.$minor; else number=$major; fi

fail() { echo "$*" >&2; exit 1; }

# What FILE loads at run time of this library, or nothing.
loads() { readelf --dynamic "$1" | sed -n 's/.*NEEDED.*\[\(libextricate.*\)\]/\1/p'; }

expect_loads() {
    local found
    found=$(loads "$1")
    [ "$found" = "$2" ] || fail "$1 loads '$found', expected '$2'"
}

# Runs CMake with ARGUMENTS in FOLDER/build and builds; what it prints is shown if it fails.
cmake_builds() {
    local folder=$1
    shift
    { cmake -S "$folder" -B "$folder/build" "$@" && cmake --build "$folder/build" --parallel 2; } >"$folder/log" 2>&1 ||
        { tail -n 40 "$folder/log" >&2; fail "$folder does not build"; }
}

# Writes a project into FOLDER that has the examples of the crate, without that of OMPL.
copy_examples() {
    mkdir -p "$1"
    cp "$crate"/examples/CMakeLists.txt "$crate"/examples/{first_query.c,first_query.cpp,servo_guard.cpp,check_path.cpp} "$1"
}

# A project in C alone, which wants a version of the library.
write_c_project() {
    mkdir -p "$1"
    cp "$crate/examples/first_query.c" "$1"
    cat >"$1/CMakeLists.txt" <<CMAKE
cmake_minimum_required(VERSION 3.16)
project(c_alone C)
find_package(extricate $2 REQUIRED)
foreach(kind extricate static)
    add_executable(with_\${kind} first_query.c)
    target_link_libraries(with_\${kind} PRIVATE extricate::\${kind})
endforeach()
CMAKE
}

check_libdir() {
    local libdir=$1 here=$work/$1
    local prefix=$here/prefix
    echo "installed into $libdir"
    mkdir -p "$here"
    CARGO_TERM_QUIET=true cargo cinstall --locked --debug --package extricate-c --prefix="$prefix" --libdir="$libdir"
    local file
    for file in include/extricate.h include/extricate.hpp include/extricate_moveit.hpp share/licenses/extricate/LICENSE-{MIT,APACHE} \
        share/cmake/extricate/extricateConfig{,Version}.cmake "$libdir/libextricate_c.a" "$libdir/libextricate_c.so.$version"; do
        [ -s "$prefix/$file" ] || fail "$prefix/$file is missing or empty"
    done

    # pkg-config, and the shared library.
    local flags
    export PKG_CONFIG_PATH=$prefix/$libdir/pkgconfig
    [ "$(pkg-config --modversion extricate)" = "$version" ] || fail "pkg-config is not of version $version"
    flags=$(pkg-config --cflags --libs extricate)
    # shellcheck disable=SC2086
    ${CC:-cc} -std=c11 "$crate/examples/first_query.c" $flags -o "$here/by_pkg_config"
    expect_loads "$here/by_pkg_config" "libextricate_c.so.$number"
    LD_LIBRARY_PATH=$prefix/$libdir "$here/by_pkg_config" >/dev/null

    # pkg-config, linked in: the system's libraries are those of Libs.private.
    flags=$(pkg-config --static --cflags --libs extricate)
    [[ $flags == *-lpthread* || $flags == *-lgcc_s* ]] || fail "pkg-config --static names no library of the system: $flags"
    # shellcheck disable=SC2086
    ${CXX:-c++} -std=c++17 "$crate/examples/first_query.cpp" ${flags/-lextricate_c/-Wl,-Bstatic -lextricate_c -Wl,-Bdynamic} -o "$here/linked_in"
    expect_loads "$here/linked_in" ""
    "$here/linked_in" >/dev/null

    # find_package, after the folder was moved. C++17 comes from the targets: first_query.cpp is not C++11.
    mv "$prefix" "$here/moved"
    copy_examples "$here/examples"
    cmake_builds "$here/examples" -DCMAKE_PREFIX_PATH="$here/moved" -DCMAKE_DISABLE_FIND_PACKAGE_ompl=ON -DCMAKE_CXX_STANDARD=11
    expect_loads "$here/examples/build/first_query_c" "libextricate_c.so.$number"
    expect_loads "$here/examples/build/first_query_cpp" ""
    "$here/examples/build/first_query_c" >/dev/null
    "$here/examples/build/first_query_cpp" >/dev/null

    write_c_project "$here/c_alone" "$major.$minor"
    cmake_builds "$here/c_alone" -DCMAKE_PREFIX_PATH="$here/moved"
    "$here/c_alone/build/with_extricate" >/dev/null
    "$here/c_alone/build/with_static" >/dev/null
    local other
    for other in "$major.$((minor + 1))" "$((major + 1))"; do
        write_c_project "$here/version_$other" "$other"
        if cmake -S "$here/version_$other" -B "$here/version_$other/build" -DCMAKE_PREFIX_PATH="$here/moved" >"$here/log" 2>&1; then
            fail "version $version was found where $other is wanted"
        fi
        grep -q "version: $version" "$here/log" || { cat "$here/log" >&2; fail "CMake does not say that it found $version"; }
    done
}

# Installed alone, the static library is what pkg-config names.
check_static_alone() {
    local prefix=$work/static flags
    echo "the static library alone"
    CARGO_TERM_QUIET=true cargo cinstall --locked --debug --package extricate-c --library-type=staticlib --prefix="$prefix" --libdir=lib
    flags=$(PKG_CONFIG_PATH=$prefix/lib/pkgconfig pkg-config --cflags --libs extricate)
    # shellcheck disable=SC2086
    ${CXX:-c++} -std=c++17 "$crate/examples/first_query.cpp" $flags -o "$work/static_alone"
    expect_loads "$work/static_alone" ""
    "$work/static_alone" >/dev/null
}

check_windows() {
    local target=x86_64-pc-windows-gnu tools=x86_64-w64-mingw32 here=$work/windows
    if ! { rustup target list --installed | grep -qx "$target" || rustup target add "$target"; } || ! command -v "$tools-g++" >/dev/null; then
        echo "NOT CHECKED: $target, because rustup's target or mingw-w64 is missing" >&2
        return
    fi
    echo "installed for Windows"
    CARGO_TERM_QUIET=true cargo cinstall --locked --debug --package extricate-c --target "$target" --prefix="$here/prefix" --libdir=lib
    copy_examples "$here/examples"
    cmake_builds "$here/examples" -DCMAKE_SYSTEM_NAME=Windows -DCMAKE_C_COMPILER="$tools-gcc" -DCMAKE_CXX_COMPILER="$tools-g++" \
        -DCMAKE_PREFIX_PATH="$here/prefix" -DCMAKE_DISABLE_FIND_PACKAGE_ompl=ON
    "$tools-objdump" -p "$here/examples/build/first_query_c.exe" | grep -q "DLL Name: extricate_c.dll" ||
        fail "first_query_c.exe does not load extricate_c.dll"
    ! "$tools-objdump" -p "$here/examples/build/first_query_cpp.exe" | grep -q "DLL Name: extricate" ||
        fail "first_query_cpp.exe loads the library that is linked in"
}

check_libdir lib
check_libdir lib64
multiarch=$(${CC:-cc} -print-multiarch)
if [ -n "$multiarch" ]; then
    check_libdir "lib/$multiarch"
else
    echo "NOT CHECKED: multiarch, because ${CC:-cc} has none" >&2
fi
check_static_alone
check_windows
