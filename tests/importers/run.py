"""Runs one packed FMU in every importer that installs from PyPI or with cargo, and compares bits.

    python3 tests/importers/run.py GELFMU [--only NAME,..] [--csv FILE]

Packs scenes with GELFMU, installs the importers once (Python: requirements.txt, Rust: rust/), and drives each archive
in each importer with the same communication steps. Impulse, velocity and state must have the bits of the reference, a
plain loop over the C functions. Prints a row for each importer and scene, with the messages of the importer about the
archive, which fail it. An importer that cannot be installed on this platform is skipped. Needs cargo, a C compiler and Python >= 3.11
with venv.
"""

import argparse
import csv
import dataclasses
import hashlib
import json
import os
import platform
import re
import shutil
import struct
import subprocess
import sys
import tempfile
import time
import tomllib
from pathlib import Path

HERE = Path(__file__).resolve().parent
TARGET = HERE.parents[1] / "target" / "importers"
LOCK = HERE / "requirements.txt"
RUST = HERE / "rust"
LIMIT = 120.0  # of one importer on one scene, s


@dataclasses.dataclass
class Scene:
    """Built-in scene, options of `gelfmu pack`, and the communication steps to take; step in s."""

    name: str
    options: list[str]
    step: float
    steps: int


@dataclasses.dataclass
class Importer:
    """Importer and the package that holds it: a distribution of PyPI, or a crate for a program in rust/."""

    name: str
    package: str
    is_crate: bool = False
    without_aarch64: bool = False


def value(bits):
    """Double of its 16 hexadecimal digits."""
    return struct.unpack(">d", bytes.fromhex(bits))[0]


@dataclasses.dataclass
class Row:
    """Outcome of one importer on one scene. Values are in the order of drive.py's WATCHED."""

    importer: str
    version: str
    scene: str
    outcome: str = "passed"
    bits: list[str] = dataclasses.field(default_factory=list)
    state: str = ""
    messages: list[str] = dataclasses.field(default_factory=list)
    seconds: float = 0.0

    def cells(self):
        """Columns of the matrix by name."""
        values = [f"{value(bits):.17g}" for bits in self.bits] or ["", ""]
        impulse, velocity = self.bits or ["", ""]
        return {
            "importer": self.importer, "version": self.version, "scene": self.scene, "J [N s]": values[0],
            "bits of J": impulse, "v [m/s]": values[1], "bits of v": velocity, "state": self.state,
            "messages": len(self.messages), "s": f"{self.seconds:.1f}", "outcome": self.outcome,
            "first message": self.messages[0] if self.messages else "",
        }


SCENES = [Scene("sphere-block", [], 2e-5, 100), Scene("fbi-bb", ["--set", "scene.end_time=4e-4"], 2e-5, 20)]
REFERENCE = Importer("reference", "fmpy")
IMPORTERS = [
    Importer("fmpy", "fmpy"),
    Importer("fmu-manipulation-toolbox", "fmu-manipulation-toolbox"),
    Importer("libcosim", "libcosimpy"),
    Importer("ecos", "ecospy"),
    Importer("mosaik", "mosaik"),
    Importer("helics", "helics"),
    Importer("fmi-rs", "fmi-rs", is_crate=True),
    Importer("fmu-runner", "fmu-runner", is_crate=True, without_aarch64=True),
    Importer("rust-fmi", "fmi", is_crate=True, without_aarch64=True),
]
UNAVAILABLE = {
    "OMSimulator": "PyPI has a source package alone, which downloads the library from elsewhere while it is built",
    "PyFMI": "PyPI has a source package alone, which needs the C library FMI Library",
}
# Lines that an importer prints about itself, and stamps before its messages. The container complains of ports that it makes itself.
CHATTER = re.compile(r"\s*$|\[WARNING\] (FMUContainer 'V|Container use )|\[ERROR\] Solver configure")
OWN_FAULT = re.compile(r"ERROR Cannot expose FMI-2 array aggregate ")
STAMP = re.compile(r"\[\d{4}-[^]]*\] \[0x[0-9a-f]+\] ")


