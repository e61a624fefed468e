"""Command line of the package: sweeps, and studies that are made of sweeps."""

from __future__ import annotations

import argparse
import inspect
import signal
import sys
from collections.abc import Callable
from typing import Any

from .errors import GelfmuError
from .fitting import GelFit, fit_gel
from .gel_parameters import PARAMETERS
from .levels import LEVELS, level_errors
from .reduction import BODIES, reduce_model
from .scene import as_scene
from .study import Study
from .tasks import COMPLETED, CRASHED
from .trade import QUANTITIES, TradeCurve, error_cost, option_costs
from .validation import Validation, validate
from .values import parse_override


def main(arguments: list[str] | None = None) -> int:
    """Run the command line and return its exit status."""
    options = vars(_parser().parse_args(arguments))
    command: Callable[..., int] = options.pop("command")
    # A batch system that ends the job ends the shots with it; finished rows are kept.
    signal.signal(signal.SIGTERM, _interrupt)
    try:
        return command(**options)
    except GelfmuError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt as interrupt:
        told = str(interrupt) or "finished rows are kept, the same command goes on from there"
        print(f"interrupted: {told}", file=sys.stderr)
        return 130


def _run_study(study: str, share: str | None, workers: int | None) -> int:
    found = Study.load(study)
    table = found.run(share, workers)
    counts = table["status"].value_counts()
    print(", ".join(f"{count} {status}" for status, count in counts.items()) or "no rows", f"in {found.folder}")
    for place, row in table[table["status"] != COMPLETED].iterrows():
        print(f"row {place + 1}: {row['status']}: {row['reason']}", file=sys.stderr)
    # A share may lack rows, which others have.
    shown = found.table_of(table) if share is None or len(table) == found.count() else None
    if shown is not None:
        print(shown.to_markdown(), end="")
    return 1 if CRASHED in counts or (shown is not None and shown.unexpected) else 0


def _print_slurm(study: str, tasks: int, time: str, cores: int) -> int:
    print(Study.load(study).slurm_script(tasks, time, cores), end="")
    return 0


def _measure_levels(**given: Any) -> int:
    print(level_errors(**given)[["speed", "level", "depth", "reference_depth", "error"]].to_string(index=False))
    return 0


def _measure_trade(scene: str, options: bool, overrides: list[str], **given: Any) -> int:
    changed = as_scene(scene).with_values(dict(map(parse_override, overrides)))
    if options:
        ignored = [name for name in ("only", "others") if given[name]] + (["finer"] if given["finer"] != 3 else [])
        if ignored:
            remedy = f"remove --{ignored[0]}, or --options"
            raise GelfmuError(f"--options: found it beside --{ignored[0]}: {remedy}", remedy=remedy)
        print(option_costs(changed, out=given["out"], workers=given["workers"] or 1).to_string(index=False))
        return 0
    curve: TradeCurve = error_cost(changed, **given)
    print(curve.to_markdown(), end="")
    return 0


def _validate(**given: Any) -> int:
    found: Validation = validate(**given)
    print(found.to_markdown(), end="")
    if found.missing:
        print(f"{found.missing} runs are missing, which other shares have: no files were written")
    print(f"{found.agreeing} of {found.judged} shots of grade B that the gel is not fitted to agree within 20 %")
    failed = found.runs[found.runs["status"] != "completed"]
    for _, run in failed.iterrows():
        case = f"{run['shot']} {run['level']} yaw {run['yaw']}°"
        print(f"{case}: {run['status']}: {run['reason']}", file=sys.stderr)
    return 1 if len(failed) else 0


def _calibrate(overrides: list[str], start: list[str], **given: Any) -> int:
    values, begin = (dict(map(parse_override, entries)) for entries in (overrides, start))
    found: GelFit = fit_gel(values=values, start=begin, **given)
    print(found)
    return 1 if found.status == "not fitted" else 0


def _reduce(**given: Any) -> int:
    found = reduce_model(**given)
    print(found.to_toml("instant.class"), end="")
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m ballistic_gel", description="Run many shots.")
    commands = parser.add_subparsers(required=True)
    _add_sweep(commands)
    _add_slurm(commands)
    _add_levels(commands)
    _add_trade(commands)
    _add_validate(commands)
    _add_calibrate(commands)
    _add_reduce(commands)
    return parser


def _new_command(commands: Any, name: str, work: Callable[..., int], about: str) -> argparse.ArgumentParser:
    made: argparse.ArgumentParser = commands.add_parser(name, help=about, description=about)
    made.set_defaults(command=work)
    return made


def _add_workers(command: argparse.ArgumentParser) -> None:
    command.add_argument("--workers", type=int, metavar="N", help="number of local workers (all cores if absent)")


def _add_sweep(commands: Any) -> None:
    sweep = _new_command(commands, "sweep", _run_study, "run a study; finished rows are kept and never run again")
    sweep.add_argument("study", help="TOML file")
    sweep.add_argument("--share", metavar="I/N", help="run only every N-th row, from row I on")
    _add_workers(sweep)


