"""A scene: a shot before it is run."""

from __future__ import annotations

import copy
import hashlib
import os
import re
import tempfile
import tomllib
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from .binary import call_json, file_hash
from .errors import DoubtWarning, GelfmuError
from .schema import check_key, check_value
from .values import Value, toml_text

# A component of a vector, unlike a table of a list such as `fragment[1]`, has a dot before it.
_COMPONENT = re.compile(r"(?P<vector>.+\..+)\[(?P<number>[1-9])\]")
_STEP = re.compile(r"[^.\[\]]+|\[[1-9]\d*\]")


@dataclass(frozen=True)
class SceneCheck:
    """Answer of `gelfmu check`: what a scene models, and what it leaves out.

    Attributes
    ----------
    values : dict
        All that ``gelfmu check --json`` prints.
    """

    values: dict[str, Any]

    @property
    def modelled(self) -> list[str]:
        """Physics that the scene models."""
        return list(self.values["modelled"])

    @property
    def switched_off(self) -> list[str]:
        """Physics that the scene leaves out."""
        return list(self.values["switched_off"])

    @property
    def doubts(self) -> list[str]:
        """Reasons to doubt the figures of a run."""
        return list(self.values["doubts"])

    @property
    def elements(self) -> int:
        """Number of elements at the start."""
        return int(self.values["elements"])


class Scene:
    """A scene and the keys that replace its values.

    The replaced keys go to `gelfmu` as they are: it alone knows what they mean.

    Examples
    --------
    >>> scene = Scene.built_in("fbi-bb")
    >>> scene["scene.end_time"] = 2e-3  # s
    >>> scene["projectile.velocity[3]"] = -150.0  # m/s, the component along z

    Attributes
    ----------
    name : str
        Name of the scene, from its text.
    text : str
        TOML text of the scene, without the replaced keys.
    values : dict
        Replaced keys and their values.
    """

    def __init__(self, text: str, source: Path | str | None = None) -> None:
        self.text = text
        self._source = source
        try:
            self._table: dict[str, Any] = tomllib.loads(text)
        except tomllib.TOMLDecodeError as error:
            raise GelfmuError(f"{source or 'scene'}: {error}", remedy="correct the TOML text of the scene") from error
        header = self._table.get("scene")
        self.name = str(header.get("name", "scene") if isinstance(header, dict) else "scene")
        self.values: dict[str, Value] = {}

    @classmethod
    def load(cls, path: str | Path) -> Scene:
        """Read a scene from a TOML file, whose STL files are found beside it."""
        path = Path(path).resolve()
        try:
            return cls(path.read_text(encoding="utf-8"), path)
        except (OSError, UnicodeDecodeError) as error:
            remedy = "name a scene file; Scene.built_in(name) reads a built-in scene"
            raise GelfmuError(f"{path}: {getattr(error, 'strerror', error)}", remedy=remedy) from error

    @classmethod
    def built_in(cls, name: str) -> Scene:
        """Return a scene that `gelfmu` holds; `scenes` lists them."""
        return cls(call_json(["scenes", name])["text"], name)

    @classmethod
    def new_shot(
        cls,
        projectile: str,
        speed: float | str | None = None,
        *,
        yaw: float | None = None,
        roll: float | None = None,
        block: str | Sequence[float] | None = None,
        gel: str | None = None,
    ) -> Scene:
        """Make the scene of a shot with a projectile of the library, by ``gelfmu new``.

        Parameters
        ----------
        projectile : str
            Name in the library, such as ``9mm-fmj``; `projectiles` lists them.
        speed : float or str, optional
            Speed at the gel, m/s, or with a unit, such as ``"1150 ft/s"``.
        yaw, roll : float, optional
            Angle between axis and path, and angle of its plane about the path, degrees.
        block : str or sequence of 3 floats, optional
            Width, height and length along the path, such as ``"15x15x40cm"``, or in m.
        gel : str, optional
            ``"10%"``, ``"20%"``, ``"clear"``, or the name of a preset.

        Warns
        -----
        DoubtWarning
            If the block is too small for the shot, or a level of it cannot be run.
        """
        made = new_shot_values(projectile, speed, yaw=yaw, roll=roll, block=block, gel=gel)
        for doubt in made["doubts"]:
            warnings.warn(doubt, DoubtWarning, stacklevel=2)
        return cls(made["text"])

    def with_values(self, values: Mapping[str, Value]) -> Scene:
        """Return a copy with further keys replaced, such as ``{"mesh.size": 2e-3}``."""
        made = copy.copy(self)
        made.values = dict(self.values)
        for key, value in values.items():
            made[key] = value
        return made

    def __getitem__(self, key: str) -> Value:
        """Return the value of a key: the replaced one, or that of the text."""
        check_key(key)
        base = next((own for own in self.values if key == own or key.startswith((f"{own}.", f"{own}["))), "")
        found: Any = self.values[base] if base else self._table
        for step in _STEP.findall(key[len(base) :]):
            try:
                found = found[int(step[1:-1]) - 1] if step.startswith("[") else found[step]
            except (KeyError, IndexError, TypeError):
                remedy = "set the whole key first"
                message = f"{key}: found no value in the scene {self.name}, only the default of gelfmu: {remedy}"
                raise GelfmuError(message, key=key, remedy=remedy) from None
        return found

    def __setitem__(self, key: str, value: Value) -> None:
        """Replace the value of a key, or the component of a vector, such as ``projectile.velocity[3]``.

        Raises
        ------
        GelfmuError
            For an unknown key, a component that is not there, and a text whose unit is none of the key.
        TypeError
            For a value that TOML cannot hold.
        """
        check_key(key)
        component = _COMPONENT.fullmatch(key)
        if component:
            self[key]  # refuses a vector without this component
            vector = list(self[component["vector"]])
            vector[int(component["number"]) - 1] = value
            key, value = component["vector"], vector
        toml_text(value)  # refuses what TOML cannot hold
        check_value(key, value)
        self.values[key] = value

    def arguments(self) -> list[str]:
        """Return the options of `gelfmu` for the replaced keys."""
        return [part for key, value in self.values.items() for part in ("--set", f"{key}={toml_text(value)}")]

    @contextmanager
    def source(self) -> Iterator[str]:
        """Give the path of a file with the text, or the name of a built-in scene, as long as the context lasts."""
        if isinstance(self._source, Path) and self._source.read_text(encoding="utf-8") != self.text:
            raise GelfmuError(f"{self._source}: it changed after it was read", remedy="load the scene again")
        if self._source is not None:
            yield str(self._source)
            return
        with tempfile.TemporaryDirectory(prefix="ballistic-gel-") as folder:
            path = Path(folder) / "scene.toml"
            path.write_text(self.text, encoding="utf-8")
            try:
                yield str(path)
            except GelfmuError as error:
                error.args = (str(error).replace(str(path), self.name),)
                raise

    def source_name(self) -> str | None:
        """Return the path of the file of the scene, or the name of a built-in one; None for a text."""
        return None if self._source is None else str(self._source)

    def digest(self, *further: str) -> str:
        """Return a hash of the text, the replaced keys, the files that they name, and further texts."""
        parts = [self.text, *sorted(f"{key}={toml_text(value)}" for key, value in self.values.items()), *further]
        parts += [file_hash(file) for file in self._files()]
        return hashlib.blake2b("\0".join(parts).encode(), digest_size=8).hexdigest()

    def _files(self) -> list[Path]:
        """Return the files whose names are values of keys, such as an STL file."""
        folder = self._source.parent if isinstance(self._source, Path) else Path()
        files = (folder / text for text in _texts_in([self._table, self.values]))
        return sorted({file for file in files if os.path.isfile(file)})  # False for what is no name of a file

    def check(self) -> SceneCheck:
        """Build the scene and return what it models.

        Raises
        ------
        GelfmuError
            With the key that is at fault, for a scene that is invalid.
        """
        with self.source() as name:
            return SceneCheck(call_json(["check", name, *self.arguments()]))

    def __repr__(self) -> str:
        replaced = ", ".join(f"{key}={toml_text(value)}" for key, value in self.values.items())
        return f"<Scene {self.name}{': ' + replaced if replaced else ''}>"


