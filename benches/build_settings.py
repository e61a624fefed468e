"""Table of whole runs and builds by setting of the optimizer: `python benches/build_settings.py [--rounds N] [NAME=GELFMU ...]`.

A program is built for each setting in `target/build-settings`, or given by its path. Runs of the settings follow each
other within a round, so that a machine that becomes slower slows all of them; of the rounds the least CPU seconds count.
Runs of one scene must end with the same digest.
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
# Arguments of `gelfmu run` by name of the run; {shot} is the scene of a 9 mm bullet, {recovered} that of a recovered one.
RUNS = {
    "9 mm at draft, first 0.1 ms": ["{shot}", "--fidelity", "draft", "--set", "scene.end_time=1e-4"],
    "fbi-bb-3d, first 0.04 ms": ["fbi-bb-3d", "--set", "scene.end_time=4e-5"],
    "fbi-bb, first 2 ms": ["fbi-bb", "--set", "scene.end_time=2e-3"],
    "recovered shape, first 0.3 ms": ["{recovered}", "--set", "scene.end_time=3e-4"],
    "sphere-block": ["sphere-block"],
}
SHOTS = {"shot": "9mm-fmj", "recovered": "45acp-230-xtp-recovered"}


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


def measure(program, arguments, scenes, folder):
    """Runs a scene once with one thread and returns its digest and CPU seconds."""
    arguments = [argument.format(**scenes) for argument in arguments]
    options = ["--threads", "1", "--no-frames", "--no-report", "--force", "--quiet", "--json", "--out", folder]
    output, cpu, _ = cpu_seconds([program, "run", *arguments, *options])
    return json.loads(output)["digest"], cpu


def main():
    """Prints the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("programs", nargs="*", metavar="NAME=GELFMU")
    options = parser.parse_args()
    given = dict(program.split("=", 1) for program in options.programs)
    programs = {name: Path(path).resolve() for name, path in given.items()} or {name: build(name) for name in SETTINGS}
    with tempfile.TemporaryDirectory() as folder:
        scenes = {key: str(Path(folder) / f"{key}.toml") for key in SHOTS}
        for key, projectile in SHOTS.items():
            first = next(iter(programs.values()))
            subprocess.run([first, "new", "--projectile", projectile, "--out", scenes[key], "--quiet"], check=True)
        print("run | " + " | ".join(programs), flush=True)
        for run, arguments in RUNS.items():
            least, digests = dict.fromkeys(programs, float("inf")), set()
            for _ in range(options.rounds):
                for name, program in programs.items():
                    digest, cpu = measure(program, arguments, scenes, Path(folder) / "run")
                    digests.add(digest)
                    least[name] = min(least[name], cpu)
            if len(digests) != 1:
                sys.exit(f"{run}: found {len(digests)} digests, expected one")
            print(f"{run} | " + " | ".join(f"{cpu:.2f}" for cpu in least.values()), flush=True)


if __name__ == "__main__":
    main()
