#!/usr/bin/env bash
# A release without its uploads, in a fresh clone: every artefact that this machine can make, installed into empty environments, tested
# and checked. RELEASING.md says what comes before and after.
#
#     scripts/release-dry-run.sh [STEP...]          all of: version workflows sources crates program wheels site debian recipes
#
# The clone is target/dry-run, of the last commit; there the placeholder of the addresses gets a name, and the changelog a version. Its
# builds go into CARGO_TARGET_DIR, if that is set. EXTRICATE_PROFILE=dev builds quickly. Nothing is left out silently.
set -euo pipefail
cd "$(dirname "$0")/.."
[ -z "$(git status --porcelain)" ] || echo "NOT IN IT: what is not committed" >&2
clone=$PWD/target/dry-run
rm -rf "$clone"
git clone --quiet . "$clone"
cd "$clone"
version=$(sed -n 's/^version = "\(.*\)"/\1/p' Cargo.toml | head -n 1)
sed -i s/OWNER/dry-run/ Cargo.toml
sed -i "s/^## Unreleased.*/## $version/" CHANGELOG.md
git -c user.name=dry-run -c user.email=dry-run@example.org commit --quiet --all --message "the release, as a dry run"
git tag "v$version"
out=$PWD/target/release-files
mkdir -p "$out"
export EXTRICATE_PROFILE=${EXTRICATE_PROFILE:-dist}

version() {
    scripts/check-release.sh "v$version"
    scripts/check-semver.sh
}

workflows() { scripts/check-workflows.sh; }

sources() { scripts/build-source.sh "$out"; }

program() {
    local archive unpacked
    archive=$(scripts/build-program.sh "$(rustc -vV | sed -n 's/^host: //p')" "$out" | tail -n 1)
    unpacked=$(mktemp -d)
    tar -xzf "$archive" -C "$unpacked" --strip-components 1
    for name in LICENSE-MIT LICENSE-APACHE LICENSE-third-party.txt extricate.cdx.json man/extricate.1 completions/extricate.bash; do
        [ -s "$unpacked/$name" ] || { echo "$archive has no $name" >&2; exit 1; }
    done
    "$unpacked/extricate" demo --export "$unpacked/cell"
    "$unpacked/extricate" sample "$unpacked/cell/shelf-arm.toml" -n 2 --seed 3 --colliding | "$unpacked/extricate" query "$unpacked/cell/shelf-arm.toml" --input -
    rm -rf "$unpacked"
}

crates() {
    # Built as their users build them, unless it has to be quick.
    local built=1
    [ "$EXTRICATE_PROFILE" != dev ] || built=
    EXTRICATE_PACKAGES_BUILT=$built scripts/check-packages.sh
}

wheels() {
    EXTRICATE_WHEELS=$(rustc -vV | sed -n 's/^host: //p') scripts/build-wheels.sh target/wheels
    cp target/wheels/* "$out/"
    echo "NOT BUILT: wheels of other platforms (.github/workflows/wheels.yml)" >&2
}

site() { EXTRICATE_DRY_RUN=1 scripts/publish-site.sh "v$version"; }

debian() {
    [ "$EXTRICATE_PROFILE" != dev ] || export DEB_BUILD_OPTIONS=noopt
    scripts/build-debian.sh target/debian
}

recipes() {
    python3 scripts/write-packaging.py --artefacts "$out" --out "$out/packaging" --allow-missing
    python3 -m venv target/yaml-venv
    target/yaml-venv/bin/pip install --quiet --disable-pip-version-check pyyaml
    target/yaml-venv/bin/python - "$out/packaging" <<'PY'
import pathlib, sys, yaml
for path in pathlib.Path(sys.argv[1]).rglob("*.yaml"):
    assert isinstance(yaml.safe_load(path.read_text(encoding="utf-8")), dict), path
PY
}

[ $# -gt 0 ] || set -- version workflows sources program crates wheels site debian recipes
for step in "$@"; do
    case $step in
        version | workflows | sources | program | crates | wheels | site | debian | recipes)
            printf '\n== %s\n' "$step"
            started=$SECONDS
            "$step"
            echo "$step: $((SECONDS - started)) s"
            ;;
        *) echo "got the step $step, expected version, workflows, sources, program, crates, wheels, site, debian or recipes" >&2; exit 2 ;;
    esac
done
printf '\nwould publish %s, after: %s\n' "$version" "$*"
(cd "$out" && find . -type f | sort | xargs --no-run-if-empty sha256sum)
