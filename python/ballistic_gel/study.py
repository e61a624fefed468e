"""Studies: sweeps that a TOML file describes, and scripts that run them on a cluster."""

from __future__ import annotations

import inspect
import re
import shlex
import sys
import tomllib
import unicodedata
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import pandas as pd

from .commands import figures
from .errors import GelfmuError, unknown_name
from .samplers import (
    Distribution,
    Grid,
    LatinHypercube,
    LogNormal,
    Normal,
    Sampler,
    Sobol,
    Uniform,
    is_count,
    sample_table,
)
from .scene import Scene, as_scene
from .study_table import ShownColumn, ShownTable
from .sweeping import run_scenes, sweep
from .tasks import CLOCK

# Keys of a study and of its sampler, with their types.
_TABLES = {
    "title": str,
    "scene": str,
    "shot": dict,
    "set": dict,
    "fidelity": (str, int),
    "out": str,
    "runs": str,
    "workers": int,
    "keep": bool,
    "sampler": dict,
    "keys": dict,
    "case": list,
    "columns": dict,
}
# Columns of a table of cartridges.
_LABELS = ("projectile", "speed", "yaw", "roll", "block", "gel")
_CASE = {"name": str, "scene": str, "shot": dict, "set": dict}
_SAMPLER = {"kind": str, "file": str, "count": int, "seed": int}
_KINDS = {
    list: "a list of tables",
    str: "a text",
    int: "a whole number",
    bool: "true or false",
    dict: "a table",
    (str, int): "a level",
}
_DISTRIBUTIONS: dict[str, Callable[..., Distribution]] = {"uniform": Uniform, "normal": Normal, "lognormal": LogNormal}
_SAMPLERS: dict[str, Callable[..., Sampler]] = {"grid": Grid, "latin-hypercube": LatinHypercube, "sobol": Sobol}

