#!/usr/bin/env bash
# Writes the script, the style and the licences of the report page, which the library includes. `build.sh FOLDER` writes them
# elsewhere, for comparison. Needs node and npm; `npm ci` brings the pinned packages.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
out=${1:-../src/output/report/page}
mkdir -p "$out"
[[ -d node_modules ]] || npm ci
npx esbuild src/main.js --bundle --minify --format=iife --target=chrome110,firefox113,safari16.4 --charset=ascii \
    --legal-comments=none --outfile="$out/page.js"
npx esbuild src/page.css --bundle --minify --charset=utf8 --outfile="$out/page.css"
{
    printf 'The script of this page contains three.js and uPlot.\n'
    for package in three uplot; do
        printf '\n%s %s\n\n' "$package" "$(node -p "require('./node_modules/$package/package.json').version")"
        cat "node_modules/$package/LICENSE"
    done
} >"$out/licences.txt"
