#!/usr/bin/env bash
# The wheel of the Python package, which holds the program gelfmu: `build/wheel.sh OPTION...`, options of `maturin build`.
#
#     build/wheel.sh --compatibility linux --out target/python/wheels    # for this machine
#
# Needs Rust and Python >= 3.11 with venv. It gets maturin itself, pinned, into a folder beside the registry of cargo.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

TOOLS="${BALLISTIC_GEL_TOOLS:-${CARGO_HOME:-$HOME/.cargo}/ballistic-gel-ci}"
VERSION=$(sed -n 's/^maturin==//p' build/wheel.in)
venv="$TOOLS/maturin-$VERSION"

if [[ ! -x "$venv/ok" ]]; then
    rm -rf "$venv"
    python3 -m venv "$venv"
    "$venv/bin/pip" install --quiet --require-hashes --only-binary :all: --requirement build/wheel.txt
    ln -s bin/python "$venv/ok"
fi
"$venv/bin/maturin" build --release --locked "$@"
