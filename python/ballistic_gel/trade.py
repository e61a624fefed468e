"""Error against cost of a scene: its knobs turned both ways, the limit of refinement, and levels from the runs."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from .errors import GelfmuError, unknown_name
from .folder import SweepFolder
from .knobs import MESH, REMESHED, Rung, ladder
from .options import option_rungs
from .plots import COLOURS, new_axes, svg_of
from .richardson import NoLimit, RefinementLimit, extrapolate_limit
from .samplers import import_scipy
from .scene import Scene, as_scene
from .sweeping import run_scenes
from .tables import digits, markdown, refuse_irregular
from .tasks import COMPLETED, value_of
from .values import toml_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# Compared quantities: name in tables, unit, and number of these units in the SI unit.
QUANTITIES = {
    "peak_depth": ("depth", "mm", 1e3),
    "contact_duration": ("contact", "ms", 1e3),
    "final_speed": ("rebound", "m/s", 1.0),
    "peak_force": ("force", "N", 1.0),
}
# Levels, and the most updates of each, in those of the scene as it is.
_BUDGETS = {"draft": 0.15, "coarse": 0.4, "standard": 1.0, "fine": 4.0, "reference": 16.0}
# Knobs that change the physics instead of the accuracy, or belong to the importer of the FMU.
_NO_LEVELS = ("bulk modulus", "restitution", "dimension", "coupling", "schedule", "lattice")
_FILES = ("trade.csv", "trade.md", "trade.svg")
_OPTION_FILES = ("options.csv", "options.md")
# Figures of a run that a curve needs.
_FIGURES = (
    *("elements", "element_updates", "remeshes", "digest", "peak_depth", "contact_duration", "rebound_velocity"),
    *("peak_force", "cpu_seconds", "final_velocity[1]", "final_velocity[2]", "final_velocity[3]"),
)
_LEGEND = (
    "Errors are relative to the limit of refinement of the same scene; worst is the greatest of them, in brackets with "
    "those of all finer runs of the knob; * marks what no cheaper run does as well."
)


@dataclass(frozen=True)
class TradeCurve:
    """Error-cost curve of a scene.

    Attributes
    ----------
    runs : DataFrame
        One row for each run: ``knob``, ``run``, ``refinement``, ``status``, ``reason``, ``elements``,
        ``element_updates``, ``cpu_seconds``, the compared quantities (SI), their relative errors ``..._error``,
        ``worst``, ``confirmed`` (the greatest error of a run and of all finer ones of its knob: errors of opposite sign
        can cancel by chance) and ``best``, true if no cheaper run has so small a confirmed error.
    limits : dict
        Limit of refinement of each quantity, or a text with the reason why it has none.
    levels : dict
        Tables of ``[fidelity]`` for the scene, by level.
    """

    runs: pd.DataFrame
    limits: dict[str, RefinementLimit | str]
    levels: dict[str, dict[str, Any]]

    @property
    def lines(self) -> str:
        """Levels as lines of a scene file, in TOML."""
        tables = (
            f"[fidelity.{name}]\n" + "".join(f"{key} = {toml_text(value)}\n" for key, value in level.items())
            for name, level in self.levels.items()
        )
        return "\n".join(tables)

    def to_markdown(self) -> str:
        """Return the table, the limits, the runs that failed and the levels as Markdown."""
        table = markdown(_cells(run) for _, run in self.runs.iterrows())
        failed = self.runs[self.runs["status"] != COMPLETED]
        lists = [f"- {name}: {self._limit_text(key)}" for key, (name, _, _) in QUANTITIES.items()]
        lists += [f"- {run['run']}: {run['status']}: {run['reason']}" for _, run in failed.iterrows()]
        levels = f"\n```toml\n{self.lines}```\n" if self.levels else ""
        return f"{table}\n{_LEGEND}\n\n" + "\n".join(lists) + f"\n{levels}"

    def _limit_text(self, key: str) -> str:
        limit, (_, unit, factor) = self.limits[key], QUANTITIES[key]
        if isinstance(limit, str):
            return f"no reference, {limit}"
        order, reach = f"observed order {limit.order:.2f}", digits(100.0 * limit.reach)
        return (
            f"{digits(factor * limit.value, 5)} {unit}, the limit of refinement, {order}; the finest is {reach} % away"
        )

    def plot(self, ax: Axes | None = None, others: pd.DataFrame | None = None) -> Axes:
        """Draw the worst error of each run against its element updates, by knob.

        Parameters
        ----------
        ax : matplotlib Axes, optional
            Axes to draw into.
        others : DataFrame, optional
            Runs of other codes with ``run`` and any of the compared quantities, against their ``cpu_seconds``, to
            which the axis then changes.
        """
        ax = new_axes(ax, (7.2, 4.6))
        cost = "element_updates" if others is None else "cpu_seconds"
        known = self.runs[self.runs["worst"].notna()]
        colours = itertools.cycle(COLOURS)
        for knob, own in known.groupby("knob", sort=False):
            own = own.sort_values(cost)
            label, colour = str(knob) or "as it is", next(colours)
            ax.plot(own[cost], 100.0 * own["worst"], "o-", color=colour, label=label, markersize=4, linewidth=0.8)
        best = known[known["best"]].sort_values(cost)
        ax.plot(best[cost], 100.0 * best["confirmed"], color="black", linewidth=2.0, alpha=0.3, label="best")
        if others is not None:
            errors = add_errors(others.assign(knob="", refinement=0.0, status=COMPLETED), self.limits)["worst"]
            ax.plot(others[cost], 100.0 * errors, "^", color="0.4", label="other codes")
            for name, x, y in zip(others["run"], others[cost], 100.0 * errors, strict=True):
                ax.annotate(str(name), (x, y), (4, 2), textcoords="offset points", fontsize=6)
        ax.set(xscale="log", yscale="log", ylabel="worst error, %")
        ax.set(xlabel="element updates" if others is None else "CPU seconds of one thread")
        for which in (ax.yaxis.set_major_formatter, ax.yaxis.set_minor_formatter):
            which("{x:g}")
        ax.legend(frameon=False, fontsize=7)
        return ax


def error_cost(
    scene: Scene | str | Path,
    *,
    only: Sequence[str] = (),
    finer: int = 3,
    others: str | Path | None = None,
    out: str | Path | None = None,
    client: Any = None,
    workers: int | None = None,
    progress: bool = True,
) -> TradeCurve:
    """Measure error against cost of a scene: each knob is turned towards fine and towards coarse.

    Errors of the motion of the projectile are relative to the limit of refinement of the same scene (Richardson
    extrapolation), and are left out where refinement is not monotone. Each run has one thread. Finished runs are kept.

    Parameters
    ----------
    scene : Scene, str or Path
        Scene, the name of a built-in one, or the path of a file that ends with ``.toml``.
    only : sequence of str
        Knobs to turn beside the mesh; all if empty.
    finer : int
        Number of refinements of all edges by √2 beyond the scene.
    others : str or Path, optional
        CSV file with runs of other codes: columns ``run``, ``cpu_seconds`` and any of the compared quantities.
    out : str or Path, optional
        Folder for ``trade.csv``, ``trade.md``, ``trade.svg`` and the rows; ``gelfmu-out/SCENE-trade`` if absent.
    client, workers, progress
        As of `sweep`.

    Returns
    -------
    TradeCurve
        Runs with their errors, limits of refinement, and levels.

    Raises
    ------
    GelfmuError
        For an unknown knob, a table of other codes that cannot be read, or without scipy.
    """
    import_scipy()  # refuses before the first run what its end needs
    scene = as_scene(scene)
    out = Path("gelfmu-out") / f"{scene.name}-trade" if out is None else Path(out)
    peers = None if others is None else _read_others(Path(others))
    checked = scene.check().values
    knobs = list(dict.fromkeys(rung.knob for rung in ladder(checked) if not rung.knob.startswith(MESH) and rung.knob))
    for name in only:
        if name not in knobs:
            raise unknown_name(name, knobs, f"knob of {scene.name}")
    given: dict[str, Any] = {"client": client, "workers": workers, "progress": progress}
    folder = SweepFolder(out)
    folder.claim(_FILES)
    first = _run_rungs(scene, checked, [Rung(size=1.0)], out, given)
    rungs = ladder(checked, finer, first["status"].iloc[0] != COMPLETED)
    rungs = [rung for rung in rungs if not only or rung.knob.startswith(MESH) or rung.knob in ("", *only)]
    curve = build_curve(_run_rungs(scene, checked, rungs, out, given))
    table = curve.runs.drop(columns="values").to_csv(index=False).encode()
    contents = (table, curve.to_markdown().encode(), _picture_of(curve, peers))
    folder.publish(dict(zip(_FILES, contents, strict=True)))
    return curve


def option_costs(
    scene: Scene | str | Path, *, out: str | Path | None = None, workers: int | None = 1, progress: bool = True
) -> pd.DataFrame:
    """Measure what each option that a scene leaves out costs, switched off and switched on.

    Parameters
    ----------
    scene : Scene, str or Path
        As of `error_cost`.
    out : str or Path, optional
        Folder for ``options.csv``, ``options.md`` and the rows; ``gelfmu-out/SCENE-options`` if absent.
    workers : int
        Number of local workers: one, as others would disturb the times.
    progress : bool
        As of `sweep`.

    Returns
    -------
    DataFrame
        ``option``, ``run``, ``status``, ``same_bits`` as the scene as it is, ``element_updates``, ``cpu_seconds``, and
        both relative to the scene as it is. Times of rows with the same bits show the noise of the machine.

    Raises
    ------
    GelfmuError
        If the scene as it is does not reach its end.
    """
    scene = as_scene(scene)
    out = Path("gelfmu-out") / f"{scene.name}-options" if out is None else Path(out)
    folder, checked = SweepFolder(out), scene.check().values
    folder.claim(_OPTION_FILES)
    rungs = [Rung(), *option_rungs(checked["values"])]
    runs = _run_rungs(scene, checked, rungs, out, {"workers": workers, "progress": progress})
    base = runs.iloc[0]
    if base["status"] != COMPLETED:
        remedy = "a scene that reaches its end"
        raise GelfmuError(f"{scene.name}: found a run that is {base['status']} ({base['reason']}), expected {remedy}")
    costs = runs[["knob", "run", "status"]].rename(columns={"knob": "option"})
    costs["same_bits"] = runs["digest"] == base["digest"]
    for name in ("element_updates", "cpu_seconds"):
        costs[name], costs[f"{name}_ratio"] = runs[name], runs[name] / base[name]
    table = markdown(
        {str(name): digits(value) if isinstance(value, float) else str(value) for name, value in row.items()}
        for row in costs.to_dict("records")
    )
    contents = (costs.to_csv(index=False).encode(), table.encode())
    folder.publish(dict(zip(_OPTION_FILES, contents, strict=True)))
    return costs


def _run_rungs(
    scene: Scene, checked: Mapping[str, Any], rungs: list[Rung], out: Path, given: dict[str, Any]
) -> pd.DataFrame:
    """Run a ladder, the finest meshes first, and return its rows in the order of the ladder."""
    fields = ("knob", "label", "refinement", "size")
    labels = pd.DataFrame([[getattr(rung, name) for name in fields] for rung in rungs], columns=fields)
    labels = labels.rename(columns={"label": "run"})
    scenes = [scene.with_values(rung.values) for rung in rungs]
    order = np.argsort([-rung.refinement for rung in rungs], kind="stable")
    runs = run_scenes([scenes[i] for i in order], out / "runs", labels=labels.iloc[order], clock=True, **given)
    runs = runs.set_axis(order[runs.index]).sort_index()
    # Rows of failures alone have no figures.
    runs = runs.reindex(columns=list(dict.fromkeys([*runs, *_FIGURES])))
    values: list[Any] = [dict(rungs[place].values) for place in runs.index]
    return _with_final_speed(runs.assign(values=values), checked["values"])


def _with_final_speed(runs: pd.DataFrame, scene: Mapping[str, Any]) -> pd.DataFrame:
    """Return runs with the speed at the end against the direction of the impact, and that of the impact, m/s.

    The former is the rebound speed, relative to the block; while the projectile touches the gel it has none, and its
    velocity in the world frame is compared then.
    """
    velocity = np.subtract(scene["projectile"]["velocity"], scene["gel"].get("velocity") or [0.0, 0.0, 0.0])
    speed = float(np.linalg.norm(velocity))
    last = runs[[f"final_velocity[{axis}]" for axis in (1, 2, 3)]].to_numpy(dtype=float)
    at_end = -last @ velocity / speed if speed > 0.0 else np.zeros(len(runs))
    rebound = runs["rebound_velocity"].astype(float)
    contact = runs["contact_duration"].where(rebound.notna())
    final = rebound.fillna(pd.Series(at_end, runs.index))
    return runs.assign(contact_duration=contact, final_speed=final, initial_speed=speed)


def build_curve(runs: pd.DataFrame) -> TradeCurve:
    """Assess the finished runs of a ladder.

    Parameters
    ----------
    runs : DataFrame
        ``knob``, ``run``, ``refinement``, ``size``, ``values``, ``status``, ``reason``, ``element_updates``,
        ``cpu_seconds``, ``remeshes``, ``initial_speed`` and the compared quantities.
    """
    limits = {key: _limit_of(key, runs) for key in QUANTITIES}
    runs = add_errors(runs, limits)
    confirmed = [_confirmed_error(run, runs) for _, run in runs.iterrows()]
    runs = runs.assign(confirmed=confirmed)
    runs["best"] = [_is_best(run, runs) for _, run in runs.iterrows()]
    return TradeCurve(runs, limits, _levels_of(runs))


def add_errors(runs: pd.DataFrame, limits: dict[str, RefinementLimit | str]) -> pd.DataFrame:
    """Return runs with their relative errors, and the worst of those that are known."""
    errors = {}
    for key, limit in limits.items():
        value = pd.Series(np.nan, runs.index) if key not in runs else runs[key].astype(float)
        value = value.where(runs["status"] == COMPLETED)
        error = value * np.nan if isinstance(limit, str) else (value - limit.value).abs() / limit.scale
        errors[f"{key}_error"] = error
    table = pd.DataFrame(errors)
    return runs.assign(**table, worst=table.max(axis=1))


def _limit_of(key: str, runs: pd.DataFrame) -> RefinementLimit | str:
    """Extrapolate the three finest meshes of the scene's own family, else of the remeshed one."""
    scale = float(runs["initial_speed"].iloc[0]) if key == "final_speed" else 0.0
    for family in (MESH, REMESHED):
        meshes = _finest_three(key, runs, family)
        if meshes is None:
            continue
        try:
            return extrapolate_limit(*meshes, scale=scale or None)
        except NoLimit as why:
            return f"its three finest values are {why}"
    return "fewer than three meshes have it"


