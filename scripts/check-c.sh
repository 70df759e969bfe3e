#!/usr/bin/env bash
# The C and C++ interface: installs it into an empty folder, builds what is in crates/extricate-c/examples and tests/cpp as users do
# (pkg-config, CMake), under AddressSanitizer and UndefinedBehaviorSanitizer, and runs it. Answers are compared with those of the
# program, to the last bit.
#
# Needs Python 3 and what check-c-package.sh needs; for the rest Eigen and OMPL (Debian: libeigen3-dev libompl-dev and some of boost), which are
# used if they are there. If CI is set, Debian's packages are installed. EXTRICATE_PROGRAM is as in check-python.sh. EXTRICATE_VALGRIND=1 runs
# the tests under valgrind as well, which takes minutes.
set -euo pipefail
cd "$(dirname "$0")/.."
cargo cinstall --version >/dev/null || { echo "cargo-c is missing: cargo install cargo-c --locked" >&2; exit 1; }
work=target/c
crate=crates/extricate-c
rm -rf "$work"
mkdir -p "$work"
work=$(cd "$work" && pwd)

missing=()
checker=()
if [ -n "${EXTRICATE_VALGRIND:-}" ]; then checker=(valgrind); fi
for package in "${checker[@]}" cmake mingw-w64 libeigen3-dev libompl-dev libboost-serialization-dev libboost-filesystem-dev libboost-system-dev; do
    dpkg -s "$package" >/dev/null 2>&1 || missing+=("$package")
