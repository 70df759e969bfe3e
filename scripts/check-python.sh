#!/usr/bin/env bash
# Builds the Python wheel, installs it into an empty virtual environment, and runs there what README.md, the tutorials and the how-to
# pages show, the tests, the type checks, the recipes, and a few scenes of the differential judge. Called by .ci/run; needs cargo, Python 3.9 or newer with pip, and a network.
#
# EXTRICATE_PROGRAM names the program that runs the command lines of the tutorials (default: the one that the tests have built); they
# are skipped where there is none.
# EXTRICATE_PYTHON names the interpreter (default: python3). The wheel is built with the profile of the tests, so that little is
# compiled twice; a released one is built with --release.
set -euo pipefail
cd "$(dirname "$0")/.."
work=target/python
crate=crates/extricate-python
rm -rf "$work"
mkdir -p "$work"

python=${EXTRICATE_PYTHON:-python3}
"$python" -m venv "$work/tools"
"$work/tools/bin/pip" install --quiet --disable-pip-version-check "maturin>=1.9.4,<2"
# The versions are those of bench/requirements.txt.
mapfile -t peers < <(grep -E "^(pin|coal)==" bench/requirements.txt)
# Packages are fetched in the background; missing ones are fetched when they are needed.
# The requirements of the package's extras, and a library of meshes.
asked=(pytest mypy tqdm mujoco usd-core pyarrow array-api-strict trimesh xacrodoc rosbags matplotlib rerun-sdk foxglove-sdk mcap-protobuf-support "${peers[@]}")
if [ "${EXTRICATE_RECIPES:-1}" = 1 ]; then asked+=(--requirement docs/recipes/requirements.txt); fi
"$work/tools/bin/pip" download --quiet --disable-pip-version-check --dest "$work/fetched" "${asked[@]}" >/dev/null 2>&1 &
fetching=$!
"$work/tools/bin/maturin" build --quiet --locked --profile dev --manifest-path "$crate/Cargo.toml" --out "$work/wheels"

# The list goes into a file: `grep -q` ends at once, and a program that still writes to it would fail.
"$python" -m zipfile --list "$work"/wheels/extricate-*.whl > "$work/listed"
for name in LICENSE-MIT LICENSE-APACHE; do
    grep -q "licenses/$name" "$work/listed" || { echo "the wheel has no $name" >&2; exit 1; }
done
# maturin lists what is compiled in, with versions and licences.
grep -q "sboms/.*cyclonedx.json" "$work/listed" || { echo "the wheel has no list of its parts (SBOM)" >&2; exit 1; }

"$python" -m venv "$work/venv"
wait "$fetching" || true
mkdir -p "$work/fetched"
pip() { "$work/venv/bin/pip" --disable-pip-version-check --quiet "$@"; }
pip install "$work"/wheels/extricate-*.whl
# Only the wheel and its requirements are installed so far.
program=${EXTRICATE_PROGRAM:-${CARGO_TARGET_DIR:-target}/debug/extricate}
[ -x "$program" ] || program=-
"$python" scripts/check-doc-blocks.py --self-test
"$python" scripts/check-doc-blocks.py "$program" "$work/venv/bin/python"

pip install --find-links "$work/fetched" pytest mypy tqdm mujoco usd-core pyarrow array-api-strict trimesh xacrodoc rosbags matplotlib rerun-sdk foxglove-sdk mcap-protobuf-support "${peers[@]}"
"$work/venv/bin/python" -m pytest --quiet "$crate/tests"
"$work/venv/bin/python" -m mypy --strict --package extricate
"$work/venv/bin/python" -m mypy --strict "$crate/tests/typed_user.py"
"$work/venv/bin/python" -m mypy.stubtest extricate --allowlist scripts/stubtest-allowlist.txt --ignore-unused-allowlist

"$work/venv/bin/python" bench/judge --scenes 60 --seconds 30

if [ "${EXTRICATE_RECIPES:-1}" = 1 ]; then
    pip install --find-links "$work/fetched" --requirement docs/recipes/requirements.txt
    MPLBACKEND=Agg "$work/venv/bin/python" -m pytest --quiet docs/recipes
fi
