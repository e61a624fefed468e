"""Laws of the reduced model, and their fit to rows of runs of the full model.

The formulas are those of the program (`docs/method/reduced.md`); only their coefficients are found here.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from .samplers import import_scipy

# Parts of the greatest depth, or of the thickness, at which a row has the speed.
FRACTIONS = np.linspace(0.05, 0.95, 13)
# Depths of the rings of a row, as parts of the same, and what each has.
RINGS = np.array([0.1, 0.2, 0.35, 0.5, 0.65, 0.8])
_RING = ("speed", "greatest", "opening")
# Start of the fit of the penetration law.
PENETRATION = {
    "shear_stress": 2.3e6,
    "shear_rate": 1300.0,
    "shear_exponent": 2.0,
    "drag": 0.2,
    "drag_growth": 0.3,
    "entry_drag": 0.4,
    "entry_path": 0.4,
    "spring_stress": 2e4,
}
_DENSITY, _GROWTH_SPEED, _REFERENCE = 1030.0, 300.0, 8e-3
_STEPS_PER_CALIBRE = 16
# Distance before the back face at which the section in gel begins to fade, and the length over which it does, calibres.
_EXIT = (1.0, 3.0)
# Differences beyond which a residual counts as an outlier, in logarithms or parts of the first speed.
_SOFT = 0.05
# Least return of a body that counts, m.
_LEAST_RETURN = 5e-4
# Slowest exit, m/s, that is told from a stop.
_SLOW = 30.0


def fly(law: Mapping[str, float], rows: pd.DataFrame) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Fly all shots of some rows through the gel, by the path.

    Parameters
    ----------
    law : mapping
        Coefficients of the penetration law, SI units.
    rows : DataFrame
        ``diameter``, ``length``, ``thickness`` (m), ``mass`` (kg) and ``speed`` (m/s).

    Returns
    -------
    tuple of arrays
        Greatest depth (m), exit speed (m/s, 0 without an exit), and the speed (m/s) at `FRACTIONS` of the greatest
        depth of the rows, one row for each shot.
    """
    diameter, mass = rows["diameter"].to_numpy(), rows["mass"].to_numpy()
    thickness, area = rows["thickness"].to_numpy(), np.pi * diameter**2 / 4
    step = diameter / _STEPS_PER_CALIBRE

    def change(depth: np.ndarray, squared: np.ndarray) -> np.ndarray:
        speed = np.sqrt(np.maximum(squared, 0.0))
        behind = (depth - thickness) / diameter
        section = area * (1.0 - np.clip((behind + _EXIT[0]) / _EXIT[1], 0.0, 1.0))
        drag = law["drag"] + law["entry_drag"] * np.exp(-depth / (law["entry_path"] * diameter))
        drag = drag + law["drag_growth"] * speed / (_GROWTH_SPEED + speed)
        power = (speed / (law["shear_rate"] * diameter)) ** law["shear_exponent"]
        shear = law["shear_stress"] * power / (1.0 + power)
        spring = np.where(behind < 0.0, area * law["spring_stress"], 0.0)
        return -2.0 / mass * (section * (shear + 0.5 * _DENSITY * squared * drag) + spring)

    depth, squared = np.zeros_like(mass), rows["speed"].to_numpy() ** 2
    end = thickness + rows["length"].to_numpy()
    stations = np.minimum(rows["peak_depth"].to_numpy(), thickness)[:, None] * FRACTIONS
    speeds, stops, exits = np.zeros(stations.shape), np.zeros_like(mass), np.zeros_like(mass)
    alive = np.ones(len(mass), dtype=bool)
    while alive.any():
        middle = squared + 0.5 * step * change(depth, squared)
        # Where the half step stops the body, the force there would not.
        whole = np.where(middle > 0.0, squared + step * change(depth + 0.5 * step, middle), 2.0 * middle - squared)
        following = np.where(alive, whole, squared)
        after = depth + step
        part = (stations - depth[:, None]) / step[:, None]
        here = alive[:, None] & (part >= 0.0) & (part < 1.0)
        between = squared[:, None] + part * (following - squared)[:, None]
        speeds = np.where(here, np.sqrt(np.maximum(between, 0.0)), speeds)
        stopped, left = alive & ~(following > 0.0), alive & (following > 0.0) & (after >= end)
        stops = np.where(stopped, depth + step * squared / np.maximum(squared - following, 1e-30), stops)
        stops, exits = np.where(left, thickness, stops), np.where(left, np.sqrt(np.maximum(following, 0.0)), exits)
        alive &= ~(stopped | left)
        depth, squared = np.where(alive, after, depth), np.where(alive, following, squared)
    return np.minimum(stops, thickness), exits, speeds


def fit_penetration(rows: pd.DataFrame) -> dict[str, float]:
    """Fit the penetration law to the speeds along the paths, the greatest depths and the exit speeds of some rows."""
    measured = rows[speed_columns()].to_numpy()
    first, peak = rows["speed"].to_numpy(), rows["peak_depth"].to_numpy()
    leaves, exit_speed = rows["exit_speed"].to_numpy() > 0.0, rows["exit_speed"].to_numpy()

    def residuals(factors: np.ndarray) -> np.ndarray:
        law = {name: value * factor for (name, value), factor in zip(PENETRATION.items(), factors, strict=True)}
        depth, exits, speeds = fly(law, rows)
        along = 0.5 * (speeds - measured) / first[:, None]
        stops = np.where(leaves, 0.0, np.log(depth / peak))
        passes = np.where(leaves, (exits - exit_speed) / (exit_speed + _SLOW), 0.0)
        return np.concatenate([along.ravel(), stops, passes])

    found = import_scipy().optimize.least_squares(
        residuals, np.ones(len(PENETRATION)), bounds=(0.05, 20.0), loss="soft_l1", f_scale=_SOFT
    )
    return {name: float(value * factor) for (name, value), factor in zip(PENETRATION.items(), found.x, strict=True)}


