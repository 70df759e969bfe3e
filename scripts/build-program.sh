#!/usr/bin/env bash
# The program as it would be published: an archive with completions, manual pages, licences, and the list of its parts (SBOM).
#
#     scripts/build-program.sh [TARGET] [FOLDER]          default: this machine's, target/programs
#
# Writes FOLDER/extricate-VERSION-TARGET.tar.gz, and .zip for Windows. Needs cargo and Python 3.9 or newer. EXTRICATE_PROFILE names the
# profile (default: dist).
set -euo pipefail
cd "$(dirname "$0")/.."
host=$(rustc -vV | sed -n 's/^host: //p')
target=${1:-$host}
out=${2:-target/programs}
profile=${EXTRICATE_PROFILE:-dist}
version=$(sed -n 's/^version = "\(.*\)"/\1/p' Cargo.toml | head -n 1)
name=extricate-$version-$target

# The folder of the profile dev is called debug.
built=${CARGO_TARGET_DIR:-target}/$target/${profile/#dev/debug}/extricate
cargo build --locked --profile "$profile" --package extricate-cli --target "$target"
case $target in *windows*) suffix=.exe ;; *) suffix= ;; esac
folder=target/programs.parts/$name
rm -rf "$folder"
mkdir -p "$folder/completions" "$folder/man" "$out"
cp "$built$suffix" "$folder/"
cp -L LICENSE-MIT LICENSE-APACHE CITATION.cff CHANGELOG.md "$folder/"
cp crates/extricate-cli/README.md "$folder/"

# Another machine's program cannot run here; what it would write is the same for each.
if [ "$target" = "$host" ]; then
    for shell in bash elvish fish powershell zsh; do "$folder/extricate$suffix" completions "$shell" >"$folder/completions/extricate.$shell"; done
    bash -n "$folder/completions/extricate.bash"
    "$folder/extricate$suffix" man "$folder/man"
    "$folder/extricate$suffix" demo --export "$folder/tried" >/dev/null
    rm -rf "$folder/tried"
fi

python=python3
"$python" -c "" 2>/dev/null || python=python
"$python" scripts/list-parts.py extricate-cli --target "$target" --licences "$folder/LICENSE-third-party.txt" --sbom "$folder/extricate.cdx.json"

if [ -n "$suffix" ]; then
    "$python" -c 'import shutil, sys; shutil.make_archive(sys.argv[1], "zip", *sys.argv[2:])' "$out/$name" "$(dirname "$folder")" "$name"
    echo "$out/$name.zip"
else
    tar --create --gzip --owner=0 --group=0 --numeric-owner --file "$out/$name.tar.gz" --directory "$(dirname "$folder")" "$name" 2>/dev/null ||
        tar -czf "$out/$name.tar.gz" -C "$(dirname "$folder")" "$name"
    echo "$out/$name.tar.gz"
fi
