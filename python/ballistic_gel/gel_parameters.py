"""Parameters of a two-network gel: where they stand in a scene, and their bounds."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable, Mapping
from typing import Any

from .errors import GelfmuError
from .values import Value, toml_text

GelTable = dict[str, Any]


def _power_law(gel: GelTable) -> GelTable | None:
    """Return the first power law of the branches."""
    laws = (branch.get("power_law") for branch in gel.get("branches", []))
    return next((law for law in laws if law), None)


def _first_branch(gel: GelTable) -> GelTable | None:
    return next(iter(gel.get("branches", [])), None)


# Table that has each parameter, and its key there.
PARAMETERS: dict[str, tuple[Callable[[GelTable], GelTable | None], str]] = {
    "stress": (_power_law, "stress"),
    "rate": (_power_law, "rate"),
    "exponent": (_power_law, "exponent"),
    "shear_modulus": (lambda gel: gel, "shear_modulus"),
    "branches.shear_modulus": (_first_branch, "shear_modulus"),
    "critical_stretch": (lambda gel: gel.get("damage"), "critical_stretch"),
    "delay": (lambda gel: gel.get("damage"), "delay"),
}


def read_parameter(gel: GelTable, name: str) -> float | None:
    """Return the value of a parameter in a gel, SI units; None if the gel does not have it."""
    owner, key = PARAMETERS[name]
    value = (owner(gel) or {}).get(key)
    return float(value) if value else None


def parameter_bounds(gel: GelTable, name: str) -> tuple[float, float]:
    """Return the least and the greatest value of a parameter that a scene may have."""
    if name == "exponent":
        return 0.0, 10.0 if read_parameter(gel, "rate") else 1.0
    return (1.0, math.inf) if name == "critical_stretch" else (0.0, math.inf)


def refuse_missing(gel: GelTable, name: str, shot: str) -> None:
    """Refuse a gel without a parameter."""
    if read_parameter(gel, name) is None:
        remedy = "a gel that has it, such as the preset gelatin-10"
        raise GelfmuError(f"{name}: found none in the scene of {shot}, expected {remedy}", key=name, remedy=remedy)


def gel_overrides(gel: GelTable, values: Mapping[str, float]) -> dict[str, Value]:
    """Return the keys of a scene that give its gel other values."""
    changed = copy.deepcopy(gel)
    for name, value in values.items():
        owner, key = PARAMETERS[name]
        (owner(changed) or {})[key] = value
    keys = ("shear_modulus", "branches", "damage")
    return {f"gel.{key}": _without_null(changed[key]) for key in keys if changed.get(key) is not None}


def gel_lines(gel: GelTable, values: Mapping[str, float]) -> str:
    """Return the lines of a scene with the networks of a gel with other values, in TOML."""
    overrides = gel_overrides(gel, values)
    return "\n".join(
        ["[gel]", *(f"{key.removeprefix('gel.')} = {toml_text(value)}" for key, value in overrides.items())]
    )


def _without_null(value: Any) -> Any:
    """Return a value without the keys that are null."""
    if isinstance(value, dict):
        return {key: _without_null(part) for key, part in value.items() if part is not None}
    return [_without_null(part) for part in value] if isinstance(value, list) else value