def output(*command, remedy="see its message", **options):
    """Standard output of a command; its failure ends the run with the remedy."""
    try:
        done = subprocess.run([str(part) for part in command], capture_output=True, text=True, timeout=1800, **options)
    except OSError as error:
        raise SystemExit(f"{command[0]}: {error.strerror}; {remedy}") from None
    if done.returncode != 0:
        raise SystemExit(f"{command[0]} ended with {done.returncode}; {remedy}\n{done.stdout}{done.stderr}")
    return done.stdout


def install_python():
    """Interpreter of the virtual environment of the lock file, which is made once."""
    key = hashlib.sha256(LOCK.read_bytes() + sys.version.encode()).hexdigest()[:16]
    venv = Path(os.environ.get("BALLISTIC_GEL_TOOLS", TARGET)).resolve() / f"importers-{key}"
    python = venv / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    if not (venv / "complete").exists():
        shutil.rmtree(venv, ignore_errors=True)
        output(sys.executable, "-m", "venv", venv, remedy="Debian has venv in the package python3-venv")
        output(python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--require-hashes",
               "--only-binary", ":all:", "--requirement", LOCK, remedy=f"see that PyPI can be reached, and {LOCK}")
        (venv / "complete").touch()
    return python


def install_rust(python):
    """Folder of the Rust programs. The crate fmi-sys needs libclang; the wheel libclang has it, without C headers."""
    environment = dict(os.environ)
    clang = output(python, "-c", "import clang, pathlib; print(pathlib.Path(clang.__path__[0]) / 'native')").strip()
    environment.setdefault("LIBCLANG_PATH", clang)
    if sys.platform == "linux":
        headers = output("cc", "-print-file-name=include", remedy="install a C compiler (Debian: gcc)").strip()
        environment.setdefault("BINDGEN_EXTRA_CLANG_ARGS", f"-I{headers}")
    target = TARGET / "rust"
    output("cargo", "build", "--release", "--locked", "--manifest-path", RUST / "Cargo.toml", "--target-dir", target,
           env=environment, remedy="install Rust, and see that its registry can be reached")
    return target / "release"


def installed_versions(python):
    """Versions of the distributions in the virtual environment and of the locked crates."""
    listed = json.loads(output(python, "-m", "pip", "list", "--format", "json", "--disable-pip-version-check"))
    crates = tomllib.loads((RUST / "Cargo.lock").read_text())["package"]
    versions = {crate["name"]: crate["version"] for crate in crates}
    return versions | {each["name"].lower().replace("_", "-"): each["version"] for each in listed}


def reason_to_skip(importer, versions):
    """Reason why an importer cannot run on this platform; None where it can."""
    if importer.package not in versions:
        return f"no wheel of {importer.package} for {sys.platform} {platform.machine()}, see requirements.in"
    if importer.without_aarch64 and (sys.platform, platform.machine()) == ("linux", "aarch64"):
        return "it looks for the library in binaries/linux64 on aarch64"
    return None


def drive(command, scene, archive, row):
    """Runs an importer on an archive; fills the row."""
    folder = Path(tempfile.mkdtemp(prefix=f"{row.importer}-", dir=archive.parent))
    environment = os.environ | {"TMPDIR": str(folder), "NO_COLOR": "1"}
    whole = [*command, archive, repr(scene.step), str(scene.steps), folder]
    start = time.monotonic()
    try:
        done = subprocess.run(whole, env=environment, timeout=LIMIT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                              text=True, errors="replace")
    except subprocess.TimeoutExpired:
        row.outcome = f"failed: found no end after {LIMIT:g} s"
        return
    row.seconds = time.monotonic() - start
    row.messages = [STAMP.sub("", line).strip() for line in done.stdout.splitlines() if not CHATTER.match(line)]
    if done.returncode != 0 or not (folder / "values").exists():
        row.outcome = f"failed: ended with status {done.returncode}"
        print(f"{row.importer} on {scene.name}:\n{done.stdout}", flush=True)
        return
    row.bits = (folder / "values").read_text().split()
    if (folder / "state").exists():
        row.state = hashlib.sha256((folder / "state").read_bytes()).hexdigest()[:16]
    shutil.rmtree(folder, ignore_errors=True)


