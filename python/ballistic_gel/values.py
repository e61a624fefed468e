"""Values of scene keys as TOML text."""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Mapping, Sequence
from typing import Any

from .errors import GelfmuError

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
        return "{" + ", ".join(f"{_key_text(key)} = {toml_text(part)}" for key, part in value.items()) + "}"
    if isinstance(value, Sequence):
        return "[" + ", ".join(toml_text(part) for part in value) + "]"
    raise TypeError(f"{value!r}: found {type(value).__name__}, expected a number, a text, a switch, a list or a table")


def parse_override(text: str) -> tuple[str, Value]:
    """Return key and value of a text such as ``mesh.size=2e-3``; what is no TOML is a text, such as ``2 mm``.

    Raises
    ------
    GelfmuError
        For a text without an equals sign or a key.
    """
    key, equals, value = map(str.strip, text.partition("="))
    if not equals or not key:
        remedy = "key=value, such as mesh.size=2e-3"
        raise GelfmuError(f"set: found {text!r}, expected {remedy}", key="set", remedy=f"expected {remedy}")
    try:
        return key, tomllib.loads(f"value = {value}")["value"]
    except tomllib.TOMLDecodeError:
        return key, value


def _key_text(key: str) -> str:
    """Return a key as it is, or in quotes if TOML needs them."""
    return key if re.fullmatch(r"[A-Za-z0-9_-]+", key) else json.dumps(key, ensure_ascii=False)
