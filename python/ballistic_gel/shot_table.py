"""Tables of measured shots that a gel is fitted to."""

from __future__ import annotations

import io
import math
from collections.abc import Mapping
from importlib import resources
from pathlib import Path
from typing import Any

import pandas as pd

from .errors import GelfmuError, unknown_name
from .scene import Scene, as_scene
from .tables import refuse_irregular
from .validation import measured_scene, measured_shots
from .values import Value, parse_override

_COLUMNS = ("name", "scene", "speed", "measure", "value", "band", "window", "limit", "set")
_NEEDED = ("name", "speed", "measure", "value", "band")
_MEASURES = ("depth", "slope", "cavity")
_TEXTS = ("name", "scene", "speed", "measure", "set")
# Tables of the package.
_TABLES = ("gelatin-10",)


def read_shot_table(shots: str | Path | pd.DataFrame) -> pd.DataFrame:
    """Return a table of shots with all columns, checked.

    Parameters
    ----------
    shots : str, Path or DataFrame
        Name of a table of the package, path of a CSV file, whose lines with ``#`` are comments, or a table.

    Raises
    ------
    GelfmuError
        For a file that cannot be read, a column that is missing or unknown, or a cell without sense.
    """
    place, table, places = "shots", shots, None
    if not isinstance(table, pd.DataFrame):
        place = str(shots)
        table, places = _read_file(place)
    for name in map(str, table.columns):
        if name not in _COLUMNS:
            raise unknown_name(name, _COLUMNS, "column of shots")
    for name in _NEEDED:
        if name not in table:
            remedy = f"the columns {', '.join(_NEEDED)}"
            raise GelfmuError(f"{place}: found no column {name}, expected {remedy}", key=name, remedy=remedy)
    table = table.reset_index(drop=True).reindex(columns=list(_COLUMNS))
    for column, default in (("window", 0.0), ("limit", 1.0)):
        table[column] = table[column].fillna(default)
    table["name"] = table["name"].map(str, na_action="ignore")
    rows = places or [f"row {number}" for number in range(1, len(table) + 1)]
    for row, (_, shot) in zip(rows, table.iterrows(), strict=True):
        _refuse_shot(f"{place}: {row}", shot)
    repeated = table["name"][table["name"].duplicated()]
    if len(repeated):
        remedy = "another name for each shot"
        raise GelfmuError(f"{place}: name: found {repeated.iloc[0]!r} twice, expected {remedy}", remedy=remedy)
    return table.astype({column: float for column in ("value", "band", "window", "limit")})


def shot_speeds(shot: pd.Series[Any]) -> list[float]:
    """Return the speeds of a shot, m/s: one, or two of a slope; NaN for what is no number."""
    return [float(pd.to_numeric(text.strip(), errors="coerce")) for text in str(shot["speed"]).split("/")]


def shot_scenes(shot: pd.Series[Any], common: Scene, level: str, values: Mapping[str, Value]) -> list[Scene]:
    """Return the scene of a shot at each of its speeds.

    Parameters
    ----------
    shot : Series
        Row of a checked table.
    common : Scene
        Scene of a shot that names none.
    level : str
        Level of accuracy.
    values : mapping
        Keys and values that are replaced; those of the shot come last.
    """
    measured = measured_shots().set_index("name", drop=False)
    name, scenes = shot["scene"], []
    for speed in shot_speeds(shot):
        if pd.isna(name):
            scene = common
        elif name in measured.index:
            row = measured.loc[name].copy()
            row["speed"] = speed
            scene = measured_scene(row)
        else:
            scene = as_scene(name)
        aimed = {"projectile.velocity": [0.0, 0.0, -speed], "scene.fidelity": level}
        scenes.append(scene.with_values({**aimed, **values, **_overrides_of(shot)}))
    return scenes


def _overrides_of(shot: pd.Series[Any]) -> dict[str, Value]:
    """Return the keys and values of the column ``set``."""
    entries = "" if pd.isna(shot["set"]) else str(shot["set"])
    try:
        return dict(parse_override(entry) for entry in entries.split(";") if entry.strip())
    except GelfmuError as error:
        raise GelfmuError(f"{shot['name']}: {error}", key=error.key, remedy=error.remedy) from error


def _read_file(place: str) -> tuple[pd.DataFrame, list[str]]:
    """Return the table of a file, and the line of each row."""
    source: Any = resources.files(__package__).joinpath("data", f"{place}.csv") if place in _TABLES else Path(place)
    try:
        refuse_irregular(source)
        lines = source.read_text(encoding="utf-8").splitlines()
        kept = [(number, line) for number, line in enumerate(lines, 1) if line.strip() and not line.startswith("#")]
        text = "\n".join(line for _, line in kept)
        table = pd.read_csv(
            io.StringIO(text), dtype=dict.fromkeys(_TEXTS, str), sep=";" if _has_semicolons(kept) else ","
        )
    except (OSError, ValueError) as error:
        remedy = f"a CSV file, or one of {', '.join(_TABLES)}"
        raise GelfmuError(f"shots {place}: found {error}, expected {remedy}", key="shots", remedy=remedy) from error
    return table, [f"line {number}" for number, _ in kept[1 : len(table) + 1]]


def _has_semicolons(lines: list[tuple[int, str]]) -> bool:
    return bool(lines) and ";" in lines[0][1]


def _refuse_shot(place: str, shot: pd.Series[Any]) -> None:
    """Refuse a shot without sense."""

    def refuse(column: str, expected: str) -> None:
        found = "nothing" if pd.isna(shot[column]) else repr(shot[column])
        message = f"{place}: {column}: found {found}, expected {expected}"
        raise GelfmuError(message, key=column, remedy=f"expected {expected}")

    if pd.isna(shot["name"]) or not shot["name"].strip():
        refuse("name", "a name")
    if shot["measure"] not in _MEASURES:
        refuse("measure", "depth, slope or cavity")
    for column, least in (("value", -math.inf), ("band", 0.0), ("limit", 0.0)):
        if not least < pd.to_numeric(shot[column], errors="coerce") < math.inf:
            refuse(column, "a number" if column == "value" else "a number above 0")
    if not 0.0 <= pd.to_numeric(shot["window"], errors="coerce") < math.inf:
        refuse("window", "0 or a positive number")
    speeds = shot_speeds(shot)
    if len(speeds) != (2 if shot["measure"] == "slope" else 1) or not all(0.0 < speed < math.inf for speed in speeds):
        refuse("speed", "a speed above 0, m/s; of a slope two, the lower first, such as 165/195")
    if len(speeds) == 2 and not speeds[0] < speeds[1]:
        refuse("speed", "two speeds of a slope, the lower first")
