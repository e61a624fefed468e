"""Measurement of sweeps: their wall seconds by engine, their overhead, their bits, and a sweep that is killed.

    python python/bench/sweep.py                # 1000 shots: some two hours on two cores
    python python/bench/sweep.py --alone 10    # an hour and a half: one worker alone runs every tenth shot only
    python python/bench/sweep.py --shots 40 --repeat 3

Shots are drafts of fbi-bb spread over speed, strength scale and mass. Each repetition pairs every engine with two
processes of one worker that share the shots, so that both meet the same machine; an efficiency is the median of these
pairs. Prints a table, and fails if the rows of two runs differ. Needs the extras `sweep` and `dask`, and POSIX.
"""

from __future__ import annotations

import argparse
import hashlib
import os
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import ballistic_gel as bg

WORKERS = 2
ALONE = "1 worker"
SPREADS = {
    "projectile.velocity[3]": bg.Uniform(-200.0, -140.0),
    "gel.strength_scale": bg.Uniform(0.8, 1.25),
    "projectile.mass": bg.Uniform(0.30e-3, 0.40e-3),
}


@dataclass(frozen=True)
class Timing:
    """Seconds of one sweep: on the wall, and of the processors by this process and by the shots."""

    wall: float
    own: float
    shots: float


def sweep(count: int, folder: Path, **options: Any) -> None:
    """Run the shots into a folder."""
    samples = bg.LatinHypercube(SPREADS, count, seed=1)
    table = bg.sweep("fbi-bb", samples, folder, fidelity="draft", progress=False, **options)
    if set(table["status"]) != {"completed"}:
        raise SystemExit(f"{folder.name}: not all shots were completed:\n{table['status'].value_counts()}")


def sweep_by_dask(count: int, folder: Path) -> None:
    """Run the shots on a local cluster of Dask, start and end of the cluster included."""
    import distributed

    options = {"n_workers": WORKERS, "threads_per_worker": 1, "dashboard_address": None}
    with distributed.LocalCluster(**options) as cluster, distributed.Client(cluster) as client:
        sweep(count, folder, client=client)


def sweep_by_two(count: int, folder: Path) -> None:
    """Run the shots by two processes of one worker, which know nothing of each other but the folder."""
    processes = [
        start_part(count, folder, "--workers=1", f"--share={number}/{WORKERS}") for number in range(1, WORKERS + 1)
    ]
    if any(process.wait() for process in processes):
        raise SystemExit("a process of one worker failed")
    sweep(count, folder, workers=1)  # runs nothing, and writes the table


def start_part(count: int, folder: Path, *options: str) -> subprocess.Popen[bytes]:
    """Start a process of this script that runs shots into a folder, in a group of its own."""
    command = [sys.executable, __file__, f"--shots={count}", f"--into={folder}", *options]
    return subprocess.Popen(command, start_new_session=True)


def timed(run: Callable[[int, Path], None], count: int, folder: Path) -> Timing:
    """Run a sweep and return its seconds."""
    before, begun = os.times(), time.perf_counter()
    run(count, folder)
    wall, after = time.perf_counter() - begun, os.times()
    own = after.user + after.system - before.user - before.system
    shots = after.children_user + after.children_system - before.children_user - before.children_system
    return Timing(wall, own, shots)


def bits(folder: Path) -> str:
    """Return the hash of the table in a folder."""
    return hashlib.sha256((folder / "results.csv").read_bytes()).hexdigest()[:16]


