#!/usr/bin/env bash
# Wheels as they would be published: manylinux2014, for x86-64 and aarch64, by zig; and proof that the one for this machine installs into
# empty environments and passes the tests there. Takes long; .ci/run does not call it.
#
#     scripts/build-wheels.sh [FOLDER]          default: target/wheels
#
# EXTRICATE_PYTHONS is as in try-wheels.sh. EXTRICATE_PROFILE names the profile (default: dist). EXTRICATE_WHEELS names the targets (default: x86_64-unknown-linux-gnu aarch64-unknown-linux-gnu).
set -euo pipefail
cd "$(dirname "$0")/.."
out=${1:-target/wheels}
tools=$PWD/target/wheel-tools
manifest=crates/extricate-python/Cargo.toml
mkdir -p "$out"
rm -f "$out"/*.whl "$out"/*.tar.gz
[ -x "$tools/bin/pip" ] || python3 -m venv "$tools"
"$tools/bin/pip" install --quiet --disable-pip-version-check "maturin>=1.9.4,<2" ziglang auditwheel twine
export PATH=$tools/bin:$PATH

python3 scripts/list-parts.py extricate-python --licences crates/extricate-python/LICENSE-third-party.txt
for target in ${EXTRICATE_WHEELS:-x86_64-unknown-linux-gnu aarch64-unknown-linux-gnu}; do
    rustup target list --installed | grep -qx "$target" || rustup target add "$target"
    maturin build --locked --profile "${EXTRICATE_PROFILE:-dist}" --manifest-path "$manifest" --target "$target" --zig --compatibility manylinux2014 --out "$out"
done
maturin sdist --manifest-path "$manifest" --out "$out"
twine check --strict "$out"/*

for wheel in "$out"/*.whl; do
    shown=$(auditwheel show "$wheel" | tr '\n' ' ')
    # A wheel that also runs on older systems names their tags too; the first one counts.
    tag=$(grep -o '"manylinux[^"]*"' <<<"$shown" | head -n 1)
    case $tag in
        '"manylinux_2_17_'*) echo "$(basename "$wheel"): $tag" ;;
        *) echo "$wheel: auditwheel says ${shown}, expected manylinux_2_17" >&2; exit 1 ;;
    esac
    for name in LICENSE-MIT LICENSE-APACHE LICENSE-third-party.txt; do
        # Where links of git are no links, a licence would be a path.
        unzip -p "$wheel" "*/licenses/$name" | grep -E "Permission is hereby|TERMS AND CONDITIONS" >/dev/null || { echo "$wheel: expected a licence text in $name" >&2; exit 1; }
    done
done

scripts/try-wheels.sh "$out"
