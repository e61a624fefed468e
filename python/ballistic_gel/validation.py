"""Validation: measured shots of the library beside computed ones, as a table and a picture."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from .commands import projectiles
from .errors import GelfmuError, unknown_name
from .folder import SweepFolder
from .plots import BLUE, new_axes, svg_of
from .scene import Scene, new_shot_values
from .sweeping import run_scenes
from .tables import markdown
from .tasks import COMPLETED, STOPPED, depth_of, value_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# Relative deviation from the measured range up to which a shot agrees.
BAND = 0.20
# Yaws of the scatter of a service bullet, degrees.
_SCATTER = (1.0, 2.0, 4.0)
# Level of the run that counts: of a bullet that tumbles, in space, and of a shot about an axis, where `coarse` stops a
# recovered shape a tenth too early.
_TUMBLING, _STRAIGHT = "coarse", "standard"
_LEVELS = ("draft", _TUMBLING, _STRAIGHT)
# Ticks of the picture, mm.
_TICKS = (60, 80, 100, 150, 200, 300, 400, 600, 800, 1000)
_FILES = ("validation.csv", "validation.md", "validation.svg")


def measured_shots() -> pd.DataFrame:
    """Return the measured shots that the gel is compared with.

    Returns
    -------
    DataFrame
        ``name``, ``projectile``, ``speed`` (m/s), ``yaw`` (degrees, assumed), ``block`` (m), ``measure`` (``depth`` at
        rest, or ``neck``, the depth at which the yaw passes 30°), ``low`` and ``high`` (m), ``grade`` of the source
        (``B`` was read in a secondary place, ``C`` is quoted without its source), ``fitted`` and ``source``.
    """
    with resources.files(__package__).joinpath("data", "measured_shots.csv").open(encoding="utf-8") as file:
        return pd.read_csv(file)


def measured_scene(shot: pd.Series[Any], yaw: float | None = None) -> Scene:
    """Return the scene of a measured shot, of its own yaw or of another one, degrees."""
    made = new_shot_values(
        shot["projectile"], shot["speed"], yaw=shot["yaw"] if yaw is None else yaw, roll=0.0, block=shot["block"]
    )
    scene = Scene(made["text"])
    if shot["measure"] == "neck":
        scene["scene.end_time"] = float(2.0 * shot["high"] / shot["speed"])
    return scene


@dataclass(frozen=True)
class Validation:
    """Computed beside measured figures of the library.

    Attributes
    ----------
    runs : DataFrame
        One row for each run: ``shot``, ``level``, ``yaw`` (degrees), ``status``, ``reason`` and figures.
    table : DataFrame
        One row for each shot: the columns of `measured_shots`, ``level``, ``status`` and ``perforated`` of the run that
        counts, ``has_run``, false if it was refused or is missing, ``computed``, ``least`` and ``greatest`` value of
        the scatter at draft (m), ``deviation`` from the measured range, and ``agrees``. ``cavity`` (m) and ``energy``
        in a centimetre (J) are the greatest ones. ``judged`` is true if the source is of grade B and the gel is not
        fitted to the shot.
    missing : int
        Number of runs that other shares have.
    """

    runs: pd.DataFrame
    table: pd.DataFrame
    missing: int

    @property
    def judged(self) -> int:
        """Number of judged shots whose run is there."""
        return int((self.table["judged"] & self.table["has_run"]).sum())

    @property
    def agreeing(self) -> int:
        """Number of judged shots whose computed value is within 20 % of the measured range."""
        return int((self.table["judged"] & self.table["agrees"]).sum())

    def to_markdown(self) -> str:
        """Return the table as Markdown, lengths in mm."""
        return markdown(
            {
                "shot": shot["name"],
                "figure": shot["measure"],
                "measured, mm": _span(shot["low"], shot["high"]),
                "grade": shot["grade"] + (", fitted" if shot["fitted"] else ""),
                "level": shot["level"],
                "computed, mm": _computed(shot),
                "to the measured, %": _deviation(shot),
                "scatter at `draft`, mm": _span(shot["least"], shot["greatest"]),
                "cavity, mm": _rounded(1e3 * shot["cavity"]),
                "energy, J/cm": _rounded(shot["energy"]),
            }
            for _, shot in self.table.iterrows()
        )

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw computed against measured figures, with the band of 20 % and the scatter at draft."""
        ax = new_axes(ax, (6.4, 6.0))
        ends = np.array([60.0, 1000.0])
        for factor, shade in ((1.0 - BAND, 0.3), (1.0, 0.8), (1.0 + BAND, 0.3)):
            ax.plot(ends, factor * ends, color="black", alpha=shade, linewidth=1)
        for _, shot in self.table.iterrows():
            colour = BLUE if shot["judged"] else "0.6"
            middle = 1e3 * np.sqrt(shot["low"] * shot["high"])
            ax.plot([middle] * 2, [1e3 * shot["least"], 1e3 * shot["greatest"]], color=colour, alpha=0.5)
            computed = 1e3 * shot["computed"]
            ax.plot([1e3 * shot["low"], 1e3 * shot["high"]], [computed] * 2, color=colour)
            ax.plot(middle, computed, "o", color=colour, markersize=4)
            if shot["judged"] or abs(shot["deviation"]) > 0.5 * BAND:
                ax.annotate(
                    shot["name"], (middle, computed), (4, 2), textcoords="offset points", fontsize=6, color=colour
                )
        ax.set(xscale="log", yscale="log", xlim=ends, ylim=ends, title="Measured shots: computed against measured")
        for axis in (ax.xaxis, ax.yaxis):
            axis.set_ticks(_TICKS, [str(tick) for tick in _TICKS])
            axis.set_ticks([], minor=True)
        ax.set(xlabel="measured, mm", ylabel="computed, mm; line: scatter of the yaw at draft")
        return ax


