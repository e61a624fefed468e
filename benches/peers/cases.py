"""What is run, and what counts as the same depth error."""

from dataclasses import dataclass, field
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
SCENE = ROOT / "scenes/sphere-block.toml"

# Depth without any penalty on ever finer meshes, mm: the two extrapolations of docs/studies.md.
CONVERGED = (14.52, 14.58)
# Depth of every peer on its 24 000 tetrahedra with its soft penalty, mm. Mesh (−1.0) and penalty (+0.5) pull apart.
PEERS = 14.054
# Fixed steps of the peers, s: the one on which six codes agreed, and the longest at which they are stable on this mesh.
# 6.25e-5 makes the depth 0.011 mm less; 6.45e-5 and more end with numbers that are none, or with a ball that sinks on.
AGREED_STEP, LONGEST_STEP = 1e-5, 6.25e-5
# Communication steps of ours, s: that of the scene, and one that an importer without need of more would take.
SCENE_STEP, LONG_STEP = 1e-5, 1e-4


@dataclass
class Case:
    """A row of the table: a peer with a fixed step, or ours with a communication step and changes of the scene."""

    name: str
    script: str
    environment: str
    step: float
    changes: dict[str, object] = field(default_factory=dict)

    @property
    def is_ours(self):
        return self.script == "ours.py"


def graded(size, core, growth):
    """Changes of the scene that make cells of `size` in the core, and longer ones away from it."""
    grading = {"core": core, "growth": growth, "largest": 0.025}
    return {"mesh.size": size} | {f"mesh.grading.{key}": value for key, value in grading.items()}


# The peers' own mesh; the coarsest of a family of graded meshes from which on each finer one is within the peers' depth
# error; the coarsest with less than the error that the peers' mesh has without its penalty (README.md).
SAME_MESH = {"mesh.lattice": "kuhn"}
SAME_ERROR = graded(5e-3, core=0.025, growth=2)
SAME_MESH_ERROR = graded(10e-3, core=0.020, growth=2)


def peers():
    """Every peer with both steps."""
    for name in ["Taichi", "DOLFINx", "felupe", "Kratos"]:
        for step in [AGREED_STEP, LONGEST_STEP]:
            yield Case(name, f"{name.lower()}_block.py", name.lower(), step)


def ours():
    """The meshes of README.md with both communication steps."""
    for name, changes in [("same mesh", SAME_MESH), ("same error", SAME_ERROR), ("same mesh error", SAME_MESH_ERROR)]:
        for step in [SCENE_STEP, LONG_STEP]:
            yield Case(f"ours, {name}", "ours.py", "ours", step, changes)


def every():
    """All rows in the order of the table."""
    return [*peers(), *ours()]


def error(depth):
    """Depth error, mm: what is missing to the nearer end of the converged values, or beyond the farther one."""
    low, high = CONVERGED
    return depth - min(max(depth, low), high)


def within_peers_error(depth):
    """Whether a depth, mm, is no further than the peers' from either end of the converged values."""
    return all(abs(depth - true) <= abs(PEERS - true) for true in CONVERGED)
