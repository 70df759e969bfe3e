#!/usr/bin/env bash
# extricate.fleet and extricate.rows on a Ray cluster of two local nodes, one of which is killed in the middle, on Dask and on local processes;
# then how both scale over two cores, which is told and not held to a limit: other programs may use them too. Called by check-long.sh.
#
#     scripts/check-fleet.sh [FOLDER]           with the wheel for this machine; default: target/wheels
set -euo pipefail
cd "$(dirname "$0")/.."
wheels=${1:-target/wheels}
venv=$(mktemp -d)
trap 'rm -rf "$venv"' EXIT
"${EXTRICATE_PYTHON:-python3}" -m venv "$venv"
"$venv/bin/pip" install --quiet --disable-pip-version-check --find-links "$wheels" --pre "extricate[ray,parquet]" pytest "ray[data]" "dask[distributed]" joblib "jax[cpu]" array-api-strict
"$venv/bin/python" -m pytest --quiet crates/extricate-python/tests/test_fleet.py crates/extricate-python/tests/test_rows.py | tee "$venv/said"
# Without Ray, its tests would be skipped.
if grep -q skipped "$venv/said"; then echo "a test was left out" >&2; exit 1; fi
"$venv/bin/python" bench/fleet.py
"$venv/bin/python" bench/rows.py --rows 100000 --block 8192
for place in ray ray-data; do "$venv/bin/python" docs/recipes/release_rows.py --folder "$venv" --on "$place"; done
