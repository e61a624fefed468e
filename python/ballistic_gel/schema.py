"""The keys of a scene, from the schema that `gelfmu` prints."""

from __future__ import annotations

import functools
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from .binary import call_json, find_binary
from .errors import unknown_name

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


def scene_keys() -> tuple[str, ...]:
    """Return all dotted keys of a scene, without the numbers of tables in lists."""
    path = find_binary()
    return _keys_of(path, path.stat().st_mtime_ns)


@functools.lru_cache(maxsize=8)
def _keys_of(_path: Path, _modified: int) -> tuple[str, ...]:
    schema: Schema = call_json(["schema"])
    return tuple(dict.fromkeys(_walk(schema, schema.get("$defs", {}), "")))


def _walk(node: Schema, definitions: Schema, prefix: str) -> Iterator[str]:
    """Yield the keys of a node and of all nodes below it."""
    if "$ref" in node:
        yield from _walk(definitions[node["$ref"].rpartition("/")[2]], definitions, prefix)
    for word in ("anyOf", "oneOf", "allOf"):
        for part in node.get(word, []):
            yield from _walk(part, definitions, prefix)
    if isinstance(node.get("items"), dict):
        yield from _walk(node["items"], definitions, prefix)
    for name, part in node.get("properties", {}).items():
        key = f"{prefix}.{name}" if prefix else name
        yield key
        yield from _walk(part, definitions, key)