def new_shot_values(
    projectile: str, speed: float | str | None = None, *, block: str | Sequence[float] | None = None, **options: Any
) -> dict[str, Any]:
    """Return all that ``gelfmu new --json`` prints: the text of the scene, the shot and the doubts about it."""
    if block is not None and not isinstance(block, str):
        try:
            block = "x".join(repr(float(edge)) for edge in block)
        except (TypeError, ValueError):
            remedy = 'three lengths in m, or a text such as "15x15x40cm"'
            raise GelfmuError(f"block: found {block!r}, expected {remedy}", key="block", remedy=remedy) from None
    options = {"speed": speed, **options, "block": block}
    given = [f"--{name}={value}" for name, value in options.items() if value is not None]
    found: dict[str, Any] = call_json(["new", f"--projectile={projectile}", *given])
    return found


def _texts_in(value: Any) -> Iterator[str]:
    """Yield the texts in tables and lists, also in those that are in them."""
    if isinstance(value, str):
        yield value
    elif isinstance(value, (Mapping, list)):
        for part in value.values() if isinstance(value, Mapping) else value:
            yield from _texts_in(part)


def as_scene(scene: Scene | str | Path) -> Scene:
    """Return a scene as it is, of a file whose name ends with ``.toml``, or the built-in one of a name."""
    if isinstance(scene, Scene):
        return scene
    return Scene.load(scene) if Path(scene).suffix == ".toml" else Scene.built_in(str(scene))
