"""Fit of a two-network gel to several measured shots, by non-linear least squares."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from .errors import GelfmuError, unknown_name
from .folder import SweepFolder
from .gel_parameters import PARAMETERS, gel_lines, gel_overrides, parameter_bounds, read_parameter, refuse_missing
from .samplers import import_scipy
from .scene import Scene, as_scene
from .shot_table import read_shot_table, shot_scenes, shot_speeds
from .sweeping import run_scenes
from .tasks import COMPLETED, depth_of, value_of
from .values import Value

# Step of the finite differences, in logarithms: depths on remeshed gels scatter by up to 0.6 %.
_DIFFERENCE = 0.07
# Relative change of the sum of squares below which a step is within that scatter.
_LEAST_DECREASE = 0.01
# First step of a fit, and its greatest distance from the start, in logarithms: factors of 2 and 16.
_FIRST_STEP, _GREATEST_DISTANCE = math.log(2.0), math.log(16.0)
# Step in logarithms below which the change of a depth is that of the scatter.
_LEAST_STEP = 0.03
# Residual, in bands, up to which a shot is met.
_MET = 0.1
# Speed, as a part of that of the impact, above which a projectile still moves at the end of its run.
_MOVING = 0.03
# Singular value, relative to the greatest, below which no shot decides a direction.
_UNDECIDED = 1e-6
_FILES = ("fit.csv", "fit.txt")


@dataclass(frozen=True)
class GelFit:
    """Fit of a gel to several shots, with what each shot decides.

    Attributes
    ----------
    status : str
        ``"fitted"``; ``"not fitted"`` if the number of steps was spent; ``"derivatives"`` if none was asked for.
    values : dict
        Best values of the fitted parameters, SI units.
    lines : str
        Lines with the networks of the fitted gel for a scene file, in TOML.
    table : DataFrame
        One row for each shot: ``measure``, ``value``, ``window``, ``band``, ``computed`` (SI units, in the limit of
        refinement) and ``residual``, the distance from the window in bands.
    sensitivity : DataFrame
        Derivative of each computed value by the logarithm of each parameter, SI units, one row for each shot.
    uncertainty : Series
        Standard deviation of the logarithm of each parameter, if the bands are standard deviations. Shots within their
        windows decide nothing; a parameter that no shot decides has an infinite one.
    leave_one_out : DataFrame
        One row for each shot: the parameters of a fit without it, and the residual that it has then, by the linear
        model of `sensitivity`; NaN if the other shots do not decide the parameters.
    runs : int
        Number of different runs that the fit needed, with those that an earlier call had kept.
    """

    status: str
    values: dict[str, float]
    lines: str
    table: pd.DataFrame
    sensitivity: pd.DataFrame
    uncertainty: pd.Series[float]
    leave_one_out: pd.DataFrame
    runs: int

    def __str__(self) -> str:
        parts = [
            f"{self.status}, {self.runs} runs: {_text_of(self.values)}",
            self.table.to_string(),
            f"derivatives by the logarithms of the parameters\n{self.sensitivity.to_string()}",
            f"standard deviations of the logarithms\n{self.uncertainty.to_string()}",
            f"without one shot, by the linear model\n{self.leave_one_out.to_string()}",
            self.lines,
        ]
        return "\n\n".join(parts)


def fit_gel(
    shots: str | Path | pd.DataFrame = "gelatin-10",
    parameters: Sequence[str] = ("stress", "rate", "shear_modulus"),
    *,
    scene: Scene | str | Path = "fbi-bb",
    values: Mapping[str, Value] | None = None,
    start: Mapping[str, float] | None = None,
    level: str = "standard",
    steps: int = 8,
    without: Sequence[str] = (),
    out: str | Path = "gelfmu-out/fit",
    client: Any = None,
    workers: int | None = None,
    progress: bool = True,
) -> GelFit:
    """Fit parameters of a gel to measured shots: a trust-region least squares of their logarithms, by scipy.

    Finished runs are kept in `out`: the same call goes on where it was interrupted.

    Parameters
    ----------
    shots : str, Path or DataFrame
        Name of a table of the package, path of a CSV file, or a table. Its columns are ``name``, ``speed`` (m/s; two
        for a slope, ``"165/195"``), ``measure`` (``depth`` at rest, ``slope`` of that depth over the speed, or
        ``cavity``, its greatest diameter), ``value`` and ``band`` (m, or s for a slope). It may have ``window``, the
        half width of the range about the value without a residual, and ``limit``, the ratio of the value in the limit
        of refinement to that at `level`. It may also have ``scene``, as `scene`, or the name of a shot of
        `measured_shots`, and ``set``, ``key=value; key=value``.
    parameters : sequence of str
        Parameters to fit: ``stress``, ``rate`` and ``exponent`` of the first power law, ``shear_modulus``,
        ``branches.shear_modulus`` of the first branch, ``critical_stretch`` and ``delay`` of the damage.
    scene : Scene, str or Path
        Scene of the shots that name none.
    values : mapping, optional
        Keys and values that are replaced in the scenes of all shots.
    start : mapping, optional
        Values to start from, by parameter; those in the scene of the first shot if absent. All shots get them.
    level : str
        Level of accuracy of the runs.
    steps : int
        Most steps; 0 computes the derivatives at the start only.
    without : sequence of str
        Names of shots that are left out.
    out : str or Path
        Folder for ``fit.csv``, ``fit.txt`` and the rows.
    client, workers, progress
        As of `sweep`.

    Raises
    ------
    GelfmuError
        For a table that is none of shots, a parameter that a gel does not have, fewer shots than parameters, or a shot
        that has no value at the start.
    """
    scipy = import_scipy()
    table = read_shot_table(shots)
    for name in without:
        if name not in set(table["name"]):
            raise unknown_name(name, table["name"], "shot")
    table = table[~table["name"].isin(without)].reset_index(drop=True)
    _refuse_parameters(parameters, start or {}, table)
    scenes = [shot_scenes(shot, as_scene(scene), level, values or {}) for _, shot in table.iterrows()]
    gels = _gels_of(scenes, parameters, table["name"].tolist())
    folder, given = SweepFolder(out), {"client": client, "workers": workers, "progress": progress}
    folder.claim(_FILES)

    def run(wanted: list[Scene], labels: pd.DataFrame) -> pd.DataFrame:
        return run_scenes(wanted, folder.path / "runs", labels=labels, **given)

    model = ShotModel(table, parameters, scenes, gels, run, tells=progress)
    begin = [(start or {}).get(name) or read_parameter(gels[0], name) or math.nan for name in parameters]
    fit = _fit(model, np.log(begin), steps, scipy)
    tables = (fit.table.join(fit.sensitivity).to_csv().encode(), f"{fit}\n".encode())
    folder.publish(dict(zip(_FILES, tables, strict=True)))
    return fit


class ShotModel:
    """Computed values of some shots by the logarithms of parameters of their gels.

    Parameters
    ----------
    table : DataFrame
        Shots, checked.
    parameters : sequence of str
        Names of the parameters.
    scenes : sequence of lists of Scene
        Scenes of each shot, one for each of its speeds.
    gels : sequence of dict
        Gel of each shot, all its values.
    run : callable
        Function that runs some scenes and returns the table of their figures behind some labels.
    tells : bool
        Print each point on standard error.
    """

    def __init__(
        self,
        table: pd.DataFrame,
        parameters: Sequence[str],
        scenes: Sequence[list[Scene]],
        gels: Sequence[dict[str, Any]],
        run: Callable[[list[Scene], pd.DataFrame], pd.DataFrame],
        tells: bool = False,
    ) -> None:
        self.table, self.parameters, self.gels = table, list(parameters), gels
        self._scenes, self._run, self._tells = scenes, run, tells
        self._known: dict[tuple[float, ...], np.ndarray] = {}
        self.reason: GelfmuError | None = None

    @property
    def runs(self) -> int:
        """Number of different runs so far."""
        return len(self._known) * sum(map(len, self._scenes))

    def values(self, point: np.ndarray) -> dict[str, float]:
        """Return the parameters at a point, rounded to five digits as in a scene."""
        return {name: float(f"{value:.5g}") for name, value in zip(self.parameters, np.exp(point), strict=True)}

    def compute(self, points: Sequence[np.ndarray]) -> list[np.ndarray]:
        """Return the computed values of all shots at some points, SI units, in the limit of refinement.

        A shot without a value has NaN; `reason` is then the last error of such a shot.
        """
        keys = [tuple(self.values(point).values()) for point in points]
        missing = [key for key in dict.fromkeys(keys) if key not in self._known]
        scenes, labels = [], []
        for key in missing:
            values = dict(zip(self.parameters, key, strict=True))
            for (_, shot), own, gel in zip(self.table.iterrows(), self._scenes, self.gels, strict=True):
                changed = gel_overrides(gel, values)
                scenes += [scene.with_values(changed) for scene in own]
                labels += [{"shot": shot["name"], "shot_speed": speed, **values} for speed in shot_speeds(shot)]
        rows = self._run(scenes, pd.DataFrame(labels)) if scenes else pd.DataFrame()
        taken = iter(row for _, row in rows.iterrows())
        for key in missing:
            pairs = zip(self.table.iterrows(), self._scenes, strict=True)
            self._known[key] = np.array([self._value(shot, [next(taken) for _ in own]) for (_, shot), own in pairs])
        return [self._known[key] for key in keys]

    def _value(self, shot: pd.Series[Any], rows: list[pd.Series[Any]]) -> float:
        """Return the computed value of a shot in the limit of refinement; NaN, and its reason, if there is none."""
        try:
            return float(shot["limit"]) * _measure(shot, rows)
        except GelfmuError as error:
            self.reason = error
            return math.nan

    def residuals_of(self, computed: np.ndarray) -> np.ndarray:
        """Return the residuals of computed values, in bands: the distances from the windows."""
        deviation = computed - self.table["value"].to_numpy()
        beyond = np.maximum(np.abs(deviation) - self.table["window"].to_numpy(), 0.0)
        found: np.ndarray = np.sign(deviation) * beyond / self.table["band"].to_numpy()
        return found

    def is_active(self, computed: np.ndarray) -> np.ndarray:
        """Return which shots are outside of their windows, where they decide something."""
        found: np.ndarray = np.abs(computed - self.table["value"].to_numpy()) >= self.table["window"].to_numpy()
        return found

    def residuals(self, point: np.ndarray) -> np.ndarray:
        """Return the residuals at a point; NaN for all if a shot has no value there, which refuses the step."""
        [computed] = self.compute([point])
        found = self.residuals_of(computed)
        if self._tells:
            squares = f"sum of squares {found @ found:.3f}" if np.isfinite(found).all() else f"no value: {self.reason}"
            print(f"{_text_of(self.values(point))}: {squares}", file=sys.stderr)
        return found if np.isfinite(found).all() else np.full(len(found), np.nan)

    def derivatives(self, point: np.ndarray, upper: np.ndarray) -> np.ndarray:
        """Return the derivatives of the computed values by the coordinates.

        They are forward differences, or backward ones at an upper bound and where a shot has no value.

        Raises
        ------
        GelfmuError
            If a shot has no value on either side.
        """
        steps = np.where(point + _DIFFERENCE > upper, -_DIFFERENCE, _DIFFERENCE)
        base, *others = self.compute([point, *(point + np.diag(steps))])
        failed = [i for i, other in enumerate(others) if not np.isfinite(other).all()]
        again = self.compute([point - steps[i] * np.eye(len(point))[i] for i in failed])
        for i, other in zip(failed, again, strict=True):
            others[i], steps[i] = other, -steps[i]
            if not np.isfinite(other).all() and self.reason:
                raise self.reason
        return np.column_stack([(other - base) / step for other, step in zip(others, steps, strict=True)])

    def jacobian(self, point: np.ndarray, upper: np.ndarray) -> np.ndarray:
        """Return the derivatives of the residuals; those of shots within their windows are 0."""
        slopes = self.derivatives(point, upper)
        active = self.is_active(self.compute([point])[0])
        found: np.ndarray = slopes * (active / self.table["band"].to_numpy())[:, None]
        return found


def _fit(model: ShotModel, first: np.ndarray, steps: int, scipy: Any) -> GelFit:
    """Fit the parameters of a model from a first point, in offsets of the logarithms from it."""
    bounds = [np.log(np.maximum(parameter_bounds(model.gels[0], name), 1e-300)) for name in model.parameters]
    least = np.maximum(np.array([low for low, _ in bounds]) - first, -_GREATEST_DISTANCE)
    most = np.minimum(np.array([high for _, high in bounds]) - first, _GREATEST_DISTANCE)
    residuals = model.residuals(first)
    if not np.isfinite(residuals).all() and model.reason:
        raise model.reason
    if steps == 0 or np.abs(residuals).max() <= _MET:
        return _conclude("fitted" if steps else "derivatives", first, first + most, model)

    # The trust region of scipy begins with the radius |x₀|, and its least step is relative to |x|.
    shift = first - _FIRST_STEP / math.sqrt(len(first))

    def residuals_at(x: np.ndarray) -> np.ndarray:
        found = model.residuals(shift + x)
        if np.abs(found).max() <= _MET:
            raise _AllMet(shift + x)
        return found

    try:
        found = scipy.optimize.least_squares(
            residuals_at,
            first - shift,
            lambda x: model.jacobian(shift + x, first + most),
            bounds=(first + least - shift, first + most - shift),
            max_nfev=steps + 1,
            ftol=_LEAST_DECREASE,
            xtol=_LEAST_STEP / _FIRST_STEP,
            gtol=1e-8,
        )
    except _AllMet as met:
        return _conclude("fitted", met.point, first + most, model)
    return _conclude("fitted" if found.status > 0 else "not fitted", shift + found.x, first + most, model)


class _AllMet(Exception):
    """End of a fit at a point at which all shots are met."""

    def __init__(self, point: np.ndarray) -> None:
        super().__init__()
        self.point = point


def _conclude(status: str, point: np.ndarray, upper: np.ndarray, model: ShotModel) -> GelFit:
    slopes, [computed] = model.derivatives(point, upper), model.compute([point])
    residuals = model.residuals_of(computed)
    scaled = slopes / model.table["band"].to_numpy()[:, None]
    active = scaled * model.is_active(computed)[:, None]
    whole = np.linalg.lstsq(active, -residuals, rcond=None)[0]
    left_out = []
    for place in range(len(residuals)):
        others = np.arange(len(residuals)) != place
        step = np.linalg.lstsq(active[others], -residuals[others], rcond=None)[0] - whole
        if np.isinf(_deviations(active[others])).any():
            step = step * np.nan
        left_out.append([*np.exp(point + step), model.residuals_of(computed + slopes @ step)[place]])
    index = pd.Index(model.table["name"], name="shot")
    table = model.table[["measure", "value", "window", "band"]].assign(computed=computed, residual=residuals)
    values = model.values(point)
    return GelFit(
        status=status,
        values=values,
        lines=gel_lines(model.gels[0], values),
        table=table.set_axis(index),
        sensitivity=pd.DataFrame(slopes, index, model.parameters),
        uncertainty=pd.Series(_deviations(active), model.parameters),
        leave_one_out=pd.DataFrame(left_out, index, [*model.parameters, "residual"]),
        runs=model.runs,
    )


def _deviations(jacobian: np.ndarray) -> np.ndarray:
    """Return the standard deviations of parameters with a Jacobian of residuals; infinite for what none decides."""
    count = jacobian.shape[1]
    _, singular, directions = np.linalg.svd(jacobian)
    singular = np.pad(singular, (0, count - len(singular)))
    decided = singular > _UNDECIDED * max(singular.max(), 1e-300)
    variance = ((directions[decided].T / singular[decided]) ** 2).sum(axis=1)
    variance[(np.abs(directions[~decided]) > _UNDECIDED).any(axis=0)] = np.inf
    found: np.ndarray = np.sqrt(variance)
    return found


def _refuse_parameters(parameters: Sequence[str], start: Mapping[str, float], table: pd.DataFrame) -> None:
    """Refuse unknown and repeated parameters, starts without sense, and fewer shots than parameters."""
    for name in [*parameters, *start]:
        if name not in PARAMETERS:
            raise unknown_name(name, PARAMETERS, "parameter")
    if len(set(parameters)) < len(parameters) or not parameters:
        remedy = "different parameters, at least one"
        raise GelfmuError(f"parameters: found {', '.join(parameters) or 'none'}, expected {remedy}", remedy=remedy)
    for name, value in start.items():
        if not isinstance(value, (int, float)) or not 0.0 < value < math.inf:
            remedy = "a number above 0"
            raise GelfmuError(f"start: {name}: found {value!r}, expected {remedy}", key=name, remedy=remedy)
    if len(table) < len(parameters):
        remedy = f"at least {len(parameters)}, one for each parameter"
        raise GelfmuError(f"shots: found {len(table)}, expected {remedy}", key="shots", remedy=remedy)


def _gels_of(scenes: Sequence[list[Scene]], parameters: Sequence[str], names: Sequence[str]) -> list[dict[str, Any]]:
    """Return the gel of each shot with all its values, also those of a preset."""
    known: dict[str, dict[str, Any]] = {}
    gels = []
    for own, name in zip(scenes, names, strict=True):
        key = own[0].digest()
        if key not in known:
            known[key] = own[0].check().values["values"]["gel"]
        for parameter in parameters:
            refuse_missing(known[key], parameter, name)
        gels.append(known[key])
    return gels


def _measure(shot: pd.Series[Any], rows: list[pd.Series[Any]]) -> float:
    """Return what is measured of the runs of a shot, SI units.

    Raises
    ------
    GelfmuError
        If a run has no such figure.
    """
    speeds = shot_speeds(shot)
    if shot["measure"] == "cavity":
        diameter = value_of(rows[0].get("greatest_cavity_diameter"))
        if rows[0]["status"] != COMPLETED:
            remedy = "take a cheaper level, or another shot"
            found = f"it is {rows[0]['status']} ({rows[0]['reason']})"
            raise GelfmuError(f"{shot['name']}: the shot has no cavity, {found}: {remedy}", remedy=remedy)
        if math.isnan(diameter):
            remedy = "a shot along -z into the gel"
            raise GelfmuError(f"{shot['name']}: found no cavity, expected {remedy}", key="measure", remedy=remedy)
        return diameter
    depths = [_rest_depth(shot["name"], speed, row) for speed, row in zip(speeds, rows, strict=True)]
    return depths[0] if len(depths) == 1 else (depths[1] - depths[0]) / (speeds[1] - speeds[0])


def _rest_depth(name: str, speed: float, row: pd.Series[Any]) -> float:
    """Return the depth of a run at rest, m, or at its end if the projectile hardly moves then."""
    depth = depth_of(name, row)
    last = abs(value_of(row.get("final_velocity[3]")))
    if math.isnan(value_of(row.get("rest_depth"))) and last > _MOVING * speed:
        remedy = "a longer scene.end_time"
        raise GelfmuError(
            f"{name}: found a projectile that still moves at {last:.1f} m/s, expected {remedy}", remedy=remedy
        )
    return depth


def _text_of(values: Mapping[str, float]) -> str:
    return ", ".join(f"{name} = {value:.5g}" for name, value in values.items())
