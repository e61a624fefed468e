"""Values of scene keys as TOML text."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

# Number, text, switch, list or table, also of numpy.
Value = Any


def toml_text(value: Value) -> str:
    """Return a value as TOML.

    Parameters
    ----------
    value : bool, int, float, str, sequence, mapping, or a scalar or array of numpy
        Floats keep all their digits.

    Raises
    ------
    TypeError
        For a value that TOML cannot hold, such as None.
    """
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (int, float)):
        return repr(value)
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{json.dumps(key)} = {toml_text(part)}" for key, part in value.items()) + "}"
    if isinstance(value, Sequence):
        return "[" + ", ".join(toml_text(part) for part in value) + "]"
    raise TypeError(f"{value!r}: found {type(value).__name__}, expected a number, a text, a switch, a list or a table")
