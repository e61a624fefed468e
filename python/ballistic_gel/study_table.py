"""Table that a study shows: its columns, made of the figures of its rows."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import pandas as pd

from .errors import GelfmuError, unknown_name
from .tables import markdown

# Units of a column, and what one of SI is in them.
_UNITS = {
    "mm": 1e3,
    "µm": 1e6,
    "ms": 1e3,
    "µs": 1e6,
    "g": 1e3,
    "mJ": 1e3,
    "kPa": 1e-3,
    "MPa": 1e-6,
    "million": 1e-6,
    "%": 1e2,
}
_KEYS = {"value": str, "plus": str, "per": str, "unit": str, "format": str, "expect": list}


@dataclass(frozen=True)
class ShownColumn:
    """A column of the table.

    Attributes
    ----------
    head : str
        Head of the column.
    value : str
        Column of the rows: a key of the study, ``case``, ``status`` or a figure of the summary.
    plus : str or None
        Figure that is added to the value, such as ``energy.remesh_returned`` to ``energy.remesh``.
    per : str or None
        Figure by which the value is divided, such as ``energy.initial``.
    unit : str or None
        Unit of what is shown; SI if absent.
    format : str
        Format of a number in Python, such as ``.2f``.
    expect : tuple of two floats, or None
        Least and greatest value that is expected, in the unit; a missing value is not.
    """

    head: str
    value: str
    plus: str | None = None
    per: str | None = None
    unit: str | None = None
    format: str = ".4g"
    expect: tuple[float, float] | None = None

    @classmethod
    def read(cls, head: str, entry: Any) -> ShownColumn:
        """Return the column of an entry in ``[columns]``: the name of a value, or a table.

        Raises
        ------
        GelfmuError
            For an unknown key or unit, or a value of another type.
        """
        entry = {"value": entry} if isinstance(entry, str) else entry
        for name in entry if isinstance(entry, Mapping) else []:
            if name not in _KEYS:
                raise unknown_name(name, _KEYS, "key of a column")
        if (
            not isinstance(entry, Mapping)
            or "value" not in entry
            or not all(isinstance(entry[name], kind) for name, kind in _KEYS.items() if name in entry)
            or not _is_format(entry.get("format", ""))
            or not _is_range(entry.get("expect", [0.0, 0.0]))
        ):
            remedy = (
                'the name of a value, or a table such as { value = "peak_depth", unit = "mm", format = ".2f", '
                'plus = "…", per = "…", expect = [least, greatest] }'
            )
            raise GelfmuError(f"columns.{head}: found {entry!r}, expected {remedy}", key=head, remedy=remedy)
        if "unit" in entry and entry["unit"] not in _UNITS:
            raise unknown_name(entry["unit"], _UNITS, "unit of a column")
        given = dict(entry)
        if "expect" in given:
            given["expect"] = tuple(map(float, given["expect"]))
        return cls(head, **given)

    def values_of(self, rows: pd.DataFrame) -> pd.Series[Any]:
        """Return the values of the column, in its unit; missing where a row has none.

        Raises
        ------
        GelfmuError
            For a text in a column with a unit, a summand, a divisor or expected values.
        """
        if self.plus is None and self.per is None and self.unit is None and self.expect is None:
            return rows[self.value] if self.value in rows else pd.Series(math.nan, rows.index)
        values = self._numbers_in(rows, self.value)
        if self.plus is not None:
            values = values + self._numbers_in(rows, self.plus)
        if self.per is not None:
            values = values / self._numbers_in(rows, self.per)
        return values * _UNITS.get(str(self.unit), 1.0)

    def _numbers_in(self, rows: pd.DataFrame, name: str) -> pd.Series[Any]:
        try:
            return pd.Series(rows.get(name, math.nan), rows.index).astype(float)
        except (TypeError, ValueError) as error:
            remedy = "numbers, or a column of the value alone"
            found = f"columns.{self.head}: found {name} ({error}), expected {remedy}"
            raise GelfmuError(found, key=self.head, remedy=remedy) from None

    def is_expected(self, value: Any) -> bool:
        """Return whether a value is within what is expected; a missing one is not."""
        return self.expect is None or bool(self.expect[0] <= value <= self.expect[1])

    def text_of(self, value: Any) -> str:
        """Return a cell: a dash for a missing value, bold for one beyond what is expected."""
        if value is None or value != value:
            shown = "–"
        elif isinstance(value, (int, float)) and not isinstance(value, bool):
            shown = format(value, self.format)
        else:
            shown = str(value)
        return shown if self.is_expected(value) else f"**{shown}**"


class ShownTable:
    """Table of a study.

    Parameters
    ----------
    columns : iterable of ShownColumn
        Columns.
    rows : DataFrame
        Rows of the study with their figures.
    """

    def __init__(self, columns: Iterable[ShownColumn], rows: pd.DataFrame) -> None:
        self._columns = list(columns)
        self.values = pd.DataFrame({column.head: column.values_of(rows) for column in self._columns})

    def to_markdown(self) -> str:
        """Return the table as Markdown."""
        texts = {column.head: list(map(column.text_of, self.values[column.head].tolist())) for column in self._columns}
        return markdown({head: texts[head][place] for head in texts} for place in range(len(self.values)))

    @property
    def unexpected(self) -> int:
        """Number of values beyond what is expected."""
        return sum(not column.is_expected(value) for column in self._columns for value in self.values[column.head])


def _is_format(text: Any) -> bool:
    try:
        format(1.0, text)
    except (TypeError, ValueError):
        return False
    return True


def _is_range(pair: Any) -> bool:
    is_pair = isinstance(pair, list) and len(pair) == 2 and all(type(end) in (int, float) for end in pair)
    return is_pair and -math.inf < pair[0] <= pair[1] < math.inf
