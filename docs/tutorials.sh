#!/usr/bin/env bash
# Follows the tutorials with GELFMU: docs/tutorials.sh GELFMU [PAGE...], some two minutes. Needs Python >= 3.11 with venv.
set -euo pipefail
root=$(realpath "$(dirname "$0")/..")
work=$root/target/site
mkdir -p "$work"

stamp=$(sha256sum <"$root/docs/tutorials/requirements.txt")
if [ "$(cat "$work/tutorials/stamp" 2>/dev/null)" != "$stamp" ]; then
    rm -rf "$work/tutorials"
    python3 -m venv "$work/tutorials"
    "$work/tutorials/bin/pip" install --quiet --disable-pip-version-check --require-hashes \
        ${WHEELS:+--no-index --find-links "$WHEELS"} -r "$root/docs/tutorials/requirements.txt"
    echo "$stamp" >"$work/tutorials/stamp"
fi
exec "$work/tutorials/bin/python" "$root/docs/site/run_tutorials.py" "$@"
