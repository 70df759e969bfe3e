#!/usr/bin/env bash
# Checks what a release needs before anything of it is built: one version everywhere, an address, a changelog of this version.
#
#     scripts/check-release.sh v1.2.3
set -euo pipefail
cd "$(dirname "$0")/.."
tag=${1:?expected the tag of the release, such as v1.2.3}
version=$(sed -n 's/^version = "\(.*\)"/\1/p' Cargo.toml | head -n 1)
faults=0
fault() {
    echo "$*" >&2
    faults=1
}

[ "$tag" = "v$version" ] || fault "got the tag $tag, expected v$version: the version in Cargo.toml"
grep -qx "version: $version" CITATION.cff || fault "CITATION.cff: expected version: $version"
grep -q "<version>$version</version>" ros/extricate_moveit/package.xml || fault "ros/extricate_moveit/package.xml: expected <version>$version</version>"
grep -q "version = {$version}" docs/how-to/cite.md || fault "docs/how-to/cite.md: expected version = {$version}"
dependencies=$(grep -c "^extricate.*version = \"$version\"" Cargo.toml)
[ "$dependencies" = 2 ] || fault "Cargo.toml: got $dependencies dependencies on version $version of the project's own crates, expected 2"
grep -qE "^## $version( |$)" CHANGELOG.md || fault "CHANGELOG.md: expected a heading '## $version', not 'Unreleased'"
! grep -qE '^(repository|homepage|documentation) = .*OWNER' Cargo.toml || fault "Cargo.toml: got OWNER in an address, expected who publishes (RELEASING.md)"
exit "$faults"
