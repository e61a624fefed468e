"""Studies: sweeps that a TOML file describes, and scripts that run them on a cluster."""

from __future__ import annotations

import inspect
import shlex
import sys
import tomllib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import pandas as pd

from .errors import GelfmuError, unknown_name
from .samplers import Distribution, Grid, LatinHypercube, LogNormal, Normal, Sampler, Sobol, Uniform, sample_table
from .scene import Scene, as_scene
from .sweeping import sweep

_TABLES = ("scene", "shot", "set", "fidelity", "out", "runs", "workers", "keep", "sampler", "keys")
_DISTRIBUTIONS: dict[str, Callable[..., Distribution]] = {"uniform": Uniform, "normal": Normal, "lognormal": LogNormal}
_SAMPLERS: dict[str, Callable[..., Sampler]] = {"grid": Grid, "latin-hypercube": LatinHypercube, "sobol": Sobol}

_Made = TypeVar("_Made")


@dataclass(frozen=True)
class Study:
    """A sweep that a TOML file describes.

    Attributes
    ----------
    path : Path
        The file; paths in it are relative to its folder.
    content : dict
        Its tables.

    Examples
    --------
    A study of 64 shots::

        scene = "fbi-bb"            # or a scene file, or a table [shot] with the arguments of Scene.new_shot
        fidelity = "draft"
        out = "bb-spread"

        [sampler]
        kind = "sobol"              # grid, latin-hypercube or sobol; or file = "samples.csv"
        count = 64
        seed = 1

        [keys]
        "projectile.velocity[3]" = { normal = { mean = -179.8, deviation = 2.0 } }
        "gel.strength_scale" = { lognormal = { median = 1.0, deviation = 0.1 } }
    """

    path: Path
    content: dict[str, Any]

    @classmethod
    def load(cls, path: str | Path) -> Study:
        """Read a study.

        Raises
        ------
        GelfmuError
            For a file that is no TOML, or has an unknown table.
        """
        path = Path(path).resolve()
        try:
            content = tomllib.loads(path.read_text(encoding="utf-8"))
        except (OSError, tomllib.TOMLDecodeError) as error:
            raise GelfmuError(f"study {path}: {error}", remedy="name a TOML file that describes a sweep") from error
        for name in content:
            if name not in _TABLES:
                raise unknown_name(name, _TABLES, "key of a study")
        return cls(path, content)

    @property
    def folder(self) -> Path:
        """Folder for the results."""
        return self.path.parent / str(self.content.get("out", self.path.stem))

    def scene(self) -> Scene:
        """Return the scene, with the values that are the same in all rows."""
        if "shot" in self.content:
            _refuse_beside("shot", ["scene"] if "scene" in self.content else [])
            scene = _made(Scene.new_shot, self.content["shot"], "shot")
        else:
            name = str(self.content.get("scene", "fbi-bb"))
            scene = as_scene(self.path.parent / name if name.endswith(".toml") else name)
        return scene.with_values(self.content.get("set", {}))

    def samples(self) -> pd.DataFrame:
        """Return one row for each shot."""
        sampler, keys = dict(self.content.get("sampler", {})), self.content.get("keys", {})
        if "file" in sampler:
            others = [*(f"sampler.{name}" for name in sampler if name != "file"), *(["keys"] if keys else [])]
            _refuse_beside("sampler.file", others)
            return _table_in(self.path.parent / sampler["file"])
        kind = sampler.pop("kind", "grid")
        if kind not in _SAMPLERS:
            raise unknown_name(kind, _SAMPLERS, "sampler")
        if kind == "grid":
            _refuse_beside("a grid", [f"sampler.{name}" for name in sampler])
            made: Sampler = Grid(keys)
        else:
            spreads = {key: _distribution_of(key, spread) for key, spread in keys.items()}
            made = _made(_SAMPLERS[kind], {"spreads": spreads, **sampler}, "sampler")
        if not keys:
            remedy = "a table [keys] with keys and their values"
            raise GelfmuError(f"keys: found none, expected {remedy}", key="keys", remedy=remedy)
        return sample_table(made)

    def run(self, share: str | None = None, workers: int | None = None) -> pd.DataFrame:
        """Run the study, or a share of it such as ``"2/8"``, on this machine; see `sweep`."""
        settings = {name: self.content[name] for name in ("runs", "fidelity", "keep") if name in self.content}
        workers = workers or self.content.get("workers")
        return sweep(self.scene(), self.samples(), self.folder, share=share, workers=workers, **settings)

    def slurm_script(self, tasks: int, time: str, cores: int) -> str:
        """Return a script for SLURM: an array of tasks, each of which runs a share of the rows.

        Parameters
        ----------
        tasks : int
            Number of tasks of the array, at most one for each row.
        time : str
            Time limit of each, such as ``"02:00:00"``; what is not finished then is left to the next submission.
        cores : int
            Cores of each task.
        """
        tasks = min(tasks, len(self.samples()))
        python, study = shlex.quote(sys.executable), shlex.quote(str(self.path))
        return f"""#!/bin/bash
#SBATCH --job-name={shlex.quote(self.path.stem)}
#SBATCH --array=1-{tasks}
#SBATCH --ntasks=1
#SBATCH --cpus-per-task={cores}
#SBATCH --time={time}
# Submit it again to go on after a time limit. To write the tables once all tasks are done:
#   {python} -m ballistic_gel sweep {study}
exec {python} -m ballistic_gel sweep {study} --share "$SLURM_ARRAY_TASK_ID/{tasks}" --workers {cores}
"""


def _table_in(path: Path) -> pd.DataFrame:
    try:
        return pd.read_csv(path)
    except (OSError, ValueError) as error:
        key, remedy = "sampler.file", "a CSV file with a column for each key"
        raise GelfmuError(f"{key}: found {error}, expected {remedy}", key=key, remedy=remedy) from error


def _refuse_beside(what: str, others: Sequence[str]) -> None:
    """Refuse keys that say nothing beside another one."""
    if others:
        remedy = f"remove {' and '.join(others)}, or {what}"
        raise GelfmuError(f"{others[0]}: found it beside {what}: {remedy}", key=others[0], remedy=remedy)


def _distribution_of(key: str, spread: Mapping[str, Any]) -> Distribution:
    """Return the distribution of ``{ normal = { mean = 1.0, deviation = 0.1 } }``."""
    remedy = f"one of {', '.join(_DISTRIBUTIONS)} with its figures, such as {{ uniform = {{ low = 1, high = 2 }} }}"
    if not isinstance(spread, Mapping) or len(spread) != 1:
        raise GelfmuError(f"{key}: found {spread!r}, expected {remedy}", key=key, remedy=remedy)
    [(kind, figures)] = spread.items()
    if kind not in _DISTRIBUTIONS:
        raise unknown_name(kind, _DISTRIBUTIONS, "distribution")
    return _made(_DISTRIBUTIONS[kind], figures, f"{kind} of {key}")


def _made(maker: Callable[..., _Made], arguments: Mapping[str, Any], place: str) -> _Made:
    """Call a function with the arguments of a table, whose names must be its own."""
    try:
        inspect.signature(maker).bind(**arguments)
    except TypeError as error:
        remedy = f"give {', '.join(inspect.signature(maker).parameters)}"
        raise GelfmuError(f"{place}: {error}: {remedy}", key=place, remedy=remedy) from None
    return maker(**arguments)
