#!/usr/bin/env bash
# Publishes the site on the branch gh-pages, one folder a version. The tag v1.2.3 becomes 1.2.3, the latest; anything else is `dev`.
#
#     scripts/publish-site.sh v1.2.3 | main
#
# EXTRICATE_DRY_RUN=1 commits to the branch and does not push it.
set -euo pipefail
cd "$(dirname "$0")/.."
name=${1:?expected a tag or a branch}
scripts/build-site.sh
git config user.name >/dev/null || git config user.name extricate
git config user.email >/dev/null || git config user.email extricate@example.org
push=(--push)
if [ -n "${EXTRICATE_DRY_RUN:-}" ]; then push=(); fi
# mike calls the mkdocs that is first in PATH.
mike() { NO_MKDOCS_2_WARNING=1 PATH="$PWD/target/docs-venv/bin:$PATH" target/docs-venv/bin/mike "$@"; }
case $name in
    v[0-9]*)
        mike deploy "${push[@]}" --update-aliases "${name#v}" latest
        mike set-default "${push[@]}" latest
        ;;
    *) mike deploy "${push[@]}" dev ;;
esac