def validate(
    only: Sequence[str] = (),
    *,
    level: str | None = None,
    out: str | Path = "gelfmu-out/validation",
    client: Any = None,
    workers: int | None = None,
    share: str | None = None,
    progress: bool = True,
) -> Validation:
    """Run the measured shots of the library and compare depths and necks.

    A service bullet is run at ``draft`` with some yaws and at ``coarse`` with its usual one, a shot about an axis at
    ``standard``. Finished runs are kept in `out`: the same call goes on where it was interrupted.

    Parameters
    ----------
    only : sequence of str
        Names of the shots to run; all if empty.
    level : str, optional
        Only the runs of this level.
    out : str or Path
        Folder for the rows, ``validation.csv`` (all runs), ``validation.md`` (the table) and ``validation.svg``.
    client, workers, share, progress
        As of `sweep`. Only the share that finds all runs writes the files.

    Returns
    -------
    Validation
        Runs, and the table of the shots.

    Raises
    ------
    GelfmuError
        For an unknown shot or level, and a selection without a run.
    """
    shots = measured_shots()
    for name in only:
        if name not in set(shots["name"]):
            raise unknown_name(name, shots["name"], "measured shot")
    shots = shots[shots["name"].isin(only or shots["name"])].reset_index(drop=True)
    kinds = projectiles().set_index("name")["kind"]
    shots["is_tumbling"] = shots["projectile"].map(kinds) == "service"
    if level not in (None, *_LEVELS):
        raise unknown_name(str(level), _LEVELS, "level of the validation")
    cases = pd.DataFrame([case for _, shot in shots.iterrows() for case in _cases_of(shot, level)])
    if cases.empty:
        remedy = f"no level, or another of {', '.join(_LEVELS)}"
        raise GelfmuError(
            f"level {level}: found no run of {', '.join(shots['name'])}, expected {remedy}", remedy=remedy
        )
    cases = cases.sort_values("level", kind="stable").reset_index(drop=True)  # coarse, the longest, first
    scenes = [case.pop("scene") for case in cases.to_dict("records")]
    labels = cases.drop(columns="scene")
    given: dict[str, Any] = {"client": client, "workers": workers, "share": share, "progress": progress}
    folder = SweepFolder(out)
    folder.claim(_FILES)
    runs = run_scenes(scenes, Path(out) / "runs", labels=labels, **given)
    table = pd.DataFrame([_result_of(shot, runs) for _, shot in shots.iterrows()])
    found = Validation(runs, table, len(cases) - len(runs))
    if found.missing:
        return found
    contents = (found.runs.to_csv(index=False).encode(), found.to_markdown().encode(), svg_of(found.plot().figure))
    folder.publish(dict(zip(_FILES, contents, strict=True)))
    return found


