"""Commands of `gelfmu` beside the run: lists, calibration and validation, as tables."""

from __future__ import annotations

import json
import tempfile
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from .binary import CommandResult, call_binary, call_json
from .errors import FitWarning
from .scene import Scene, as_scene


def projectiles() -> pd.DataFrame:
    """Return the projectiles of the library: name, title, kind, mass (kg) and usual speed (m/s)."""
    columns = {"name": "name", "title": "title", "kind": "kind", "mass": "mass_kg", "speed": "speed_m_per_s"}
    return pd.DataFrame(call_json(["projectiles"]))[list(columns)].rename(columns=columns)


def scenes() -> pd.DataFrame:
    """Return the built-in scenes: name, title and dimension."""
    return pd.DataFrame(call_json(["scenes"]))[["name", "title", "dimension"]]


@dataclass(frozen=True)
class Calibration:
    """Fit of a gel to measured depths.

    Attributes
    ----------
    values : dict
        All that ``gelfmu calibrate --json`` prints, in SI units.
    """

    values: dict[str, Any]

    @property
    def status(self) -> str:
        """``"fitted"``; ``"stalled"``, within the scatter of the runs; or ``"not fitted"``, with the best so far."""
        return str(self.values["status"])

    @property
    def lines(self) -> str | None:
        """Lines with the best values for the scene file, in TOML; None if no run gave any."""
        lines = self.values["lines"]
        return None if lines is None else str(lines)

    @property
    def strength_scale(self) -> float | None:
        """Best ``gel.strength_scale`` of a fit to one depth; `status` says whether it is fitted."""
        return self.values.get("strength_scale")

    @property
    def table(self) -> pd.DataFrame:
        """Trials of a fit to one depth; computed and given values of a fit to several shots."""
        return pd.DataFrame(self.values.get("trials", self.values.get("shots")))


def calibrate(
    scene: Scene | str | Path = "fbi-bb",
    *,
    depth: float | None = None,
    speed: float | None = None,
    tolerance: str | None = None,
    shots: str | Path | pd.DataFrame | None = None,
    fit: Sequence[str] = (),
    level: str | None = None,
    start: str | None = None,
    threads: int = 0,
) -> Calibration:
    """Fit a gel to the depth at which a projectile rests, or to several shots.

    Parameters
    ----------
    scene : Scene, str or Path
        Scene, the name of a built-in one, or the path of a file that ends with ``.toml``, with the gel to begin with.
    depth : float, optional
        Measured rest depth from the entry surface to the nose, m (0.085 if absent).
    speed : float, optional
        Speed of the projectile along -z, m/s; that of the scene if absent.
    tolerance : str, optional
        Difference of the depth that counts as none, such as ``"1%"`` (``"0.1%"`` if absent).
    shots : str, Path or DataFrame, optional
        Shots to fit to: a table, the path of a CSV file, or the name of a built-in one, ``"gelatin-10"``. Columns are
        ``name``, ``speed`` (m/s; two for a slope, ``"165/195"``), ``measure`` (``depth``, ``slope`` or ``cavity``),
        ``value`` and ``band``, the accepted deviation (both in m, or m per m/s for a slope), and if needed ``scene``,
        ``set`` and ``window``.
    fit : sequence of str
        Parameters that are fitted to the shots, of ``stress``, ``exponent`` and ``shear_modulus``; all if empty.
    level, start : str, optional
        Level of accuracy of the runs (``"fine"`` for shots, otherwise that of the scene), and of a first fit.
    threads : int
        Threads, 0 for all cores.

    Warns
    -----
    FitWarning
        If the gel is not fitted, or a shot is further from its value than its band.
    """
    scene = as_scene(scene)
    with tempfile.TemporaryDirectory(prefix="ballistic-gel-") as folder:
        if isinstance(shots, pd.DataFrame):
            table = Path(folder) / "shots.csv"
            shots.to_csv(table, index=False)
            shots = table
        options = {"depth": depth, "speed": speed, "tolerance": tolerance, "shots": shots}
        options |= {"fit": ",".join(fit) or None, "level": level, "start": start, "threads": threads}
        given = [f"--{name}={value}" for name, value in options.items() if value is not None]
        with scene.source() as name:
            result = call_binary(["calibrate", name, *scene.arguments(), *given, "--quiet", "--json"])
    calibration = Calibration(_values_in(result))
    for line in result.errors.splitlines():
        warnings.warn(line.removeprefix("warning: ").removeprefix("error: "), FitWarning, stacklevel=2)
    return calibration


@dataclass(frozen=True)
class Validation:
    """Computed beside measured depths of the library.

    Attributes
    ----------
    table : DataFrame
        One row for each run.
    agreeing, judged : int
        Shots that agree with their measurement, of those that are judged: of grade B, and not fitted.
    failures : list of str
        Runs that failed, and why.
    """

    table: pd.DataFrame
    agreeing: int
    judged: int
    failures: list[str]


def validate(
    only: Sequence[str] = (),
    *,
    level: str | None = None,
    jobs: int = 1,
    out: str | Path = "gelfmu-out/validation",
    afresh: bool = False,
) -> Validation:
    """Run the measured shots of the library; finished ones are kept in the folder.

    Parameters
    ----------
    only : sequence of str
        Names of the shots to run; all if empty.
    level : str, optional
        Only the cases of this level, ``"draft"`` or ``"coarse"``.
    jobs : int
        Number of concurrent processes.
    out : str or Path
        Folder for the table, the picture and the rows.
    afresh : bool
        Repeat every run.
    """
    given = [f"--jobs={jobs}", f"--out={out}"]
    given += [f"--only={','.join(only)}"] if only else []
    given += [f"--level={level}"] if level else []
    given += ["--afresh"] if afresh else []
    found = _values_in(call_binary(["validate", *given, "--quiet", "--json"]))
    return Validation(pd.DataFrame(found["rows"]), found["agreeing"], found["judged"], found["failures"])


def _values_in(result: CommandResult) -> dict[str, Any]:
    """Return what a command printed, also if it printed a result and then failed, as a fit that does not converge."""
    try:
        found: dict[str, Any] = json.loads(result.output)
    except ValueError:
        raise result.error() from None
    if "error" in found:
        raise result.error()
    return found
