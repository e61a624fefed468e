"""Table of runs by setting of the optimizer: `python benches/build_settings.py [--rounds N] [NAME=GELFMU ...]`.

A program is built for each setting in `target/build-settings`, or given by its path. Runs of the settings follow each
other within a round, so that a machine that becomes slower slows all of them; of the rounds the least CPU seconds
count. Runs of one scene must end with the same digest. With `--whole` programs are compared by whole shots with two
threads, by CPU and wall seconds; those of other digests, which the format of a summary changes, too, are marked.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
TARGET = ROOT / "target" / "build-settings"
# Variables of cargo by setting.
SETTINGS = {
    "sixteen units, no optimization between them": {"LTO": "off", "CODEGEN_UNITS": "16"},
    "sixteen units, optimized between them": {"LTO": "false", "CODEGEN_UNITS": "16"},
    "one unit": {"LTO": "false", "CODEGEN_UNITS": "1"},
}
# Arguments of `gelfmu run` by name of the run; {shot} is the scene of a 9 mm bullet, {recovered} that of a recovered
# one, {rifle} that of an M80.
RUNS = {
    "9 mm at draft, first 0.1 ms": ["{shot}", "--fidelity", "draft", "--set", "scene.end_time=1e-4"],
    "fbi-bb-3d, first 0.04 ms": ["fbi-bb-3d", "--set", "scene.end_time=4e-5"],
    "fbi-bb, first 2 ms": ["fbi-bb", "--set", "scene.end_time=2e-3"],
    "recovered shape, first 0.3 ms": ["{recovered}", "--set", "scene.end_time=3e-4"],
    "sphere-block": ["sphere-block"],
}
WHOLE_RUNS = {
    "fbi-bb": ["fbi-bb"],
    "recovered shape at standard": ["{recovered}", "--fidelity", "standard"],
    "9 mm at draft": ["{shot}", "--fidelity", "draft"],
    "fbi-bb-3d": ["fbi-bb-3d"],
    "M80 at coarse, first 0.2 ms": ["{rifle}", "--fidelity", "coarse", "--set", "scene.end_time=2e-4"],
}
SHOTS = {"shot": "9mm-fmj", "recovered": "45acp-230-xtp-recovered", "rifle": "762-m80"}


def cpu_seconds(command, **options):
    """Runs a command and returns its standard output with its CPU and wall seconds, those of its children included."""
    before, start = os.times(), os.times().elapsed
    output = subprocess.run(command, check=True, stdout=subprocess.PIPE, **options).stdout
    after = os.times()
    cpu = after.children_user + after.children_system - before.children_user - before.children_system
    return output, cpu, after.elapsed - start


def build(name):
    """Builds the program with a setting from nothing and returns its path."""
    folder = TARGET / name.replace(" ", "-").replace(",", "")
    if folder.exists():
        sys.exit(f"{folder}: found an earlier build, expected none: remove the folder, or give {name}=PROGRAM")
    variables = {f"CARGO_PROFILE_RELEASE_{key}": value for key, value in SETTINGS[name].items()}
    command = ["cargo", "build", "--release", "--locked", "--quiet", "--target-dir", folder]
    _, cpu, wall = cpu_seconds(command, cwd=ROOT, env=os.environ | variables)
    print(f"built with {name}: {cpu:.0f} CPU s, {wall:.0f} s", flush=True)
    return folder / "release" / "gelfmu"


def measure(program, arguments, threads):
    """Runs a scene once and returns its digest with its CPU and wall seconds."""
    options = ["--direct", "--threads", str(threads), "--no-frames", "--no-report", "--force", "--quiet", "--json"]
    with tempfile.TemporaryDirectory() as folder:
        output, cpu, wall = cpu_seconds([program, "run", *arguments, *options, "--out", Path(folder) / "run"])
    return json.loads(output)["digest"], cpu, wall


def compare(name, arguments, programs, options):
    """Returns the row of a run: the least CPU seconds of each program, with `--whole` the least wall seconds, too."""
    least, digests = {}, set()
    for _ in range(options.rounds):
        for program, path in programs.items():
            digest, *seconds = measure(path, arguments, 2 if options.whole else 1)
            digests.add(digest)
            least[program] = [min(pair) for pair in zip(seconds, least.get(program, seconds), strict=True)]
    if len(digests) != 1 and not options.whole:
        sys.exit(f"{name}: found {len(digests)} digests, expected one")
    if options.whole:
        cells = [f"{cpu:.1f}, {wall:.1f}" for cpu, wall in least.values()]
        return [name, *cells, "the same" if len(digests) == 1 else "others"]
    return [name, *(f"{cpu:.2f}" for cpu, _ in least.values())]


def main():
    """Prints the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--whole", action="store_true", help="whole shots with two threads")
    parser.add_argument("programs", nargs="*", metavar="NAME=GELFMU")
    options = parser.parse_args()
    given = dict(program.split("=", 1) for program in options.programs)
    programs = {name: Path(path).resolve() for name, path in given.items()} or {name: build(name) for name in SETTINGS}
    with tempfile.TemporaryDirectory() as folder:
        scenes = {key: str(Path(folder) / f"{key}.toml") for key in SHOTS}
        for key, projectile in SHOTS.items():
            first = next(iter(programs.values()))
            subprocess.run([first, "new", "--projectile", projectile, "--out", scenes[key], "--quiet"], check=True)
        print(" | ".join(["run", *programs, *(["digests"] if options.whole else [])]), flush=True)
        for name, arguments in (WHOLE_RUNS if options.whole else RUNS).items():
            arguments = [argument.format(**scenes) for argument in arguments]
            print(" | ".join(compare(name, arguments, programs, options)), flush=True)


if __name__ == "__main__":
    main()
