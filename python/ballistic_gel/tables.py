"""Tables and numbers as text, and the files of tables."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any


def markdown(rows: Iterable[Mapping[str, str]]) -> str:
    """Return rows of texts as a table in Markdown, its head that of the first row; nothing for no rows."""
    rows = list(rows)
    if not rows:
        return ""
    head = list(rows[0])
    lines = [head, ["---"] * len(head), *([row.get(name, "") for name in head] for row in rows)]
    return "".join("| " + " | ".join(cell.replace("|", r"\|") for cell in cells) + " |\n" for cells in lines)


def digits(value: float, count: int = 3) -> str:
    """Return a number with some significant digits, without an exponent; a dash for one that is missing."""
    if math.isnan(value):
        return "-"
    before = 1 if value == 0.0 else math.floor(math.log10(abs(value))) + 1
    return f"{value:.{min(max(count - before, 0), count + 2)}f}"


def refuse_irregular(file: Any) -> None:
    """Raise an OSError for what is no regular file, such as a device without an end.

    Parameters
    ----------
    file : Path or Traversable
        File that is to be read.
    """
    if not file.is_file():
        raise OSError("no readable regular file")