# Time limit of a task: minutes, with seconds, hours, or days before a hyphen; or none.
_TIME = re.compile(r"(\d+-)?\d+(:\d+){0,2}|UNLIMITED", re.ASCII)

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

        scene = "fbi-bb"            # or a scene file, or a table [shot] with the arguments of Scene.new_shot; none of
                                    # them for cartridges: keys projectile, speed, yaw, roll, block and gel
        fidelity = "draft"
        out = "bb-spread"

        [sampler]
        kind = "sobol"              # grid, latin-hypercube or sobol; or file = "samples.csv"
        count = 64
        seed = 1

        [keys]
        "projectile.velocity[3]" = { normal = { mean = -179.8, deviation = 2.0 } }
        "gel.strength_scale" = { lognormal = { median = 1.0, deviation = 0.1 } }

    Shots that differ in several keys at once are cases, each run with all combinations of the keys, if there are any;
    columns make the table that `table_of` and ``python -m ballistic_gel sweep`` show::

        [[case]]
        name = "fixed mesh"
        set = { "remesh.quality" = 0.0 }

        [[case]]
        name = "in space"
        scene = "fbi-bb-3d"         # or a table shot, instead of that of the study

        [columns]
        mesh = "case"
        "depth, mm" = { value = "peak_depth", unit = "mm", format = ".2f", expect = [80, 90] }
        "remesh, %" = { value = "energy.remesh", plus = "energy.remesh_returned", per = "energy.initial", unit = "%" }

    Raises
    ------
    GelfmuError
        For an unknown key, a value of another type, and a control character in any text or in the path.
    """

    path: Path
    content: dict[str, Any]

    def __post_init__(self) -> None:
        _refuse_control("study", str(self.path))
        _refuse_values("", self.content)
        for name in self.content:
            if name not in _TABLES:
                raise unknown_name(name, _TABLES, "key of a study")
        _refuse_types("", self.content, _TABLES)
        _refuse_types("sampler.", self.content.get("sampler", {}), _SAMPLER)
        for place, case in enumerate(self.content.get("case", []), start=1):
            _refuse_case(place, case)
        if "case" in self.content:
            others = ("sampler", "runs", "keep", "fidelity")
            _refuse_beside("case", [name for name in others if name in self.content])
        self._columns()

    @classmethod
    def load(cls, path: str | Path) -> Study:
        """Read a study.

        Raises
        ------
        GelfmuError
            For a file that is no TOML in UTF-8, or describes no sweep.
        """
        path = Path(path).resolve()
        try:
            content = tomllib.loads(path.read_text(encoding="utf-8"))
        except (OSError, ValueError) as error:
            raise GelfmuError(f"study {path}: {error}", remedy="name a TOML file that describes a sweep") from error
        return cls(path, content)

    @property
    def folder(self) -> Path:
        """Folder for the results."""
        return self.path.parent / str(self.content.get("out", self.path.stem))

    def scene(self) -> Scene:
        """Return the scene, with the values that are the same in all rows."""
        return self._scene_of(self.content).with_values(self.content.get("set", {}))

    def _scene_of(self, table: Mapping[str, Any]) -> Scene:
        """Return the shot or the scene of the study or of a case: a built-in one, or one in a file beside the study."""
        if "shot" in table:
            _refuse_beside("shot", ["scene"] if "scene" in table else [])
            return _made(Scene.new_shot, table["shot"], "shot")
        name = str(table.get("scene", "fbi-bb"))
        return as_scene(self.path.parent / name if name.endswith(".toml") else name)

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

    def table_of(self, rows: pd.DataFrame) -> ShownTable | None:
        """Return the table that ``[columns]`` make of the rows of `run`; None without columns."""
        columns = self._columns()
        return ShownTable(columns, rows) if columns else None

    def count(self) -> int:
        """Return the number of rows.

        Raises
        ------
        GelfmuError
            For a study without rows.
        """
        count = len(self._case_scenes()[0] if "case" in self.content else self.samples())
        if not count:
            remedy = "a case, or keys with their values"
            raise GelfmuError(f"study {self.path}: found no rows, expected {remedy}", remedy=remedy)
        return count

    def _columns(self) -> list[ShownColumn]:
        return [ShownColumn.read(head, entry) for head, entry in self.content.get("columns", {}).items()]

    def _refuse_columns(self) -> None:
        """Refuse a column of what no row will have, before anything is run."""
        known = {"status", "reason", *self.content.get("keys", {}), *_LABELS}
        clock = set() if "case" in self.content else set(CLOCK)
        known |= (set(figures().index) - clock) | ({"case"} if "case" in self.content else set())
        for column in self._columns():
            for name in (column.value, column.plus, column.per):
                if name is not None and name not in known and re.sub(r"\[\d+\]", "", name) not in known:
                    raise unknown_name(name, known, f"value of the column {column.head}")

    def run(self, share: str | None = None, workers: int | None = None) -> pd.DataFrame:
        """Run the study, or a share of it such as ``"2/8"``, on this machine.

        Returns
        -------
        DataFrame
            Rows as of `sweep`; those of cases with the column ``case``, their keys, and the figures of the clock.
        """
        workers = self.content.get("workers") if workers is None else workers
        self._refuse_columns()
        if "case" in self.content:
            scenes, labels = self._case_scenes()
            return run_scenes(scenes, self.folder, labels=labels, clock=True, share=share, workers=workers)
        settings = {name: self.content[name] for name in ("runs", "fidelity", "keep") if name in self.content}
        scene, samples = None, self.samples()
        if "projectile" in samples:
            _refuse_beside("cartridges", [name for name in ("scene", "shot") if name in self.content])
            same = {key: [value] * len(samples) for key, value in self.content.get("set", {}).items()}
            # A value of a row wins over that of all, as it does beside a scene.
            samples = pd.DataFrame({**same, **{name: samples[name] for name in samples}})
        else:
            scene = self.scene()
        return sweep(scene, samples, self.folder, share=share, workers=workers, **settings)

    def _case_scenes(self) -> tuple[list[Scene], pd.DataFrame]:
        """Return the scene of each case with each combination of the keys, and the labels of their rows."""
        common, keys = self.content.get("set", {}), self.content.get("keys", {})
        grid = sample_table(Grid(keys)).to_dict("records") if keys else [{}]
        scenes, labels = [], []
        for case in self.content["case"]:
            own = {name: case[name] for name in ("scene", "shot") if name in case} or self.content
            scene = self._scene_of(own).with_values(common)
            for values in grid:
                scenes.append(scene.with_values({**case.get("set", {}), **values}))
                labels.append({"case": case["name"], **values})
        return scenes, pd.DataFrame(labels)

    def slurm_script(self, tasks: int, time: str, cores: int) -> str:
        """Return a script for SLURM: an array of tasks, each of which runs a share of the rows.

        Parameters
        ----------
        tasks : int
            Number of tasks of the array, at most one for each row.
        time : str
            Time limit of each in a form of SLURM, such as ``"02:00:00"``, ``"1-12"`` or ``"UNLIMITED"``; what is not
            finished then is left to the next submission.
        cores : int
            Cores of each task.

        Raises
        ------
        GelfmuError
            For a number below 1, another form of the time, or a study without rows.
        """
        for name, number in (("tasks", tasks), ("cores", cores)):
            if not is_count(number, 1):
                remedy = "a whole number, 1 or more"
                raise GelfmuError(f"{name}: found {number!r}, expected {remedy}", key=name, remedy=remedy)
        if not isinstance(time, str) or not _TIME.fullmatch(time):
            remedy = "a time limit of SLURM, such as 02:00:00 or 1-12"
            raise GelfmuError(f"time: found {time!r}, expected {remedy}", key="time", remedy=remedy)
        _refuse_control("path of Python", sys.executable)
        tasks = min(tasks, self.count())
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


def _refuse_control(place: str, text: str) -> None:
    """Refuse control characters, such as a line feed, behind which a script or a table would go on otherwise."""
    if any(unicodedata.category(sign) == "Cc" for sign in text):
        remedy = "a text without line feeds, tabs and other control characters"
        raise GelfmuError(f"{place}: found {text!r}, expected {remedy}", remedy=f"expected {remedy}")


def _refuse_values(place: str, value: Any) -> None:
    """Refuse control characters in keys and texts, and values that no scene has, such as a date."""
    if isinstance(value, str):
        _refuse_control(place, value)
    elif isinstance(value, Mapping):
        for name, part in value.items():
            _refuse_control(f"key of {place or 'the study'}", name)
            _refuse_values(f"{place}.{name}" if place else name, part)
    elif isinstance(value, list):
        for part in value:
            _refuse_values(place, part)
    elif not isinstance(value, (int, float)):
        remedy = "a number, a text, true, false, a list or a table"
        raise GelfmuError(f"{place}: found {value}, expected {remedy}", key=place, remedy=remedy)


def _refuse_types(prefix: str, table: Mapping[str, Any], types: Mapping[str, Any]) -> None:
    """Refuse values of another type than their key has."""
    for name, kind in types.items():
        value = table.get(name)
        is_other = isinstance(value, bool) != (kind is bool) or not isinstance(value, kind)
        if name in table and is_other:
            key, remedy = f"{prefix}{name}", _KINDS[kind]
            raise GelfmuError(f"{key}: found {value!r}, expected {remedy}", key=key, remedy=remedy)


def _refuse_case(place: int, case: Any) -> None:
    """Refuse a case without a name, or with a key that no case has."""
    if not isinstance(case, Mapping) or "name" not in case:
        remedy = 'a table with a name, such as { name = "fixed", set = { "remesh.quality" = 0.0 } }'
        raise GelfmuError(f"case {place}: found {case!r}, expected {remedy}", key="case", remedy=remedy)
    for name in case:
        if name not in _CASE:
            raise unknown_name(name, _CASE, "key of a case")
    _refuse_types("case.", case, _CASE)


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
    try:
        return maker(**arguments)
    except GelfmuError as error:
        raise GelfmuError(f"{place}: {error}", key=error.key, remedy=error.remedy) from error
