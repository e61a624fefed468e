"""Identification of the reduced model from runs of the full model: design of experiments, rows, fit and errors."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from .errors import GelfmuError
from .folder import SweepFolder
from .reduced_law import fit_penetration, fit_rings, fit_spring, ring_columns, speed_columns, stations
from .samplers import Sobol, Uniform
from .scene import Scene, new_shot_values
from .shot import Shot
from .sweeping import run_scenes
from .tasks import COMPLETED

# Bodies whose scenes are scaled to other calibres: name in the library, radius (m), and the keys of the shape.
BODIES = {"sphere": "bb", "round-nose": "45acp-230-xtp-recovered"}
# Range of the design: calibre (m), sectional density (kg/m²) and speed (m/s).
RANGE = {"diameter": (3e-3, 20e-3), "sectional_density": (15.0, 120.0), "speed": (50.0, 1000.0)}
_BLOCK = "15x15x40cm"
# Lengths of a scene that scale with the calibre.
_LENGTHS = ("mesh.size", "remesh.smallest", "remesh.erosion_thickness", "size", "core", "smallest", "erosion_thickness")
# Poncelet's law by which `gelfmu new` estimates times: drag coefficient and strength (Pa), density of the gel.
_DRAG, _STRENGTH, _DENSITY = 0.30, 2.32e6, 1030.0
_FIGURES = ("peak_depth", "exit_speed", "rest_depth", "time_of_peak", "time_of_rest", "final_cavity", "cavity")
_SHAPE = ("body", "diameter", "length", "mass", "speed", "thickness", "width")
COLUMNS = [*_SHAPE, "level", "digest", *_FIGURES, *speed_columns(), *ring_columns()]


@dataclass(frozen=True)
class Reduction:
    """Identified coefficients of the reduced model.

    Attributes
    ----------
    rows : DataFrame
        One row for each run of the full model: shot, figures, speeds along the path and rings, SI units.
    coefficients : list of dict
        Classes of bodies, as the table ``[[instant.class]]`` of a scene has them.
    errors : DataFrame
        Runs that were kept out of the fit: shot, and relative errors of depth, exit speed and cavity; NaN where a run
        has no such figure.
    """

    rows: pd.DataFrame
    coefficients: list[dict[str, Any]]
    errors: pd.DataFrame

    def to_toml(self, table: str = "class") -> str:
        """Return the coefficients as TOML; ``instant.class`` is their table in a scene."""
        return "\n".join(_class_lines(found, table) for found in self.coefficients)


def reduce_model(
    bodies: Sequence[str] = tuple(BODIES),
    *,
    runs: int = 128,
    level: str = "coarse",
    gel: str | None = None,
    out: str | Path = "gelfmu-out/reduce",
    rows: str | Path | None = None,
    workers: int | None = None,
    progress: bool = True,
) -> Reduction:
    """Identify the reduced model of spheres and bodies with a round nose, about an axis.

    The first half of a Sobol sequence over calibre, sectional density and speed is fitted; the second half is kept out,
    and run with the reduced model for its errors. Finished runs are kept in `out`: the same call after a kill runs the
    others only.

    Parameters
    ----------
    bodies : sequence of str
        ``"sphere"``, ``"round-nose"`` or both.
    runs : int
        Runs of the full model for each class of bodies, of which half are fitted.
    level : str
        Level of these runs.
    gel : str, optional
        As of `Scene.new_shot`.
    out : str or Path
        Folder with the runs, ``rows.csv``, ``errors.csv`` and ``coefficients.toml``.
    rows : str or Path, optional
        Rows of an earlier call, in the place of the runs of the full model.
    workers : int, optional
        Number of local workers; all cores if absent.
    progress : bool
        Show a bar in notebooks and terminals.

    Raises
    ------
    GelfmuError
        For an unknown body, too few runs, or a run that did not reach its end.
    """
    unknown = next((body for body in bodies if body not in BODIES), None)
    if unknown is not None or not bodies:
        raise GelfmuError(f"bodies: found {unknown or 'none'}, expected {' or '.join(BODIES)}", key="bodies")
    if runs < 16:
        raise GelfmuError(f"runs: found {runs}, expected at least 16: half of them are fitted", key="runs")
    folder = SweepFolder(out)
    folder.claim(["rows.csv", "errors.csv", "coefficients.toml"])
    if rows is None:
        made = pd.concat([_run_design(body, runs, level, gel, folder.path, workers, progress) for body in bodies])
        made = made.reset_index(drop=True)
    else:
        made = read_rows(rows)
    coefficients = [_fit_class(body, made[made["body"] == body]) for body in bodies]
    kept_out = pd.concat([halves(made, body)[1] for body in bodies])
    errors = _measure_errors(kept_out, coefficients, gel, folder.path, workers, progress)
    for found in coefficients:
        own = errors[errors["body"] == found["body"]]
        for name in ("depth_error", "exit_error", "cavity_error"):
            found[name] = _ninetieth(own[name])
    result = Reduction(made, coefficients, errors)
    texts = {
        "rows.csv": made.to_csv(index=False, float_format="%.6g"),
        "errors.csv": errors.to_csv(index=False, float_format="%.6g"),
        "coefficients.toml": result.to_toml(),
    }
    folder.publish({name: text.encode() for name, text in texts.items()})
    return result


def halves(rows: pd.DataFrame, body: str) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Return the rows of a class of bodies that are fitted, and those that are kept out."""
    own = rows[rows["body"] == body]
    return own.iloc[: len(own) // 2], own.iloc[len(own) // 2 :]


def design(body: str, runs: int) -> pd.DataFrame:
    """Return the shots of the design of a class of bodies: diameter (m), mass (kg) and speed (m/s)."""
    seed = 1 + list(BODIES).index(body)
    logarithms = {name: Uniform(math.log(least), math.log(most)) for name, (least, most) in RANGE.items()}
    shots = np.exp(Sobol(logarithms, runs, seed=seed).table())
    shots["mass"] = shots.pop("sectional_density") * math.pi * shots["diameter"] ** 2 / 4
    return shots.map(lambda value: float(f"{value:.4g}"))


def scaled_scene(body: str, shot: pd.Series, level: str, gel: str | None = None) -> Scene:
    """Return the scene of a body of another calibre and mass: that of the library with all lengths in proportion."""
    plain = new_shot_values(BODIES[body], float(shot["speed"]), block=_BLOCK, gel=gel)["text"]
    text = "\n".join(line for line in plain.splitlines() if not line.lstrip().startswith(("#", "library")))
    radius = _library_radius(body)
    ratio = 0.5 * float(shot["diameter"]) / radius
    number = r"(?<![\w.]){} ?= ?([0-9.e+-]+)"
    for key in _LENGTHS:
        text = re.sub(number.format(re.escape(key)), lambda found: _scaled(found, ratio), text)
    position = re.search(r"position = \[0\.0, 0\.0, ([0-9.e+-]+)\]", text)
    assert position is not None
    shape = _scaled_shape(body, ratio)
    start = f"[0.0, 0.0, {float(position[1]) * ratio:.6g}]"
    own = f"mass = {float(shot['mass'])!r}\n{shape}\nposition = {start}"
    text = text.replace(position[0], own, 1)
    made = Scene(text)
    made["scene.name"] = f"{body}-{round(1e6 * shot['diameter'])}-um-{round(shot['speed'])}"
    made["scene.title"] = f"{body} of {1e3 * shot['diameter']:.3g} mm, {1e3 * shot['mass']:.3g} g"
    made["scene.end_time"] = float(f"{1.5 * _stopping_time(shot) + 12e-3:.4g}")
    made["output.force_window"] = float(f"{shot['diameter'] / shot['speed']:.4g}")
    made["scene.fidelity"] = level
    return made


def read_rows(path: str | Path) -> pd.DataFrame:
    """Read rows of an earlier call.

    Raises
    ------
    GelfmuError
        For a table that is none of `reduce_model`.
    """
    found = pd.read_csv(path)
    if list(found.columns) != COLUMNS:
        remedy = "the file rows.csv that python -m ballistic_gel reduce writes"
        raise GelfmuError(f"{path}: found another table, expected {remedy}", remedy=remedy)
    return found


def _scaled(found: re.Match[str], ratio: float) -> str:
    whole = found[0]
    return whole[: len(whole) - len(found[1])] + f"{float(found[1]) * ratio:.6g}"


def _library_shape(body: str) -> dict[str, Any]:
    shape = Scene.new_shot(BODIES[body]).check().values["values"]["projectile"]["shape"]
    return dict(shape)


def _library_radius(body: str) -> float:
    return float(next(iter(_library_shape(body).values()))["radius"])


def _scaled_shape(body: str, ratio: float) -> str:
    ((kind, shape),) = _library_shape(body).items()
    lengths = {key: value * ratio if isinstance(value, float) else value for key, value in shape.items()}
    return "\n".join(f"shape.{kind}.{key} = {json.dumps(value)}" for key, value in lengths.items())


def _stopping_time(shot: pd.Series) -> float:
    """Return the time in which the body stops by Poncelet's law, s."""
    area = math.pi * shot["diameter"] ** 2 / 4
    drag = 0.5 * _DENSITY * _DRAG
    return float(
        shot["mass"] / (area * math.sqrt(drag * _STRENGTH)) * math.atan(shot["speed"] * math.sqrt(drag / _STRENGTH))
    )


def _run_design(
    body: str, runs: int, level: str, gel: str | None, out: Path, workers: int | None, progress: bool
) -> pd.DataFrame:
    """Run the design of a class of bodies, and return its rows."""
    shots = design(body, runs)
    scenes = [scaled_scene(body, shot, level, gel) for _, shot in shots.iterrows()]
    folder = out / f"{body}-{level}"
    found = run_scenes(scenes, folder, labels=shots, keep=True, workers=workers, progress=progress)
    _refuse_unfinished(found)
    table = [_row_of(body, level, shot, Shot.load(folder / shot["folder"])) for _, shot in found.iterrows()]
    return pd.DataFrame(table, columns=COLUMNS)


def _refuse_unfinished(found: pd.DataFrame) -> None:
    failed = found[found["status"] != COMPLETED]
    if len(failed):
        first = failed.iloc[0]
        raise GelfmuError(
            f"{len(failed)} runs did not reach their end, the first: {first['status']}: {first['reason']}"
        )


def _row_of(body: str, level: str, shot: pd.Series, run: Shot) -> dict[str, Any]:
    """Return the row of a run."""
    summary = run.summary
    scene = Scene.load(run.folder / "scene.toml")
    radius, thickness = (float(str(scene[f"gel.shape.cylinder.{name}"])) for name in ("radius", "height"))
    return {
        "body": body,
        "diameter": shot["diameter"],
        "length": shot["diameter"] * (1.0 if body == "sphere" else 0.6),
        "mass": shot["mass"],
        "speed": shot["speed"],
        "thickness": thickness,
        "width": 2.0 * radius,
        "level": level,
        "digest": summary["digest"],
        **_figures(summary),
        **stations(run.by_depth, run.cavity, min(summary["peak_depth"], thickness)),
    }


def _figures(summary: dict[str, Any]) -> dict[str, Any]:
    """Return the figures of a run that the reduced model has, too."""
    exit_velocity = summary["exit_velocity"]
    return {
        "peak_depth": summary["peak_depth"],
        "exit_speed": abs(exit_velocity[2]) if exit_velocity else 0.0,
        "rest_depth": summary["rest_depth"],
        "time_of_peak": summary["time_of_peak_depth"],
        "time_of_rest": summary["time_of_rest"],
        "final_cavity": summary["final_cavity_diameter"],
        "cavity": summary["greatest_cavity_diameter"],
    }


def _fit_class(body: str, rows: pd.DataFrame) -> dict[str, Any]:
    """Fit the coefficients of a class of bodies to the first half of its rows; the range is that of all."""
    fitted = halves(rows, body)[0]
    sections = 4.0 * rows["mass"] / (math.pi * rows["diameter"] ** 2)
    figures = {"diameter": rows["diameter"], "sectional_density": sections, "speed": rows["speed"]}
    penetration = {**fit_penetration(fitted), **fit_spring(fitted)}
    return {
        "body": body,
        "level": str(rows["level"].iloc[0]),
        "runs": len(fitted),
        "range": {name: [_rounded(values.min()), _rounded(values.max())] for name, values in figures.items()},
        "penetration": {name: _rounded(value) for name, value in penetration.items()},
        "rings": {name: _rounded(value) for name, value in fit_rings(fitted).items()},
    }


def _rounded(value: float) -> float:
    return float(f"{value:.5g}")


def _measure_errors(
    rows: pd.DataFrame,
    coefficients: list[dict[str, Any]],
    gel: str | None,
    out: Path,
    workers: int | None,
    progress: bool,
) -> pd.DataFrame:
    """Run shots with the reduced model, and return their errors against the rows."""
    classes = [{"depth_error": 0.0, "exit_error": 0.0, "cavity_error": 0.0, **found} for found in coefficients]
    scenes = []
    for _, row in rows.iterrows():
        scene = scaled_scene(row["body"], row, "instant", gel)
        scene["instant"] = {"class": classes}
        scenes.append(scene)
    found = run_scenes(scenes, out / "instant", workers=workers, progress=progress)
    _refuse_unfinished(found)
    figures = pd.DataFrame([_figures(_with_vector(row)) for _, row in found.iterrows()], index=rows.index)
    both = (rows["exit_speed"] > 0.0) & (figures["exit_speed"] > 0.0)
    stops = (rows["exit_speed"] == 0.0) & (figures["exit_speed"] == 0.0)
    relative = {name: abs(figures[name] / rows[name] - 1.0) for name in ("peak_depth", "exit_speed", "cavity")}
    # A shot that leaves the gel in one model and stops in the other has the whole error.
    differs = ~(both | stops)
    return rows[["body", "diameter", "mass", "speed", "peak_depth", "exit_speed", "cavity"]].assign(
        instant_depth=figures["peak_depth"],
        instant_exit=figures["exit_speed"],
        instant_cavity=figures["cavity"],
        depth_error=relative["peak_depth"].where(stops | differs),
        exit_error=relative["exit_speed"].where(both).where(~differs, 1.0),
        cavity_error=relative["cavity"].where(rows["cavity"] < 0.6 * rows["width"]),
    )


def _with_vector(row: pd.Series) -> dict[str, Any]:
    """Return the figures of a row of a sweep with the vector of the exit velocity."""
    speed = row.get("exit_velocity[3]")
    return {**row, "exit_velocity": None if speed is None or pd.isna(speed) else [0.0, 0.0, speed]}


def _ninetieth(errors: pd.Series) -> float:
    known = errors.dropna()
    return float(f"{known.quantile(0.9):.2g}") if len(known) else 1.0


def _class_lines(found: dict[str, Any], table: str) -> str:
    plain = {key: value for key, value in found.items() if not isinstance(value, dict)}
    tables = {key: value for key, value in found.items() if isinstance(value, dict)}
    lines = [f"[[{table}]]", *(f"{key} = {json.dumps(value)}" for key, value in plain.items())]
    for name, values in tables.items():
        lines += [f"{name}.{key} = {json.dumps(value)}" for key, value in values.items()]
    return "\n".join(lines) + "\n"
