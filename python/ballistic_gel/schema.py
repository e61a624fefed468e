"""The keys of a scene, from the schema that `gelfmu` prints."""

from __future__ import annotations

import functools
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from .binary import call_json, find_binary
from .errors import GelfmuError, unknown_name

# A number and its unit, as `gelfmu` reads them; a text that begins otherwise is a word.
_QUANTITY = re.compile(r"\s*[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?\s*(?P<unit>.*?)\s*", re.ASCII | re.DOTALL)
_BEGINS_LIKE_NUMBER = re.compile(r"\s*[-+.\d]", re.ASCII)
_INDEX = re.compile(r"\[\d+\]")
Schema = dict[str, Any]


def check_key(key: str) -> None:
    """Refuse a key that no scene has.

    Parameters
    ----------
    key : str
        Dotted key, such as ``mesh.size``; tables of a list count from 1, as in ``fragment[1].mass``, and so do
        the components of a vector, as in ``projectile.velocity[3]``.

    Raises
    ------
    GelfmuError
        With the nearest known key in its message.
    """
    known = scene_keys()
    if _INDEX.sub("", key) in known:
        return
    raise unknown_name(key, known, "key")


def check_value(key: str, value: Any) -> None:
    """Refuse a text with a unit that its key does not have, also in lists and tables.

    Raises
    ------
    GelfmuError
        With the unit that is expected, and an example.
    """
    if isinstance(value, Mapping):
        for name, part in value.items():
            check_value(f"{key}.{name}", part)
    elif isinstance(value, (list, tuple)):
        for part in value:
            check_value(key, part)
    elif isinstance(value, str):
        quantity = _scene_schema().get(_INDEX.sub("", key))
        if quantity is not None and not quantity.takes(value):
            found = f"{key}: found {value!r}, expected {quantity.expected}"
            raise GelfmuError(found, key=key, remedy=f"expected {quantity.expected}")


@dataclass(frozen=True)
class Quantity:
    """Physical quantity of a key.

    Attributes
    ----------
    expected : str
        Unit of a number, and an example with another unit.
    units : frozenset of str
        All units of texts.
    takes_words : bool
        True if a text may also be a word, such as ``never``.
    """

    expected: str
    units: frozenset[str]
    takes_words: bool

    def takes(self, text: str) -> bool:
        """Return whether a text is a number with a unit of the quantity, or with none, or a word in its place."""
        if not _BEGINS_LIKE_NUMBER.match(text):
            return self.takes_words
        found = _QUANTITY.fullmatch(text)
        return found is not None and found["unit"] in {"", *self.units}


def scene_keys() -> tuple[str, ...]:
    """Return all dotted keys of a scene, without the numbers of tables in lists."""
    return tuple(_scene_schema())


def _scene_schema() -> dict[str, Quantity | None]:
    """Return the quantity of each dotted key, if it has one."""
    path = find_binary()
    return _quantities_of(path, path.stat().st_mtime_ns)


@functools.lru_cache(maxsize=8)
def _quantities_of(_path: Path, _modified: int) -> dict[str, Quantity | None]:
    schema: Schema = call_json(["schema"])
    kinds = schema.get("x-quantities", {})
    found: dict[str, Quantity | None] = {}
    for key, node in walk_schema(schema, schema.get("$defs", {}), ""):
        kind = kinds.get(node.get("x-quantity"))
        quantity = kind and Quantity(kind["expected"], frozenset(kind["units"]), "type" not in node)
        found[key] = found.get(key) or quantity
    return found


def walk_schema(node: Schema, definitions: Schema, prefix: str) -> Iterator[tuple[str, Schema]]:
    """Yield the keys of a node and of all nodes below it, and the node of each."""
    if "$ref" in node:
        yield from walk_schema(definitions[node["$ref"].rpartition("/")[2]], definitions, prefix)
    for word in ("anyOf", "oneOf", "allOf"):
        for part in node.get(word, []):
            yield from walk_schema(part, definitions, prefix)
    if isinstance(node.get("items"), dict):
        yield from walk_schema(node["items"], definitions, prefix)
    for name, part in node.get("properties", {}).items():
        key = f"{prefix}.{name}" if prefix else name
        yield key, part
        yield from walk_schema(part, definitions, key)
