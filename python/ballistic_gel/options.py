"""Options that a scene leaves out, switched off and switched on."""

from __future__ import annotations

from typing import Any

from .knobs import Rung

_STIFF = [{"shear_modulus": 1.0, "power_law": {"stress": 1e9, "exponent": 1.0}}]
_VISCOUS = {"gel.material": "two-network", "gel.branches": [{"shear_modulus": 1.0, "time": 1e-2}]}


def option_rungs(values: dict[str, Any]) -> list[Rung]:
    """Return two runs for each option that a scene leaves out: off, if a value says so, and on.

    Parameters
    ----------
    values : dict
        Scene with its defaults.
    """
    made = []
    for name, off, on in _unused_options(values):
        made += [Rung(name, -1.0, off)] if off else []
        made.append(Rung(name, 1.0, on))
    return made


def _unused_options(scene: dict[str, Any]) -> list[tuple[str, dict[str, Any], dict[str, Any]]]:
    """Return name, values that turn it off, and values that turn it on, of each option that is not used."""
    found: list[tuple[str, dict[str, Any], dict[str, Any]]] = []
    for key, name, on in (
        ("contact.friction", "friction", 0.3),
        ("contact.restitution", "restitution", 0.5),
        ("integrator.damping", "damping", 1.0),
    ):
        table, own = key.split(".")
        if not scene[table].get(own):
            found.append((name, {key: 0.0}, {key: on}))
    if not scene.get("load"):
        found.append(("pressure on a face", {"load": []}, {"load": [{"on": "z_max", "pressure": 1.0}]}))
    ball = scene["projectile"]["shape"].get("sphere")
    if not scene.get("fragment") and ball:
        far = {"shape": {"sphere": ball}, "mass": 1.0, "position": [0.0, 0.0, 100.0 * ball["radius"]]}
        found.append(("a fragment out of reach", {"fragment": []}, {"fragment": [far]}))
    found.append(("patches of elements", {"mesh.element": "plain"}, {"mesh.element": "patch"}))
    if not scene.get("remesh"):
        never = {"remesh.quality": 0.0, "remesh.min_volume_ratio": 0.0}
        found.append(("a mesh that may be remade", {}, never))
    if scene["gel"]["material"] == "neo-hookean":
        stiff = {"gel.material": "two-network", "gel.branches": _STIFF}
        found.append(("a viscous branch", {}, _VISCOUS))
        found.append(("a stiff branch", {}, stiff))
        found.append(("bulk viscosity, and that branch", {}, {**stiff, "gel.viscosity": {"linear": 0.1}}))
    return found