def _finest_three(key: str, runs: pd.DataFrame, family: str) -> tuple[list[float], list[float]] | None:
    """Return sizes and values of the three finest meshes of a family.

    Remeshed runs must each be twice as fine as the one before: a new mesh starts from a square that is halved again
    and again, and sizes between these steps belong to another family.
    """
    own = runs[(runs["knob"] == family) | ((family == MESH) & (runs["knob"] == ""))]
    known = own[(own["status"] == COMPLETED) & own[key].notna() & own["size"].notna()].sort_values("size")
    if known.empty:
        return None
    if (own["remeshes"].fillna(0) > 0).any():
        ratios = known["size"] / known["size"].iloc[0]
        known = known[[any(abs(ratio - own) < 0.01 * own for own in (1.0, 2.0, 4.0)) for ratio in ratios]]
    if len(known) < 3:
        return None
    finest = known.head(3)[::-1]
    return finest["size"].tolist(), finest[key].tolist()


def _confirmed_error(run: pd.Series[Any], runs: pd.DataFrame) -> float:
    """Return the greatest error of a run and of all finer runs of its knob: errors of opposite sign can cancel."""
    own = run["knob"] or MESH
    knobs = runs["knob"].replace("", MESH)
    is_finer = (runs["refinement"] > run["refinement"]) & ((knobs == own) | (runs["refinement"] == 0.0))
    return float(np.nan if math.isnan(run["worst"]) else np.nanmax([run["worst"], *runs["worst"][is_finer]]))


