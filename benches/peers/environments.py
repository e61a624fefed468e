"""The Python that runs a script: one virtual environment per peer with exactly the locked packages."""

import hashlib
import shutil
import subprocess
import sys
from pathlib import Path

from cases import HERE, ROOT

# The importer's packages are those with which the packed FMU is tested.
LOCKS = {name: HERE / f"requirements/{name}.txt" for name in ["taichi", "felupe", "kratos"]}
LOCKS["ours"] = ROOT / "tests/conformance/requirements.txt"
# What is no Python package: the interpreter that Debian's own packages belong to.
SYSTEM = {"dolfinx": Path("/usr/bin/python3")}
# Of what a failed command said; the reasons of pip and of an import stand at the end.
SAID_LINES = 8


class Unavailable(Exception):
    """What cannot be run here, and why."""


def interpreter(name, cache):
    """The Python of an environment, which is made below `cache` if it is not there yet."""
    if name in SYSTEM:
        return system_interpreter(name)
    key = hashlib.sha256(LOCKS[name].read_bytes() + sys.version.encode()).hexdigest()[:16]
    folder = cache / f"{name}-{key}"
    if not (folder / "complete").exists():
        shutil.rmtree(folder, ignore_errors=True)
        install(folder, LOCKS[name])
        (folder / "complete").write_text(sys.version)
    return folder / "bin/python"


def install(folder, lock):
    """Make a virtual environment and fill it from a lock."""
    print(f"installing {lock.relative_to(ROOT)} into {folder}", file=sys.stderr)
    expect([sys.executable, "-m", "venv", folder], "Debian has venv in the package python3-venv")
    pip = [folder / "bin/python", "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    expect([*pip, "--require-hashes", "--only-binary", ":all:", "-r", lock], "the lock is for CPython 3.11 on Linux, x86-64")


def system_interpreter(name):
    """The system's Python, if it has the package."""
    python = SYSTEM[name]
    expect([python, "-c", f"import {name}"], f"install the Debian package python3-{name}")
    return python


def expect(command, remedy):
    """Run a command; `Unavailable` with what to do and the last of what it said, if it fails."""
    try:
        ended = subprocess.run(list(map(str, command)), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    except OSError as error:
        raise Unavailable(f"{error}; {remedy}") from error
    if ended.returncode != 0:
        said = "\n".join(ended.stdout.strip().splitlines()[-SAID_LINES:])
        raise Unavailable(f"{' '.join(map(str, command))}: ended with {ended.returncode}; {remedy}\n{said}")