def compare(row, reference):
    """Marks a row as failed whose bits are not those of the reference."""
    if row.outcome != "passed":
        return
    if not reference.bits:
        row.outcome = "failed: found no bits of the reference, expected a run of it"
    elif row.bits != reference.bits:
        row.outcome = f"failed: found bits {' '.join(row.bits)}, expected {' '.join(reference.bits)}"
    elif row.state and row.state != reference.state:
        row.outcome = f"failed: found state {row.state}, expected {reference.state}"
    elif complaints := [message for message in row.messages if not OWN_FAULT.match(message)]:
        row.outcome = f"failed: found the message {complaints[0]!r}, expected none about the archive"
    elif value(row.bits[0]) == 0.0:
        row.outcome = "failed: found no impulse, expected contact"


def print_matrix(rows):
    """Prints the rows in aligned columns."""
    table = [list(rows[0].cells()), *([str(cell) for cell in row.cells().values()] for row in rows)]
    widths = [max(map(len, column)) for column in zip(*table, strict=True)]
    for line in table:
        print("  ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)).rstrip())


def main():
    names = [importer.name for importer in IMPORTERS]
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("gelfmu", type=Path, metavar="GELFMU", help="the command gelfmu")
    parser.add_argument("--only", metavar="NAME,..", help=f"some of {','.join(names)}")
    parser.add_argument("--csv", type=Path, metavar="FILE", help="file for the matrix")
    arguments = parser.parse_args()
    chosen = arguments.only.split(",") if arguments.only else names
    if unknown := set(chosen) - set(names):
        parser.error(f"--only: found {','.join(sorted(unknown))}, expected some of {','.join(names)}")
    gelfmu, start = arguments.gelfmu.resolve(), time.monotonic()
    python = install_python()
    programs = install_rust(python) if any(i.is_crate and i.name in chosen for i in IMPORTERS) else None
    versions = installed_versions(python)
    print(f"importers installed in {time.monotonic() - start:.0f} s", flush=True)

    rows, skipped = [], {} if arguments.only else dict(UNAVAILABLE)
    with tempfile.TemporaryDirectory() as folder:
        for scene in SCENES:
            archive = Path(folder) / f"{scene.name}.fmu"
            output(gelfmu, "pack", scene.name, *scene.options, "--out", archive, remedy="give a built gelfmu")
            size = archive.stat().st_size
            print(f"{archive.name}: {size} bytes, {scene.steps} steps of {scene.step:g} s", flush=True)
            reference = None
            for importer in [REFERENCE, *(each for each in IMPORTERS if each.name in chosen)]:
                if reason := reason_to_skip(importer, versions):
                    skipped[importer.name] = reason
                    continue
                row = Row(importer.name, versions[importer.package], scene.name)
                script = [python, HERE / "drive.py", importer.name]
                drive([programs / importer.name] if importer.is_crate else script, scene, archive, row)
                reference = reference or row
                compare(row, reference)
                rows.append(row)
    print_matrix(rows)
    for name, reason in skipped.items():
        print(f"{name}: skipped, {reason}")
    if arguments.csv:
        with arguments.csv.open("w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, rows[0].cells())
            writer.writeheader()
            writer.writerows(row.cells() for row in rows)
    failed = sum(row.outcome != "passed" for row in rows)
    print(f"{len(rows) - failed} passed, {failed} failed, {len(skipped)} skipped")
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