def _is_best(run: pd.Series[Any], runs: pd.DataFrame) -> bool:
    """Return whether a run is on the Pareto front: no other is at least as good in both, and better in one."""
    cost, error = runs["element_updates"], runs["confirmed"]
    no_worse = (cost <= run["element_updates"]) & (error <= run["confirmed"])
    better = (cost < run["element_updates"]) | (error < run["confirmed"])
    return bool(not math.isnan(run["confirmed"]) and not (no_worse & better).any())


def _levels_of(runs: pd.DataFrame) -> dict[str, dict[str, Any]]:
    """Return the most accurate runs within 0.15, 0.4, 4 and 16 of the updates of the scene, the standard.

    A more expensive level is always more accurate.
    """
    usable = runs[runs["confirmed"].notna() & ~runs["knob"].isin(_NO_LEVELS)]
    standard = usable[usable["knob"] == ""]
    if standard.empty:
        return {}
    confirmed = usable[[_is_confirmed(run, runs) for _, run in usable.iterrows()]]
    chosen = {"standard": standard.iloc[0]}
    unit = float(standard["element_updates"].iloc[0])

    def add(level: str, neighbour: str, sign: float) -> None:
        other = chosen[neighbour]
        cheaper = sign * (confirmed["element_updates"] - other["element_updates"]) > 0.0
        worse = sign * (other["confirmed"] - confirmed["confirmed"]) > 0.0
        found = confirmed[cheaper & worse & (confirmed["element_updates"] <= _BUDGETS[level] * unit)]
        if len(found):
            chosen[level] = found.loc[found["confirmed"].idxmin()]

    add("coarse", "standard", -1.0)
    add("draft", "coarse" if "coarse" in chosen else "standard", -1.0)
    add("fine", "standard", 1.0)
    add("reference", "fine" if "fine" in chosen else "standard", 1.0)
    return {level: _level_of(chosen[level]) for level in _BUDGETS if level in chosen}