def _cases_of(shot: pd.Series[Any], level: str | None) -> list[dict[str, Any]]:
    """Return the runs of a shot: its usual yaw at the level that counts, and the scatter of a bullet that yaws."""
    cases = [(_level_of(shot), shot["yaw"])]
    cases += [("draft", yaw) for yaw in _SCATTER if shot["is_tumbling"]]
    return [
        {
            "shot": shot["name"],
            "level": own,
            "yaw": yaw,
            "scene": measured_scene(shot, yaw).with_values({"scene.fidelity": own}),
        }
        for own, yaw in cases
        if level in (None, own)
    ]


def _level_of(shot: pd.Series[Any]) -> str:
    return _TUMBLING if shot["is_tumbling"] else _STRAIGHT


def _result_of(shot: pd.Series[Any], runs: pd.DataFrame) -> dict[str, Any]:
    """Return the row of a shot in the table."""
    own = runs[runs["shot"] == shot["name"]]
    counted = own[own["level"] == _level_of(shot)]
    scatter = pd.Series(
        [_figure(shot["measure"], run) for _, run in own[own["level"] == "draft"].iterrows()], dtype=float
    )
    run = counted.iloc[0] if len(counted) else pd.Series(dtype=object)
    computed = _figure(shot["measure"], run)
    deviation = computed / np.clip(computed, shot["low"], shot["high"]) - 1.0
    return {
        **shot,
        "level": _level_of(shot),
        "has_run": run.get("status") in (COMPLETED, STOPPED),
        "status": run.get("status"),
        "perforated": bool(run.get("perforated") == True),  # noqa: E712 - neither None nor NaN
        "computed": computed,
        "deviation": deviation,
        "agrees": bool(abs(deviation) <= BAND),
        "judged": shot["grade"] == "B" and not shot["fitted"],
        "least": scatter.min(),
        "greatest": scatter.max(),
        "cavity": value_of(run.get("greatest_cavity_diameter")),
        "energy": value_of(run.get("greatest_energy_per_centimetre")),
    }


def _figure(measure: str, run: pd.Series[Any]) -> float:
    """Return the measured figure of a run, m; NaN if the run did not get there."""
    if measure == "neck":
        return value_of(run.get("neck_length"))
    if run.get("status") != COMPLETED or run["perforated"]:
        return np.nan
    return depth_of(measure, run)


def _computed(shot: pd.Series[Any]) -> str:
    if not shot["has_run"]:
        return shot["status"] or ""
    if np.isnan(shot["computed"]):
        left = "through the block" if shot["perforated"] and shot["measure"] == "depth" else "not reached"
        return left if shot["status"] == COMPLETED else "stopped early"
    return _rounded(1e3 * shot["computed"])


def _deviation(shot: pd.Series[Any]) -> str:
    if np.isnan(shot["deviation"]):
        return ""
    percent = round(100.0 * shot["deviation"])
    text = f"{percent:+d}".replace("-", "−") if percent else "0"
    return f"**{text}**" if shot["judged"] and not shot["agrees"] else text


def _span(low: float, high: float) -> str:
    ends = list(dict.fromkeys([_rounded(1e3 * low), _rounded(1e3 * high)]))
    return "–".join(ends)


def _rounded(value: float) -> str:
    return "" if np.isnan(value) else f"{value:.0f}"
