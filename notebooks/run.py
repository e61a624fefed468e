"""Runner of the notebooks: executes each in a folder of its own, and prints its seconds.

    python notebooks/run.py [--save FOLDER] [NAME...]

Without names all of this folder. With --save the notebooks are written into a folder with their outputs, as the
documentation site shows them. The status is 1 if a cell raises an error, or if a notebook of this folder holds outputs.
It needs nbclient, ipykernel, and ballistic_gel with its extras, in this Python.
"""

import argparse
import os
import sys
import tempfile
import time
from pathlib import Path

import nbformat
from nbclient import NotebookClient
from nbclient.exceptions import CellExecutionError

HERE = Path(__file__).resolve().parent
# Wall-clock seconds of one cell, after which a notebook counts as hung.
LIMIT = 900


def main() -> int:
    """Run the notebooks that are named and return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", help="notebooks, without folder and ending (all if absent)")
    parser.add_argument("--save", type=Path, metavar="FOLDER", help="folder for the notebooks with their outputs")
    options = parser.parse_args()
    names = options.names or sorted(path.stem for path in HERE.glob("*.ipynb"))
    failed = [name for name in names if not passes(name, options.save)]
    print(f"{len(names) - len(failed)} of {len(names)} notebooks passed", *failed, sep="\nfailed: ")
    return 1 if failed else 0


def passes(name: str, saved: Path | None) -> bool:
    """Execute a notebook, save it with its outputs, print its result, and return True if no cell failed."""
    begun, spent = time.perf_counter(), seconds_of_children()
    notebook = nbformat.read(HERE / f"{name}.ipynb", as_version=4)
    reason = execute(notebook)
    if saved is not None:
        saved.mkdir(parents=True, exist_ok=True)
        nbformat.write(notebook, saved / f"{name}.ipynb")
    wall, work = time.perf_counter() - begun, seconds_of_children() - spent
    print(f"{name}: {reason or 'passed'}, {wall:.1f} s, {work:.1f} s of the processors", flush=True)
    return reason is None


def execute(notebook: nbformat.NotebookNode) -> str | None:
    """Execute a notebook in a temporary folder, put in its outputs, and return the reason of its failure."""
    nbformat.validate(notebook)
    if any(cell.get("outputs") for cell in notebook.cells):
        return "it holds outputs: clear them before it is saved"
    with tempfile.TemporaryDirectory(prefix="notebook-", ignore_cleanup_errors=True) as folder:
        client = NotebookClient(notebook, timeout=LIMIT, resources={"metadata": {"path": folder}})
        try:
            client.execute()
        except CellExecutionError as error:
            return f"failed:\n{error}"
        except TimeoutError:
            return f"a cell took more than {LIMIT} s"
    return None


def seconds_of_children() -> float:
    """Return the processor seconds of all kernels that have ended, s."""
    times = os.times()
    return times.children_user + times.children_system


if __name__ == "__main__":
    sys.exit(main())
