#!/usr/bin/env bash
# Follows the tutorials with GELFMU: docs/tutorials.sh GELFMU [PAGE...], some two minutes. Needs Python >= 3.11 with venv.
set -euo pipefail
root=$(realpath "$(dirname "$0")/..")
work=$root/target/site
mkdir -p "$work"

"$root/docs/site/venv.sh" "$work/tutorials" "$root/docs/tutorials/requirements.txt"
exec "$work/tutorials/bin/python" "$root/docs/site/run_tutorials.py" "$@"
