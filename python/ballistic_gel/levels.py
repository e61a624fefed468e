"""Errors of the levels of a shot, as rows of a table that `gelfmu new` reads."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pandas as pd

from .errors import GelfmuError
from .folder import write_whole
from .scene import Scene, new_shot_values
from .sweeping import sweep
from .tasks import depth_of

LEVELS = ["draft", "coarse", "standard", "fine", "reference"]
# What identifies a row: the shot as `gelfmu new` tells it, the level and the level that it is compared with.
IDENTITY = ["projectile", "kind", "calibre", "mass", "speed", "yaw", "gel", "level", "reference"]
COLUMNS = [*IDENTITY[:-1], "depth", "reference", "reference_depth", "error", "command"]


def level_errors(
    projectile: str,
    speeds: Sequence[float | str],
    *,
    yaw: float | None = None,
    block: str | None = None,
    gel: str | None = None,
    reference: str = "fine",
    out: str | Path = "gelfmu-out/levels",
    table: str | Path | None = None,
    workers: int | None = None,
    progress: bool = True,
) -> pd.DataFrame:
    """Measure the errors of the levels of a shot against a finer one, at some speeds.

    An error is the relative difference of the depth at rest, or at the end for a projectile that does not rest.
    Finished shots are kept in `out`: the same call after a kill runs the others only.

    Parameters
    ----------
    projectile : str
        Name in the library; `projectiles` lists them.
    speeds : sequence of float or str
        Speeds at the gel, m/s, or with a unit.
    yaw, block, gel : optional
        As in `Scene.new_shot`. A projectile that leaves the block has no depth.
    reference : str
        Level that the cheaper ones are compared with.
    out : str or Path
        Folder with a sweep for each speed.
    table : str or Path, optional
        CSV file of this function that gets the rows, those of the same shot, level and reference replaced; such as
        ``projectiles/level-errors.csv``, which the next build of `gelfmu` reads.
    workers : int, optional
        Number of local workers; all cores if absent.
    progress : bool
        Show a bar in notebooks and terminals.

    Returns
    -------
    DataFrame
        One row for each speed and level: the shot, ``depth`` and ``reference_depth`` (m), ``error``, ``command``.

    Raises
    ------
    GelfmuError
        For a shot that did not reach its end or left the block, a level that the scene does not have, or a table that
        is none of this function.
    """
    if table is not None:
        _read_table(Path(table))  # refuses another file before the first shot
    options: dict[str, Any] = {"yaw": yaw, "block": block, "gel": gel}
    made = []
    for speed in speeds:
        new = new_shot_values(projectile, speed, **options)
        scene = Scene(new["text"])
        levels = _levels_up_to(reference, scene)
        if progress:
            print(f"{scene.name}: {', '.join(levels)}", file=sys.stderr)
        samples = {"scene.fidelity": levels[::-1]}  # the most expensive first: it decides how long all take
        shots = sweep(scene, samples, Path(out) / scene.name, workers=workers, progress=progress)
        depths = {
            (own := shot["scene.fidelity"]): depth_of(f"{scene.name} at {own}", shot) for _, shot in shots.iterrows()
        }
        given = {"speed": new["shot"]["speed"], **options, "reference": None if reference == "fine" else reference}
        command = shlex.join(["python", "-m", "ballistic_gel", "levels", projectile, *_arguments(given)])
        rows = [
            {
                **new["shot"],
                "level": level,
                "depth": depths[level],
                "reference": reference,
                "reference_depth": depths[reference],
                "error": abs(depths[level] / depths[reference] - 1.0),
                "command": command,
            }
            for level in levels[:-1]
        ]
        made.append(pd.DataFrame(rows)[COLUMNS])
        if table is not None:
            known = _read_table(Path(table))
            both = pd.concat([known, made[-1].astype(str)]).drop_duplicates(IDENTITY, keep="last")
            write_whole(Path(table), both.to_csv(index=False).encode())
    return pd.concat(made, ignore_index=True)


def _levels_up_to(reference: str, scene: Scene) -> list[str]:
    """Return the levels of a scene from the cheapest to the reference."""
    tables: Any = scene["fidelity"]
    known = [level for level in LEVELS if level in tables]
    if reference not in known[1:]:
        remedy = f"one of {', '.join(known[1:])}"
        raise GelfmuError(f"reference {reference}: found no such level above another, expected {remedy}", remedy=remedy)
    return known[: known.index(reference) + 1]


def _arguments(options: dict[str, Any]) -> list[str]:
    return [part for name, value in options.items() if value is not None for part in (f"--{name}", str(value))]


def _read_table(path: Path) -> pd.DataFrame:
    """Return the rows of a table as they are written, none if there is no file."""
    if not path.parent.is_dir():
        raise GelfmuError(f"{path}: found no folder {path.parent}", remedy="name a table in a folder that exists")
    if not path.exists():
        return pd.DataFrame(columns=COLUMNS)
    try:
        table = pd.read_csv(path, dtype=str, keep_default_na=False)
    except (OSError, ValueError) as error:
        raise GelfmuError(f"{path}: {error}", remedy="name a table of level errors, or a new file") from error
    if list(table) != COLUMNS:
        remedy = f"a new file, or a table with the columns {', '.join(COLUMNS)}"
        raise GelfmuError(f"{path}: found a table of something else, expected {remedy}", remedy=remedy)
    return table