def _is_confirmed(run: pd.Series[Any], runs: pd.DataFrame) -> bool:
    """Return whether the reference is of the run's own family, or a finer run of its knob has an error, too."""
    finer = (runs["knob"] == run["knob"]) & (runs["refinement"] > run["refinement"]) & runs["worst"].notna()
    return run["knob"] in ("", MESH, REMESHED) or bool(finer.any())


def _level_of(run: pd.Series[Any]) -> dict[str, Any]:
    figures = {
        "error": run["confirmed"],
        "updates": run["element_updates"],
        "cpu_seconds": value_of(run["cpu_seconds"]),
    }
    set_ = [f"{key}={toml_text(value)}" for key, value in run["values"].items()]
    return {"set": set_, **{key: float(f"{value:.2e}") for key, value in figures.items() if not math.isnan(value)}}


def _cells(run: pd.Series[Any]) -> dict[str, str]:
    """Return the cells of a run in the table."""

    def percent(error: float) -> str:
        return "-" if math.isnan(error) else digits(100.0 * error)

    is_hidden = run["confirmed"] > 1.001 * run["worst"]
    worst = f"{percent(run['worst'])} ({percent(run['confirmed'])})" if is_hidden else percent(run["worst"])
    updates, seconds = value_of(run.get("element_updates")), value_of(run.get("cpu_seconds"))
    elements = value_of(run.get("elements"))
    errors = {f"{name}, %": percent(run[f"{key}_error"]) for key, (name, _, _) in QUANTITIES.items()}
    return {
        "knob": run["knob"],
        "run": run["run"],
        "elements": "-" if math.isnan(elements) else f"{elements:.0f}",
        "M updates": "-" if math.isnan(updates) else digits(1e-6 * updates),
        "CPU s": "-" if math.isnan(seconds) else digits(seconds),
        **errors,
        "worst, %": worst if run["status"] == COMPLETED else run["status"],
        "best": "*" if run["best"] else "",
    }


