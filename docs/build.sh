#!/usr/bin/env bash
# Builds the documentation site: docs/build.sh GELFMU [OUT], e.g. docs/build.sh target/release/gelfmu target/site/html
#
# Needs Python >= 3.11 with venv, and node with npm. The reference is printed by GELFMU. Any warning is an error, and so
# is a page that would load anything from elsewhere. The tools go into target/site; WHEELS=FOLDER takes those of Python
# from a folder instead of the package index. NOTEBOOKS=FOLDER shows the notebooks that `notebooks/run.py --save FOLDER`
# left there, with their outputs; without it they are shown without. The live report is that of the first 0.25 ms of `fbi-bb-3d`, run here.
set -euo pipefail

gelfmu=$(realpath "$1")
root=$(realpath "$(dirname "$0")/..")
out=$(realpath -m "${2:-$root/target/site/html}")
work=$root/target/site
mkdir -p "$work/npm"

"$root/docs/site/venv.sh" "$work/venv" "$root/docs/requirements.txt"
if ! cmp -s "$root/docs/site/package-lock.json" "$work/npm/package-lock.json"; then
    cp "$root/docs/site/package.json" "$root/docs/site/package-lock.json" "$work/npm/"
    npm ci --prefix "$work/npm" --silent --no-audit --no-fund || { rm "$work/npm/package-lock.json"; exit 1; }
fi

rm -rf "$out" "$work/reference" "$work/live" "$root/docs/notebooks"
mkdir "$root/docs/notebooks"
cp "${NOTEBOOKS:-$root/notebooks}"/*.ipynb "$root/docs/notebooks"
"$work/venv/bin/python" "$root/docs/site/reference.py" "$gelfmu" "$work/reference"
KATEX=$work/npm/node_modules/katex "$work/venv/bin/sphinx-build" --quiet --fail-on-warning --keep-going --nitpicky \
    --fresh-env --doctree-dir "$work/doctrees" -b html "$root/docs" "$out"
"$gelfmu" run fbi-bb-3d --set scene.end_time=0.25e-3 --quiet --force --out "$work/live"
cp "$work/live/report.html" "$out/live-report.html"
"$work/venv/bin/python" "$root/docs/site/check_site.py" "$out"
echo "built $out/index.html"
