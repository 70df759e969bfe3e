#!/usr/bin/env bash
# Makes crates/extricate-view/page/three/three.min.js anew: three.js, bundled with only what entry.js names. Needs Node with npm, and a
# network. The result is committed, so that nobody else needs either. Other versions: change them here and in page/three/README.md.
set -euo pipefail
cd "$(dirname "$0")/../crates/extricate-view/page/three"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
npm install --silent --no-audit --no-fund --prefix "$work" three@0.187.0 esbuild@0.28.2
cp entry.js "$work/entry.js"
"$work/node_modules/.bin/esbuild" "$work/entry.js" --bundle --minify --format=iife --global-name=THREE --target=es2020 \
    --legal-comments=none --outfile=three.min.js
cp "$work/node_modules/three/LICENSE" LICENSE