def _read_others(path: Path) -> pd.DataFrame:
    """Return the runs of other codes."""
    remedy = f"columns run, cpu_seconds (above 0) and any of {', '.join(QUANTITIES)}, numbers or empty cells"

    def refusal(found: Any) -> GelfmuError:
        return GelfmuError(f"others {path}: found {found}, expected {remedy}", remedy=f"expected {remedy}")

    try:
        refuse_irregular(path)
        table = pd.read_csv(path)
        for name in ("run", "cpu_seconds"):
            if name not in table:
                raise refusal(f"no column {name}")
        for key in ("cpu_seconds", *QUANTITIES):
            table[key] = pd.to_numeric(table[key]) if key in table else np.nan
    except (OSError, ValueError) as error:
        raise refusal(error) from error
    if not (table["cpu_seconds"] > 0.0).all():
        raise refusal("CPU seconds that are not above 0")
    return table


def _picture_of(curve: TradeCurve, others: pd.DataFrame | None) -> bytes:
    """Draw the curve against element updates, and beside it against CPU seconds with the runs of other codes."""
    import matplotlib.pyplot as plt

    count = 1 if others is None else 2
    figure, axes = plt.subplots(1, count, figsize=(7.2 * count, 4.6), squeeze=False, layout="constrained")
    curve.plot(axes[0, 0])
    if others is not None:
        curve.plot(axes[0, 1], others)
    return svg_of(figure)
