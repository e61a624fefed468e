"""Cartridges: rows of a sweep that each make a scene of their own, by ``gelfmu new``."""

from __future__ import annotations

import warnings
from typing import Any

import pandas as pd

from .errors import DoubtWarning, GelfmuError, unknown_name
from .scene import Scene, new_shot_values

# Columns of a table of cartridges: the arguments of `Scene.new_shot`. Keys of a scene have a dot.
COLUMNS = ("projectile", "speed", "yaw", "roll", "block", "gel")


def cartridge_scenes(table: pd.DataFrame) -> tuple[list[Scene], pd.DataFrame]:
    """Return the scene of each row, and the columns that are keys of these scenes.

    Raises
    ------
    GelfmuError
        For an unknown column, a table without projectiles, or a row of which ``gelfmu new`` makes no scene.
    """
    for column in map(str, table.columns):
        if column not in COLUMNS and "." not in column:
            raise unknown_name(column, COLUMNS, "column of cartridges")
    if "projectile" not in table:
        remedy = "a scene, or a column projectile with names of the library"
        raise GelfmuError(f"scene: found none, expected {remedy}", key="scene", remedy=remedy)
    given = [column for column in COLUMNS if column in table]
    rows = [dict(zip(given, row, strict=True)) for row in table[given].itertuples(index=False)]
    scenes: dict[str, Scene] = {}
    for number, row in enumerate(rows):
        if repr(row) not in scenes:
            scenes[repr(row)] = _scene_of(number, row)
    return [scenes[repr(row)] for row in rows], table.drop(columns=given)


def _scene_of(number: int, row: dict[str, Any]) -> Scene:
    arguments = {column: value for column, value in row.items() if not _is_empty(value)}
    if "projectile" not in arguments:
        remedy = "a name of the library, such as 9mm-fmj"
        message = f"row {number}: projectile: found nothing, expected {remedy}"
        raise GelfmuError(message, key="projectile", remedy=remedy)
    try:
        made = new_shot_values(**arguments)
    except GelfmuError as error:
        raise GelfmuError(f"row {number}: {error}", key=error.key, remedy=error.remedy) from error
    for doubt in made["doubts"]:
        warnings.warn(f"row {number}: {doubt}", DoubtWarning, stacklevel=5)
    return Scene(made["text"])


def _is_empty(value: Any) -> bool:
    """Return whether a cell has no value: the usual one of the projectile, or of ``gelfmu new``, then holds."""
    return bool(pd.api.types.is_scalar(value) and pd.isna(value))