def fit_spring(rows: pd.DataFrame) -> dict[str, float]:
    """Fit the travel of the spring to the greatest depths and the depths of rest."""
    rests = rows[rows["rest_depth"].notna() & (rows["peak_depth"] - rows["rest_depth"] > _LEAST_RETURN)]
    return {"spring_travel": float(((rests["peak_depth"] - rests["rest_depth"]) / rests["diameter"]).median())}


def fit_rings(rows: pd.DataFrame) -> dict[str, float]:
    """Fit the rings of the cavity to greatest diameters, their times, and the diameters at the ends of the runs."""
    rings = ring_table(rows)
    wide = rings[(rings["greatest"] > 1.1 * rings["diameter"]) & (rings["greatest"] < 0.6 * rings["width"])]
    d, u, s, greatest = (wide[name].to_numpy() for name in ("diameter", "speed", "depth", "greatest"))

    def residuals(values: np.ndarray) -> np.ndarray:
        slow, speed, n, m, crater = np.exp(values)
        drive = (u / speed) * (d / _REFERENCE) ** m
        return np.asarray(np.log(d * np.sqrt(slow + drive**n * (1.0 - np.exp(-s / (crater * d)))) / greatest))

    least_squares = import_scipy().optimize.least_squares
    start = np.log([1.2, 100.0, 2.5, 0.5, 2.0])
    opening = np.exp(least_squares(residuals, start, loss="soft_l1", f_scale=_SOFT).x)
    timed = wide[wide["opening"] > 0.0]
    size = np.log(timed["greatest"].to_numpy() / _REFERENCE)

    def delays(values: np.ndarray) -> np.ndarray:
        return np.asarray(values[0] + values[1] * size - np.log(timed["opening"].to_numpy()))

    time = least_squares(delays, [-7.0, 1.0], loss="soft_l1", f_scale=_SOFT).x
    rests = rows[rows["final_cavity"].notna() & rows["rest_depth"].notna()]
    rest = (rests["final_cavity"] / rests["diameter"]).median()
    return {
        "slow_section": float(max(1.0, opening[0])),
        "opening_speed": float(opening[1]),
        "speed_exponent": float(opening[2]),
        "size_exponent": float(opening[3]),
        "crater_depth": float(opening[4]),
        "opening_time": float(np.exp(time[0])),
        "time_exponent": float(time[1]),
        "rest_diameter": float(rest),
    }


def speed_columns() -> list[str]:
    """Return the columns of the speeds along the path, m/s."""
    return [f"speed_{round(100 * part):02d}" for part in FRACTIONS]


def ring_columns() -> list[str]:
    """Return the columns of the rings: speed of the nose, greatest diameter, and time from the nose to it."""
    return [f"ring_{round(100 * part):02d}_{name}" for part in RINGS for name in _RING]


def ring_table(rows: pd.DataFrame) -> pd.DataFrame:
    """Return the rings of rows: ``diameter``, ``width``, ``depth``, ``speed``, ``greatest`` and ``opening``."""
    parts = []
    for part in RINGS:
        own = rows[["diameter", "width", *(f"ring_{round(100 * part):02d}_{name}" for name in _RING)]]
        depth = part * np.minimum(rows["peak_depth"], rows["thickness"])
        parts.append(own.set_axis(["diameter", "width", *_RING], axis=1).assign(depth=depth))
    return pd.concat(parts, ignore_index=True).dropna()


def stations(by_depth: pd.DataFrame, cavity: pd.DataFrame, deepest: float) -> dict[str, Any]:
    """Return speeds along the path of a run, and its rings.

    Parameters
    ----------
    by_depth : DataFrame
        Table ``shot.csv`` of the run.
    cavity : DataFrame
        Table ``cavity.csv`` of the run.
    deepest : float
        Greatest depth, at most the thickness of the gel, m.
    """
    depths, speeds = by_depth["depth_m"].to_numpy(), by_depth["velocity_m_per_s"].to_numpy()
    made: dict[str, Any] = dict(zip(speed_columns(), np.interp(FRACTIONS * deepest, depths, speeds), strict=True))
    made |= dict.fromkeys(ring_columns(), np.nan)
    known: Sequence[float] = np.unique(cavity["depth_m"].to_numpy())
    for part in RINGS:
        if len(known) == 0 or part * deepest > known[-1]:
            continue
        depth = known[np.argmin(abs(known - part * deepest))]
        own = cavity[cavity["depth_m"] == depth]
        widest = own.loc[own["diameter_m"].idxmax()]
        passed = np.interp(depth, depths, by_depth["time_s"].to_numpy())
        name = f"ring_{round(100 * part):02d}"
        made[f"{name}_speed"] = np.interp(depth, depths, speeds)
        made[f"{name}_greatest"] = widest["diameter_m"]
        made[f"{name}_opening"] = widest["time_s"] - passed
    return made
