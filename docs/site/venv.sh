#!/usr/bin/env bash
# The environment of a pinned list of packages: docs/site/venv.sh FOLDER REQUIREMENTS. It is kept until the list changes.
# WHEELS=FOLDER takes the packages from a folder instead of the package index.
set -euo pipefail
stamp=$(sha256sum <"$2")
[ "$(cat "$1/stamp" 2>/dev/null)" != "$stamp" ] || exit 0
rm -rf "$1"
python3 -m venv "$1"
"$1/bin/pip" install --quiet --disable-pip-version-check --require-hashes \
    ${WHEELS:+--no-index --find-links "$WHEELS"} -r "$2"
echo "$stamp" >"$1/stamp"
