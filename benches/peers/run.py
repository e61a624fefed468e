"""Run the peers and ours on `sphere-block`, one after another, and print one table.

    cargo build --release
    python benches/peers/run.py --repeat 3 --json peers.json
    python benches/peers/run.py --only ours taichi

The first use makes one virtual environment per peer below --cache. README.md says what is compared.
"""

import argparse
import json
import sys
import tempfile
from dataclasses import asdict
from pathlib import Path

import cases
import measure
import table
from environments import Unavailable, interpreter


def command(case, given, packed):
    """What runs a case."""
    script = [cases.HERE / case.script, *([pack(case, given.gelfmu, packed)] if case.is_ours else [])]
    return [interpreter(case.environment, given.cache), *script, "--step", case.step]


def pack(case, gelfmu, folder):
    """The FMU of a case of ours, packed into a folder if it is not there yet; this is not measured."""
    fmu = folder / f"{case.name.replace(', ', '-').replace(' ', '-')}.fmu"
    if not gelfmu.exists():
        raise Unavailable(f"{gelfmu} does not exist; cargo build --release, or name it with --gelfmu")
    if not fmu.exists():
        changes = [word for key, value in case.changes.items() for word in ("--set", f"{key}={value}")]
        measure.run([gelfmu, "pack", "--quiet", "--scene", cases.SCENE, "--out", fmu, *changes])
    return fmu


def prepare(chosen, given, packed):
    """The command of each case that can be run here; what cannot is said once."""
    commands, missing = [], set()
    for case in chosen:
        if case.environment in missing:
            continue
        try:
            commands.append((case, command(case, given, packed)))
        except (Unavailable, measure.Failed) as reason:
            missing.add(case.environment)
            print(f"skipped: {case.environment}: {reason}", file=sys.stderr)
    return commands


def attempt(case, words):
    """One run: the answer on the script's last line, and what the process cost; none if it failed, which is said."""
    try:
        measured = measure.run(words)
    except measure.Failed as reason:
        print(f"failed: {case.name}, step {case.step} s: {reason}", file=sys.stderr)
        return None
    print(f"{case.name}, step {case.step} s: {measured.cpu_s:.2f} CPU s", file=sys.stderr)
    cost = {"cpu_s": measured.cpu_s, "wall_s": measured.wall_s, "peak_mb": measured.peak_mb}
    return json.loads(measured.output.splitlines()[-1]) | cost


def run_all(commands, repeat):
    """Every case once, then every case again: a busy minute of the machine does not fall on one of them alone."""
    runs = [[] for _ in commands]
    for _ in range(repeat):
        for (case, words), found in zip(commands, runs):
            found.append(attempt(case, words))
    return [(case, list(filter(None, found))) for (case, _), found in zip(commands, runs) if any(found)]


def arguments():
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--repeat", type=int, default=3, help="runs of each case; the first one may compile kernels")
    parser.add_argument("--only", nargs="+", metavar="NAME", help="taichi, dolfinx, felupe, kratos, ours")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write every run of every case")
    parser.add_argument("--csv", type=Path, metavar="FILE", help="write the peers for `python -m ballistic_gel trade sphere-block --others`")
    parser.add_argument("--cache", type=Path, default=Path.home() / ".cache/ballistic-gel-peers")
    parser.add_argument("--gelfmu", type=Path, default=cases.ROOT / "target/release/gelfmu")
    given = parser.parse_args()
    known = sorted({case.environment for case in cases.every()})
    unknown = set(given.only or []) - set(known)
    if unknown:
        parser.error(f"--only: found {', '.join(sorted(unknown))}, expected some of {', '.join(known)}")
    if given.repeat < 1:
        parser.error(f"--repeat: found {given.repeat}, expected 1 or more")
    return given


def main():
    """Prepare, run, print, write."""
    given = arguments()
    chosen = [case for case in cases.every() if not given.only or case.environment in given.only]
    with tempfile.TemporaryDirectory() as packed:
        results = run_all(prepare(chosen, given, Path(packed)), given.repeat)
    if not results:
        raise SystemExit("nothing could be run; what stands above says why")
    print(table.markdown(results))
    if given.csv:
        given.csv.write_text("\n".join(table.csv(results)) + "\n")
    if given.json:
        rows = [asdict(case) | {"runs": runs} for case, runs in results]
        given.json.write_text(json.dumps({"machine": table.machine(), "cases": rows}, indent=2) + "\n")


if __name__ == "__main__":
    main()
