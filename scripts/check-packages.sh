#!/usr/bin/env bash
# What would be published: crates, sdist and what belongs into them. Nothing is uploaded. Called by check-long.sh; needs cargo, Python 3.9 or
# newer with pip, and a network. EXTRICATE_PYTHON is as in check-python.sh.
#
# EXTRICATE_PACKAGES_BUILT=1 builds the packed crates, as `cargo publish` does, and installs the sdist as pip does where there is no wheel,
# which takes minutes. The second is held to a limit of processor time: three minutes on two cores.
set -euo pipefail
cd "$(dirname "$0")/.."
work=target/packages
rm -rf "$work"
mkdir -p "$work"
python=${EXTRICATE_PYTHON:-python3}

echo "crates"
verify=(--no-verify)
if [ -n "${EXTRICATE_PACKAGES_BUILT:-}" ]; then verify=(); fi
crates=(--package extricate --package extricate-view --package extricate-cli --package extricate-c)
# This also packs a working tree that was not committed.
cargo publish --dry-run --locked --allow-dirty "${verify[@]}" "${crates[@]}" 2>&1 | tee "$work/crates.log" | grep -vE "^ *(Packaging|Packaged|Updating|Verifying|Uploading|Downloaded|Downloading|Compiling|Finished)" | tee "$work/warnings.log" || true
if grep -vE "aborting upload due to dry run" "$work/warnings.log" | grep -E "^(warning|error)"; then
    echo "cargo publish has something to say" >&2
    exit 1
fi
grep -q "Packaged" "$work/crates.log" || { cat "$work/crates.log" >&2; exit 1; }
for crate in extricate extricate-view extricate-cli extricate-c; do
    cargo package --quiet --locked --allow-dirty --list --package "$crate" >"$work/files"
    for name in LICENSE-MIT LICENSE-APACHE README.md; do
        grep -qx "$name" "$work/files" || { echo "$crate has no $name" >&2; exit 1; }
    done
done

echo "sdist"
"$python" -m venv "$work/tools"
"$work/tools/bin/pip" install --quiet --disable-pip-version-check "maturin>=1.9.4,<2" twine cffconvert
"$work/tools/bin/maturin" sdist --manifest-path crates/extricate-python/Cargo.toml --out "$work/dist" >"$work/sdist.log" 2>&1 || { cat "$work/sdist.log" >&2; exit 1; }
# Metadata is checked without a wheel; check-python.sh builds one, and checks its licences.
"$work/tools/bin/twine" check --strict "$work"/dist/*
"$python" - "$work"/dist/*.tar.gz <<'PY'
import sys, tarfile
names = tarfile.open(sys.argv[1]).getnames()
root = names[0].split("/")[0]
wanted = ["LICENSE-MIT", "LICENSE-APACHE", "PKG-INFO", "pyproject.toml"]
missing = [name for name in wanted if f"{root}/{name}" not in names]
assert not missing, (missing, names[:20])
# Where links of git are no links, a licence would be a path.
licence = tarfile.open(sys.argv[1]).extractfile(f"{root}/LICENSE-MIT").read().decode()
assert "Permission is hereby granted" in licence, f"LICENSE-MIT: got {licence[:40]!r}, expected the text"
text = tarfile.open(sys.argv[1]).extractfile(f"{root}/PKG-INFO").read().decode()
assert "License-Expression: MIT OR Apache-2.0" in text and text.count("License-File:") >= 2, text[:800]
assert text.count("Project-URL: ") == 3, text[:2000]
PY

if [ -n "${EXTRICATE_PACKAGES_BUILT:-}" ]; then
    echo "sdist, installed from source"
    "$python" -m venv "$work/source"
    # The processor time is that of pip and all that it starts, because the computer may be busy with other programs.
    TIMEFORMAT="%R %U %S"
    { time env -u CARGO_TARGET_DIR "$work/source/bin/pip" install --quiet --disable-pip-version-check "$work"/dist/*.tar.gz >"$work/source.log" 2>&1; } 2>"$work/times" ||
        { cat "$work/source.log" >&2; exit 1; }
    awk '{ printf "%.0f s on the clock, %.0f s of processor time\n", $1, $2 + $3; exit $2 + $3 > 2 * 180 }' "$work/times" ||
        { echo "expected at most 360 s of processor time" >&2; exit 1; }
    (cd "$work" && source/bin/python -c 'import extricate; print("installed", extricate.__version__)')
fi

echo "citation"
"$work/tools/bin/cffconvert" --validate --infile CITATION.cff >/dev/null
version=$(grep -m1 '^version = ' Cargo.toml | cut -d'"' -f2)
grep -qx "version: $version" CITATION.cff || { echo "CITATION.cff is not of version $version" >&2; exit 1; }