done
if [ ${#missing[@]} -gt 0 ] && [ -n "${CI:-}" ]; then
    apt-get update -qq
    DEBIAN_FRONTEND=noninteractive apt-get -o DPkg::Lock::Timeout=300 install -y -qq --no-install-recommends "${missing[@]}" >"$work/apt.log"
fi

# Built as the tests are: with assertions.
CARGO_TERM_QUIET=true cargo cinstall --locked --debug --package extricate-c --prefix="$work/prefix" --libdir=lib
export PKG_CONFIG_PATH=$work/prefix/lib/pkgconfig LD_LIBRARY_PATH=$work/prefix/lib
flags=$(pkg-config --cflags --libs extricate)
warnings="-Wall -Wextra -Wpedantic -Werror"
sanitized="-O1 -g -fsanitize=address,undefined -fno-sanitize-recover=undefined"
eigen=$(pkg-config --cflags eigen3 2>/dev/null | sed 's/-I/-isystem /' || true)

echo "plain C, and C++ without exceptions"
# shellcheck disable=SC2086
${CC:-cc} -std=c11 $warnings "$crate/examples/first_query.c" $flags -o "$work/first_query_c"
"$work/first_query_c"
# shellcheck disable=SC2086
${CXX:-c++} -std=c++17 -fno-exceptions $warnings -Iros/stubs "$crate/tests/cpp/no_exceptions.cpp" $flags -pthread -o "$work/no_exceptions"
(cd "$work" && ./no_exceptions)

program=${EXTRICATE_PROGRAM:-${CARGO_TARGET_DIR:-target}/debug/extricate}
echo "C++ under AddressSanitizer, beside $program"
"$program" demo --export "$work/cell" >/dev/null
scene=$work/cell/shelf-arm.toml
"$program" sample "$scene" -n 12 --colliding --seed 5 >"$work/q.jsonl"
python3 -c 'import json, sys; [print(*map(repr, json.loads(line)["q"])) for line in sys.stdin]' <"$work/q.jsonl" >"$work/q.txt"
# shellcheck disable=SC2086
${CXX:-c++} -std=c++17 $warnings $sanitized $eigen "$crate/tests/cpp/interface.cpp" $flags -pthread -o "$work/interface"
"$work/interface" "$scene" "$work/q.txt" "$work" >"$work/answers.txt"
"$program" query "$scene" --input "$work/q.jsonl" --json >"$work/answers.jsonl"
"$program" escape "$scene" --input "$work/q.jsonl" --json >"$work/escapes.jsonl" || [ $? = 1 ]
row() { sed -n "$1p" "$work/q.txt" | tr ' ' ','; }
"$program" plan "$scene" --from="$(row 2)" --to="$(row 6)" --max-checks 20000 --json >"$work/plan.json" || [ $? = 1 ]
"$program" repair "$scene" --path <(head -n 3 "$work/q.txt") --json >"$work/repair.json" || [ $? = 1 ]
python3 - "$work" <<'PY'
import itertools, json, pathlib, sys
folder = pathlib.Path(sys.argv[1])
ours = [[float.fromhex(x) for x in line.split()] for line in open(folder / "answers.txt")]
def rows(name):
    return [json.loads(line) for line in open(folder / name)]
theirs = [[row["depth"], row["lower_bound"], *row["witness"]] for row in rows("answers.jsonl") if "depth" in row]
paths = [list(itertools.chain(*row["points"])) for row in rows("escapes.jsonl") + rows("plan.json") + rows("repair.json")]
assert len(theirs) == 12 and ours[:12] == theirs, (ours[:12], theirs)
assert len(paths) == 14 and ours[12:] == paths, (ours[12:], paths)
print(f"{len(theirs)} answers and {len(paths)} paths ({sum(map(bool, paths))} found), equal to those of the program in every bit")
PY
if echo '#include <Eigen/Core>' | ${CXX:-c++} $eigen -std=c++17 -x c++ -fsyntax-only - 2>/dev/null; then
    for layout in 0 1 2 3 4; do
        # shellcheck disable=SC2086
        if ${CXX:-c++} -std=c++17 $eigen -DLAYOUT=$layout "$crate/tests/cpp/layouts.cpp" $flags -fsyntax-only 2>"$work/layout.txt"; then
            [ "$layout" = 0 ] || { echo "layout $layout compiles, and would be read as other numbers"; exit 1; }
        else
            [ "$layout" != 0 ] && grep -q "static assertion.*extricate: " "$work/layout.txt" || { cat "$work/layout.txt"; exit 1; }
        fi
    done
    echo "matrices and vectors of Eigen that lie apart in memory do not compile"
else
    echo "Eigen is not there: its layouts were not tried"
    [ -z "${CI:-}" ]
fi
if [ -n "${EXTRICATE_VALGRIND:-}" ]; then
    # shellcheck disable=SC2086
    ${CXX:-c++} -std=c++17 -O1 -g "$crate/tests/cpp/interface.cpp" $flags -pthread -o "$work/interface_plain"
    echo "C++ under valgrind"
    valgrind --quiet --error-exitcode=9 --leak-check=full --show-leak-kinds=definite --errors-for-leak-kinds=definite \
        "$work/interface_plain" "$scene" <(head -n 6 "$work/q.txt") "$work" >/dev/null
fi

echo "messages of MoveIt, and 200 planning requests with stubs in the place of MoveIt and ROS"
# shellcheck disable=SC2086
${CXX:-c++} -std=c++17 $warnings $sanitized -Iros/stubs "$crate/tests/cpp/moveit.cpp" $flags -pthread -o "$work/moveit"
"$work/moveit" "$crate/tests/messages"
mkdir -p "$work/cell/install"
ln -sfn .. "$work/cell/install/share"
# shellcheck disable=SC2086
${CXX:-c++} -std=c++17 $warnings $sanitized -Iros/stubs ros/extricate_moveit/src/*.cpp ros/stubs/requests.cpp $flags -pthread \
    -o "$work/requests"
"$work/requests" "$work/cell"

echo "the examples, by CMake, under AddressSanitizer"
cmake -S "$crate/examples" -B "$work/examples" -DCMAKE_PREFIX_PATH="$work/prefix" -DCMAKE_C_FLAGS="$sanitized" \
    -DCMAKE_CXX_FLAGS="$sanitized" >"$work/cmake.log"
cmake --build "$work/examples" --parallel 2 >>"$work/cmake.log" || { tail -n 40 "$work/cmake.log"; exit 1; }
"$work/examples/first_query_c"
"$work/examples/first_query_cpp"
"$work/examples/servo_guard" "$scene" 200
"$work/examples/check_path"
sed -n '1,3p' "$work/q.txt" >"$work/path.txt"
"$work/examples/check_path" "$scene" "$work/path.txt" >/dev/null
if [ -x "$work/examples/ompl_start_repair" ]; then
    "$work/examples/ompl_start_repair"
else
    echo "OMPL is not there: its example was not built"
    [ -z "${CI:-}" ]
fi

echo "the installed package, in projects outside of the source tree"
scripts/check-c-package.sh