def _add_slurm(commands: Any) -> None:
    about = "print a SLURM script whose tasks each run a share of a study"
    slurm = _new_command(commands, "slurm", _print_slurm, about)
    slurm.add_argument("study", help="TOML file")
    slurm.add_argument("--tasks", type=int, default=10, metavar="N", help="tasks of the array (10 if absent)")
    slurm.add_argument("--time", default="01:00:00", help="time limit of a task (01:00:00 if absent)")
    slurm.add_argument("--cores", type=int, default=1, metavar="N", help="cores of a task (1 if absent)")


def _add_levels(commands: Any) -> None:
    about = "measure the errors of the levels of a shot; finished runs are kept"
    levels = _new_command(commands, "levels", _measure_levels, about)
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
    _add_workers(levels)


def _add_trade(commands: Any) -> None:
    about = "measure error against cost: run a scene with every knob turned towards fine and towards coarse"
    trade = _new_command(commands, "trade", _measure_trade, about)
    trade.add_argument("scene", help="name of a built-in scene, or a file that ends with .toml")
    change = "replace a value of the scene in every run, such as remesh.quality=0.3; may be repeated"
    trade.add_argument("--set", dest="overrides", action="append", default=[], metavar="KEY=VALUE", help=change)
    trade.add_argument("--only", nargs="+", default=(), metavar="KNOB", help="turn these knobs only, beside the mesh")
    finer = "refinements of all edges by √2 beyond the scene (3 if absent)"
    trade.add_argument("--finer", type=int, default=3, choices=range(1, 7), metavar="N", help=finer)
    others = f"runs of other codes: columns run, cpu_seconds and any of {', '.join(QUANTITIES)}"
    trade.add_argument("--others", metavar="FILE.csv", help=others)
    options = "measure the cost of each option that the scene leaves out, off and on, instead of the curve"
    trade.add_argument("--options", action="store_true", help=options)
    trade.add_argument("--out", metavar="FOLDER", help="folder for the curve and its runs")
    _add_workers(trade)


def _add_validate(commands: Any) -> None:
    about = "run the measured shots of the library and compare depths and necks; finished runs are kept"
    validation = _new_command(commands, "validate", _validate, about)
    validation.add_argument("--only", nargs="+", default=(), metavar="SHOT", help="names of the shots (all if absent)")
    validation.add_argument("--level", choices=LEVELS[:3], help="only the runs of this level")
    validation.add_argument("--share", metavar="I/N", help="run only every N-th run, from run I on")
    validation.add_argument("--out", default="gelfmu-out/validation", metavar="FOLDER", help="folder for the runs")
    _add_workers(validation)


def _add_calibrate(commands: Any) -> None:
    about = "fit parameters of a gel to measured shots, with what each shot decides; finished runs are kept"
    fit = _new_command(commands, "calibrate", _calibrate, about)
    usual = inspect.signature(fit_gel).parameters
    fit.add_argument("shots", nargs="?", default="gelatin-10", help="CSV file, or a table of the package (gelatin-10)")
    parameters = f"any of {', '.join(PARAMETERS)} ({', '.join(usual['parameters'].default)} if absent)"
    fit.add_argument(
        "--fit", dest="parameters", nargs="+", default=usual["parameters"].default, metavar="NAME", help=parameters
    )
    fit.add_argument("--scene", default="fbi-bb", help="scene of the shots that name none (fbi-bb if absent)")
    change = "replace a value in the scenes of all shots, such as gel.cavity=vented; may be repeated"
    fit.add_argument("--set", dest="overrides", action="append", default=[], metavar="KEY=VALUE", help=change)
    begin = "value to start from, such as stress=1e6 (that of the first shot if absent); may be repeated"
    fit.add_argument("--start", action="append", default=[], metavar="NAME=VALUE", help=begin)
    fit.add_argument("--level", default="standard", choices=LEVELS, help="level of the runs (standard if absent)")
    steps = "most steps; 0 prints the derivatives only (8 if absent)"
    fit.add_argument("--steps", type=int, default=8, metavar="N", help=steps)
    fit.add_argument("--without", nargs="+", default=(), metavar="SHOT", help="leave these shots out")
    fit.add_argument("--out", default="gelfmu-out/fit", metavar="FOLDER", help="folder for the runs")
    _add_workers(fit)


def _add_reduce(commands: Any) -> None:
    about = "identify the reduced model of the level instant from runs of the full model; finished runs are kept"
    reduce = _new_command(commands, "reduce", _reduce, about)
    reduce.add_argument("bodies", nargs="*", default=tuple(BODIES), metavar="BODY", help=", ".join(BODIES))
    runs = "runs of the full model for each class of bodies, of which half are fitted (128 if absent)"
    reduce.add_argument("--runs", type=int, default=128, metavar="N", help=runs)
    reduce.add_argument("--level", default="coarse", choices=LEVELS, help="level of these runs (coarse if absent)")
    reduce.add_argument("--gel", help="as in gelfmu new")
    reduce.add_argument("--rows", metavar="FILE.csv", help="rows of an earlier call, in the place of these runs")
    reduce.add_argument(
        "--out", default="gelfmu-out/reduce", metavar="FOLDER", help="folder for runs, rows and results"
    )
    _add_workers(reduce)


def _interrupt(_signal: int, _frame: Any) -> None:
    raise KeyboardInterrupt


if __name__ == "__main__":
    sys.exit(main())
