#!/usr/bin/env bash
# Makes the moving picture of the landing page: docs/pictures/movie.sh GELFMU FOLDER (some 20 s; needs ffmpeg)
set -euo pipefail
"$1" --quiet run fbi-bb --set scene.end_time=2.6e-3 --set output.frames=53 --no-report --force --out "$2/movie"
"$1" --quiet movie "$2/movie" --rate 12 --force --out "$2/movie.gif"
ffmpeg -v error -y -i "$2/movie.gif" -vf "crop=736:560:112:20,scale=600:-1" -c:v libwebp_anim -loop 0 -q:v 70 \
    "$(dirname "$0")/fbi-bb.webp"
