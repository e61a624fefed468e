"""Knobs of a scene: settings that trade accuracy for speed, each turned towards fine and towards coarse."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from .values import Value, toml_text

# Knob that refines all of the mesh, and that of a remeshed version of a scene whose own mesh cannot follow.
MESH, REMESHED = "mesh", "mesh, remeshed"
# Refinements of the coarsest meshes. The limit of a remeshed family needs meshes of twice and four times the finest
# edges.
_COARSEST, _COARSEST_REMESHED = -2, -4


@dataclass(frozen=True)
class Rung:
    """One run of a ladder.

    Attributes
    ----------
    knob : str
        Knob that is turned; empty for the scene as it is.
    refinement : float
        0 for the scene as it is, positive towards fine.
    values : dict
        Keys and values that are replaced.
    size : float or None
        Size of all cells relative to the scene, in a mesh family with a limit of refinement.
    """

    knob: str = ""
    refinement: float = 0.0
    values: Mapping[str, Value] = field(default_factory=dict)
    size: float | None = None

    @property
    def label(self) -> str:
        """Replaced keys as on the command line."""
        return " ".join(f"{key}={toml_text(value)}" for key, value in self.values.items()) or "as it is"


def ladder(checked: Mapping[str, Any], finer: int = 3, has_failed: bool = False) -> list[Rung]:
    """Return the runs that measure the knobs of a scene, the scene as it is first.

    Parameters
    ----------
    checked : mapping
        Values of `SceneCheck`: the scene with its defaults, and its bodies.
    finer : int
        Number of refinements of all edges by √2 beyond the scene.
    has_failed : bool
        True if the scene as it is stops early: it gets a remeshed family, too.
    """
    values, bodies = checked["values"], checked["bodies"]
    turned = [
        _contact_sizes(values),
        _gradings(values),
        _time_steps(values),
        _schedules(values),
        _elements(values),
        _restitutions(values),
        _bulk_moduli(values),
        _dimensions(values),
        _remeshings(values),
        _communication_steps(values),
    ]
    meshes = _meshes(values, _width_of(bodies[0]), finer, has_failed)
    return [Rung(size=1.0), *meshes, *(rung for rungs in turned for rung in rungs)]


def _meshes(scene: dict[str, Any], width: float | None, finer: int, has_failed: bool) -> Iterator[Rung]:
    """Yield whole meshes finer and coarser by √2, their grading with them."""
    is_remeshed = bool(scene.get("remesh"))
    for refinement in range(_COARSEST_REMESHED if is_remeshed else _COARSEST, finer + 1):
        if refinement:
            yield Rung(MESH, refinement, _scaled(scene, _size_of(refinement)), _size_of(refinement))
    if has_failed and not is_remeshed:
        for refinement in range(_COARSEST_REMESHED, finer + 1):
            size = _size_of(refinement)
            yield Rung(REMESHED, refinement + 0.25, {"remesh.quality": 0.3, **_scaled(scene, size)}, size)
    elif width is not None and _can_be_graded(scene):
        # From 2.5 half widths of the projectile on, cells double up to a size of as much.
        core = _digits(1.25 * width)
        for refinement in range(-2, finer + 1):
            cells = _scaled(scene, _size_of(refinement))
            edge = float(cells.get("mesh.size", scene["mesh"]["size"]))
            grading = {"core": core, "growth": 2.0, "largest": max(core, edge)}
            yield Rung("mesh, graded", refinement - 0.5, {**cells, "mesh.grading": grading})


def _can_be_graded(scene: dict[str, Any]) -> bool:
    shape = scene["gel"]["shape"]
    is_plain = "block" in shape or ("cylinder" in shape and not shape["cylinder"].get("bore"))
    return is_plain and not scene["mesh"].get("grading") and not scene["mesh"].get("tree")


def _width_of(body: dict[str, Any]) -> float | None:
    """Return the least width of a body, m; None for one without an inside, such as a half-space or a dome."""
    if {"half-space", "half_space", "dome"} & set(body["shape"]):
        return None
    extent = body["extent"]
    widths = [high - low for low, high in zip(extent["min"], extent["max"], strict=True) if None not in (low, high)]
    return min((width for width in widths if width > 0.0), default=None)


def _scaled(scene: dict[str, Any], size: float) -> dict[str, Value]:
    """Return the keys that scale every edge of the mesh; the number of cells in a graded zone stays."""
    if size == 1.0:
        return {}
    mesh, remesh = scene["mesh"], scene.get("remesh") or {}
    made: dict[str, Value] = {"mesh.size": _digits(size * mesh["size"])}
    if grading := mesh.get("grading"):
        made["mesh.grading.growth"] = _digits(grading["growth"] ** size)
        made["mesh.grading.largest"] = _digits(size * grading["largest"])
    if tree := mesh.get("tree"):
        made["mesh.tree.slope"] = _digits(size * tree["slope"])
    for key in ("smallest", "tip_size"):
        if remesh.get(key) is not None:
            made[f"remesh.{key}"] = _digits(size * remesh[key])
    if remesh:
        made["remesh.growth"] = _digits(min(size * remesh["growth"], 1.0))
    return made


def _contact_sizes(scene: dict[str, Any]) -> Iterator[Rung]:
    """Yield a finer and a coarser mesh at the projectile only."""
    mesh, remesh = scene["mesh"], scene.get("remesh") or {}
    tree = mesh.get("tree")
    turns: list[tuple[float, float, dict[str, Value]]]
    if mesh.get("grading"):
        turns = [(-1.0, 1.5, {}), (1.0, 0.667, {})]
    elif tree and tree["coarsest"] >= 4:
        turns = [(-1.0, 2.0, {"mesh.tree.coarsest": tree["coarsest"] // 2})]
        turns += [(1.0, 0.5, {"mesh.tree.coarsest": 2 * tree["coarsest"]})]
    else:
        return
    for refinement, factor, further in turns:
        smallest = {"remesh.smallest": _digits(factor * remesh["smallest"])} if remesh.get("smallest") else {}
        yield Rung("contact size", refinement, {"mesh.size": _digits(factor * mesh["size"]), **further, **smallest})


def _gradings(scene: dict[str, Any]) -> Iterator[Rung]:
    """Yield another growth of the cells; the finest ones stay."""
    mesh, remesh = scene["mesh"], scene.get("remesh")
    for refinement, factor in ((-2.0, 2.0), (-1.0, 1.5), (1.0, 0.667)):
        made: dict[str, Value] = {}
        if mesh.get("grading"):
            made["mesh.grading.growth"] = _digits(1.0 + factor * (mesh["grading"]["growth"] - 1.0))
        if mesh.get("tree"):
            made["mesh.tree.slope"] = _digits(factor * mesh["tree"]["slope"])
        if remesh:
            made["remesh.growth"] = _digits(min(factor * remesh["growth"], 1.0))
        if made:
            yield Rung("grading", refinement, made)


def _time_steps(scene: dict[str, Any]) -> Iterator[Rung]:
    """Yield other fractions of the stable step."""
    own = scene["integrator"].get("cfl") or {"queue": 0.4}.get(scene["integrator"]["schedule"], 0.8)
    if own < 1.0:
        yield Rung("cfl", -1.0, {"integrator.cfl": 1.0})
    yield Rung("cfl", 1.0, {"integrator.cfl": _digits(0.5 * own)})
    yield Rung("cfl", 2.0, {"integrator.cfl": _digits(0.25 * own)})


def _schedules(scene: dict[str, Any]) -> Iterator[Rung]:
    """Yield one step for all elements."""
    if scene["integrator"]["schedule"] == "bins":
        yield Rung("schedule", 1.0, {"integrator.schedule": "global"})


def _elements(scene: dict[str, Any]) -> Iterator[Rung]:
    """Yield the other kind of element on three meshes, and the Kuhn lattice where it can be had."""
    mesh = scene["mesh"]
    other, shift = ("patch", 0.125) if mesh["element"] == "plain" else ("plain", -0.125)
    # Three sizes tell an accurate element from one that meets the limit by chance on one mesh.
    for finer in (-1, 0, 1):
        yield Rung("element", finer + shift, {"mesh.element": other, **_scaled(scene, _size_of(finer))})
    is_round = scene["scene"]["dimension"] == "spatial" and "cylinder" in scene["gel"]["shape"]
    if not mesh.get("tree") and mesh["lattice"] == "centred" and not is_round:
        yield Rung("lattice", -1.0, {"mesh.lattice": "kuhn"})


def _restitutions(scene: dict[str, Any]) -> Iterator[Rung]:
    contact = scene["contact"]
    if contact["law"] == "moreau" and contact["restitution"] == 0.0:
        yield Rung("restitution", -2.0, {"contact.restitution": 1.0})
        yield Rung("restitution", -1.0, {"contact.restitution": 0.5})


def _bulk_moduli(scene: dict[str, Any]) -> Iterator[Rung]:
    """Yield other bulk moduli: slower pressure waves allow longer steps."""
    bulk, shear = scene["gel"]["bulk_modulus"], scene["gel"].get("shear_modulus", 0.0)
    for refinement, factor in ((-2.0, 0.25), (-1.0, 0.5), (1.0, 2.0)):
        if factor * bulk > 0.7 * shear:  # Poisson's ratio is positive from K = 2/3 G on
            yield Rung("bulk modulus", refinement, {"gel.bulk_modulus": _digits(factor * bulk)})


def _dimensions(scene: dict[str, Any]) -> Iterator[Rung]:
    """Yield an axisymmetric gel in three dimensions, on cells twice as long that grow by half."""
    shape = scene["gel"]["shape"].get("cylinder")
    if scene["scene"]["dimension"] != "axisymmetric" or scene.get("remesh") or not shape or shape.get("bore"):
        return
    size = _digits(2.0 * scene["mesh"]["size"])
    core = (scene["mesh"].get("grading") or {"core": 10.0 * size})["core"]
    grading = {"core": core, "growth": 1.5, "largest": _digits(shape["radius"] / 6.0)}
    # Single linear tetrahedra lock.
    made = {"scene.dimension": "spatial", "mesh.element": "patch", "mesh.size": size, "mesh.grading": grading}
    yield Rung("dimension", -1.0, made)


def _remeshings(scene: dict[str, Any]) -> Iterator[Rung]:
    """Yield other criteria of remeshing."""
    remesh = scene.get("remesh")
    if not remesh:
        return
    yield Rung("remesh", -1.0, {"remesh.quality": _digits(0.667 * remesh["quality"])})
    yield Rung("remesh", 1.0, {"remesh.quality": _digits(1.333 * remesh["quality"])})
    if remesh["adaptive"] and remesh["curvature_angle"] < 120.0:
        yield Rung("remesh", -2.0, {"remesh.curvature_angle": 180.0})
    if scene["scene"]["dimension"] != "spatial" and remesh["method"] == "local" and not remesh.get("erosion_thickness"):
        yield Rung("remesh", -3.0, {"remesh.method": "immersed"})


def _communication_steps(scene: dict[str, Any]) -> Iterator[Rung]:
    yield Rung("coupling", -1.0, {"scene.communication_step": _digits(10.0 * scene["scene"]["communication_step"])})


def _size_of(refinement: float) -> float:
    return float(2.0 ** (-0.5 * refinement))


def _digits(value: float) -> float:
    """Return a value with four digits."""
    return float(f"{value:.3e}")