def kill_half_way(count: int, folder: Path) -> int:
    """Kill a sweep once half of its rows are there, and return their number."""
    process = start_part(count, folder, f"--workers={WORKERS}")
    rows = folder / "rows"
    while process.poll() is None and (not rows.is_dir() or len(list(rows.glob("*.json"))) < count // 2):
        time.sleep(0.05)
    if process.poll() is not None:
        raise SystemExit("the sweep ended before it could be killed: use more shots")
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    return len(list(rows.glob("*.json")))


ENGINES: dict[str, Callable[[int, Path], None]] = {
    f"{WORKERS} single workers": sweep_by_two,
    f"{WORKERS} workers": lambda count, folder: sweep(count, folder, workers=WORKERS),
    f"Dask, {WORKERS} workers": sweep_by_dask,
}
PAIRED = f"{WORKERS} single workers"


def measure_alone(count: int, part: int, folder: Path) -> Timing:
    """Run every part-th shot by one worker, and return its seconds for each shot."""
    into = folder / "alone"
    timing = timed(lambda count, into: sweep(count, into, workers=1, share=f"1/{part}"), count, into)
    print(f"{ALONE}: {timing.wall:.1f} s", file=sys.stderr, flush=True)
    shots = len(list((into / "rows").glob("*.json")))
    return Timing(timing.wall / shots, timing.own / shots, timing.shots / shots)


def measure(count: int, repeat: int, folder: Path) -> tuple[dict[str, list[Timing]], set[str]]:
    """Run every engine as often as asked for, and return their seconds and the hashes of their tables."""
    timings: dict[str, list[Timing]] = {name: [] for name in ENGINES}
    hashes = set()
    for turn in range(repeat):
        for place, (name, run) in enumerate(ENGINES.items()):
            into = folder / f"{turn}-{place}"
            timings[name].append(timed(run, count, into))
            hashes.add(bits(into))
            print(f"{name}: {timings[name][-1].wall:.1f} s", file=sys.stderr, flush=True)
    return timings, hashes


def print_table(alone: Timing, timings: dict[str, list[Timing]], count: int) -> None:
    """Print wall seconds, and the efficiency against the pair of each run."""
    print("| engine | wall, s | shots per s | efficiency against two single workers |\n|---|---|---|---|")
    print(f"| {ALONE} | {alone.wall * count:.1f} | {1 / alone.wall:.2f} | |")
    for name, runs in timings.items():
        wall = statistics.median(run.wall for run in runs)
        ratios = [pair.wall / run.wall for pair, run in zip(timings[PAIRED], runs, strict=True)]
        print(f"| {name} | {wall:.1f} | {count / wall:.2f} | {100 * statistics.median(ratios):.1f} % |")
    rest = alone.wall - alone.shots
    seconds = {"wall": alone.wall, "processors, by gelfmu": alone.shots}
    seconds |= {"processors, by Python": alone.own, "rest": rest}
    print("\none worker, ms for each shot: " + "; ".join(f"{k} {1e3 * v:.1f}" for k, v in seconds.items()))


def main() -> int:
    """Measure, or run one part of a sweep, and return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--shots", type=int, default=1000, help="number of shots (1000 if absent)")
    parser.add_argument("--repeat", type=int, default=1, help="repetitions, whose median counts (1 if absent)")
    parser.add_argument("--alone", type=int, default=1, metavar="N", help="one worker runs every N-th (1 if absent)")
    for name in ("--into", "--workers", "--share"):
        parser.add_argument(name, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.into:
        sweep(options.shots, Path(options.into), workers=int(options.workers), share=options.share)
        return 0
    with tempfile.TemporaryDirectory(prefix="ballistic-gel-") as folder:
        alone = measure_alone(options.shots, options.alone, Path(folder))
        timings, hashes = measure(options.shots, options.repeat, Path(folder))
        if options.alone == 1:
            hashes.add(bits(Path(folder) / "alone"))
        print_table(alone, timings, options.shots)
        kept = kill_half_way(options.shots, Path(folder) / "killed")
        sweep(options.shots, Path(folder) / "killed", workers=WORKERS)
        hashes.add(bits(Path(folder) / "killed"))
    print(f"killed with {kept} of {options.shots} rows, and gone on")
    print(f"tables of all runs: {'equal' if len(hashes) == 1 else 'DIFFERENT'}, {', '.join(sorted(hashes))}")
    return 0 if len(hashes) == 1 else 1


if __name__ == "__main__":
    sys.exit(main())
