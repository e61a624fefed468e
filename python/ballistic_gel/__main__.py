"""Command line of the package: sweeps that a TOML file describes, and errors of the levels of a shot."""

from __future__ import annotations

import argparse
import signal
import sys
from typing import Any

from .errors import GelfmuError
from .levels import LEVELS, level_errors
from .study import Study
from .tasks import CRASHED


def main(arguments: list[str] | None = None) -> int:
    """Run the command line and return its exit status."""
    options = _parser().parse_args(arguments)
    # A batch system that ends the job ends the shots with it; finished rows are kept.
    signal.signal(signal.SIGTERM, _interrupt)
    try:
        if options.command == "levels":
            given = {name: value for name, value in vars(options).items() if name != "command"}
            print(level_errors(**given)[["speed", "level", "depth", "reference_depth", "error"]].to_string(index=False))
            return 0
        study = Study.load(options.study)
        if options.command == "slurm":
            print(study.slurm_script(options.tasks, options.time, options.cores), end="")
            return 0
        table = study.run(options.share, options.workers)
    except GelfmuError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt as interrupt:
        told = str(interrupt) or "finished rows are kept, the same command goes on from there"
        print(f"interrupted: {told}", file=sys.stderr)
        return 130
    counts = table["status"].value_counts()
    print(", ".join(f"{count} {status}" for status, count in counts.items()) or "no rows", f"in {study.folder}")
    return 1 if CRASHED in counts else 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m ballistic_gel", description="Run many shots.")
    commands = parser.add_subparsers(dest="command", required=True)
    sweep = commands.add_parser("sweep", help="run a study; finished rows are kept and never run again")
    sweep.add_argument("study", help="TOML file")
    sweep.add_argument("--share", metavar="I/N", help="run only every N-th row, from row I on")
    sweep.add_argument("--workers", type=int, metavar="N", help="number of local workers (all cores if absent)")
    slurm = commands.add_parser("slurm", help="print a SLURM script whose tasks each run a share of a study")
    slurm.add_argument("study", help="TOML file")
    slurm.add_argument("--tasks", type=int, default=10, metavar="N", help="tasks of the array (10 if absent)")
    slurm.add_argument("--time", default="01:00:00", help="time limit of a task (01:00:00 if absent)")
    slurm.add_argument("--cores", type=int, default=1, metavar="N", help="cores of a task (1 if absent)")
    levels = commands.add_parser("levels", help="measure the errors of the levels of a shot; finished runs are kept")
    levels.add_argument("projectile", help="projectile of the library, such as bb")
    speeds = "speeds at the gel, m/s, or with a unit"
    levels.add_argument("--speed", dest="speeds", nargs="+", required=True, metavar="SPEED", help=speeds)
    levels.add_argument("--yaw", type=float, metavar="ANGLE", help="as in gelfmu new")
    levels.add_argument("--block", metavar="AxBxC", help="as in gelfmu new")
    levels.add_argument("--gel", help="as in gelfmu new")
    levels.add_argument(
        "--reference", default="fine", choices=LEVELS[1:], help="level to compare with (fine if absent)"
    )
    levels.add_argument("--out", default="gelfmu-out/levels", metavar="FOLDER", help="folder for the runs")
    levels.add_argument("--table", metavar="FILE.csv", help="table of level errors that gets the rows")
    levels.add_argument("--workers", type=int, metavar="N", help="number of local workers (all cores if absent)")
    return parser


def _interrupt(_signal: int, _frame: Any) -> None:
    raise KeyboardInterrupt


if __name__ == "__main__":
    sys.exit(main())
