"""Commands of `gelfmu` beside the run: lists, and the fit of a gel to one depth."""

from __future__ import annotations

import json
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from .binary import CommandResult, call_binary, call_json
from .errors import FitWarning
from .scene import Scene, as_scene
from .schema import walk_schema


def projectiles() -> pd.DataFrame:
    """Return the projectiles of the library: name, title, kind, mass (kg) and usual speed (m/s)."""
    columns = {"name": "name", "title": "title", "kind": "kind", "mass": "mass_kg", "speed": "speed_m_per_s"}
    return pd.DataFrame(call_json(["projectiles"]))[list(columns)].rename(columns=columns)


def scenes() -> pd.DataFrame:
    """Return the built-in scenes: name, title and dimension."""
    return pd.DataFrame(call_json(["scenes"]))[["name", "title", "dimension"]]


def figures() -> pd.DataFrame:
    """Return the figures of a run, the keys of ``summary.json``.

    Returns
    -------
    DataFrame
        Indexed by the dotted key, without the numbers of lists, as in ``sensors.peak_pressure``: ``unit`` (SI, ``"1"``
        for a ratio or a count, empty for a text), ``sampled`` (``start`` or ``end`` of the run, or each ``step`` of
        communication, ``frame``, ``tick`` or ``update``) and ``meaning``.
    """
    schema = call_json(["schema", "summary"])
    rows = dict(walk_schema(schema, schema.get("$defs", {}), ""))
    columns = {"unit": "x-unit", "sampled": "x-sampled", "meaning": "description"}
    table = {column: {key: figure.get(name, "") for key, figure in rows.items()} for column, name in columns.items()}
    return pd.DataFrame(table).rename_axis("key")


@dataclass(frozen=True)
class Calibration:
    """Fit of the strength of a gel to a measured depth.

    Attributes
    ----------
    values : dict
        All that ``gelfmu calibrate --json`` prints, in SI units.
    """

    values: dict[str, Any]

    @property
    def status(self) -> str:
        """``"fitted"``, or ``"not fitted"``, with the best so far."""
        return str(self.values["status"])

    @property
    def lines(self) -> str | None:
        """Lines with the best value for the scene file, in TOML; None if no run gave any."""
        lines = self.values["lines"]
        return None if lines is None else str(lines)

    @property
    def strength_scale(self) -> float | None:
        """Best ``gel.strength_scale``; `status` says whether it is fitted."""
        scale = self.values["strength_scale"]
        return None if scale is None else float(scale)

    @property
    def table(self) -> pd.DataFrame:
        """Trials: ``strength_scale``, ``depth`` (m), ``time`` (s) and ``failure``."""
        return pd.DataFrame(self.values["trials"])


def calibrate(
    scene: Scene | str | Path = "fbi-bb",
    *,
    depth: float | None = None,
    speed: float | None = None,
    tolerance: str | None = None,
    level: str | None = None,
    threads: int = 0,
) -> Calibration:
    """Fit the strength of a gel to the depth at which a projectile rests; `fit_gel` fits to several shots.

    Parameters
    ----------
    scene : Scene, str or Path
        Scene, the name of a built-in one, or the path of a file that ends with ``.toml``, with the gel to begin with.
    depth : float, optional
        Measured rest depth from the entry surface to the nose, m (0.085 if absent).
    speed : float, optional
        Speed of the projectile along -z, m/s; that of the scene if absent.
    tolerance : str, optional
        Relative difference of the depth that is accepted, such as ``"1%"`` (``"0.1%"`` if absent).
    level : str, optional
        Level of accuracy of the runs; that of the scene if absent.
    threads : int
        Threads, 0 for all cores.

    Warns
    -----
    FitWarning
        If the gel is not fitted.
    """
    scene = as_scene(scene)
    options = {"depth": depth, "speed": speed, "tolerance": tolerance, "level": level, "threads": threads}
    given = [f"--{name}={value}" for name, value in options.items() if value is not None]
    with scene.source() as name:
        result = call_binary(["calibrate", name, *scene.arguments(), *given, "--quiet", "--json"])
    calibration = Calibration(_values_in(result))
    for line in result.errors.splitlines():
        warnings.warn(line.removeprefix("warning: ").removeprefix("error: "), FitWarning, stacklevel=2)
    return calibration


def _values_in(result: CommandResult) -> dict[str, Any]:
    """Return what a command printed, also if it printed a result and then failed, as a fit that does not converge."""
    try:
        found: dict[str, Any] = json.loads(result.output)
    except ValueError:
        raise result.error() from None
    if "error" in found:
        raise result.error()
    return found
