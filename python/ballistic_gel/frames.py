"""Frames of a run: the meshes of gel and bodies by time."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, overload
from xml.etree import ElementTree

from .errors import GelfmuError


@dataclass(frozen=True)
class Frame:
    """Meshes at one time.

    Attributes
    ----------
    time : float
        Time, s.
    gel : pyvista.UnstructuredGrid
        Mesh of the gel, with its fields.
    bodies : tuple of pyvista.DataSet
        Projectile and fragments.
    """

    time: float
    gel: Any
    bodies: tuple[Any, ...]


class FrameSequence(Sequence[Frame]):
    """Frames of a run, read when they are asked for; needs pyvista."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    @functools.cached_property
    def _files(self) -> dict[float, list[Path]]:
        """Files of each time, that of the gel first."""
        path = self._folder / "series.pvd"
        if not path.is_file():
            raise GelfmuError(f"{path}: this run has no frames", remedy="run with frames=True")
        files: dict[float, list[Path]] = {}
        for entry in ElementTree.parse(path).iter("DataSet"):
            files.setdefault(float(entry.attrib["timestep"]), []).append(self._folder / entry.attrib["file"])
        return files

    @property
    def times(self) -> list[float]:
        """Times of the frames, s."""
        return list(self._files)

    def at(self, time: float) -> Frame:
        """Return the frame whose time, s, is nearest."""
        times = self.times
        return self[min(range(len(times)), key=lambda index: abs(times[index] - time))]

    def __len__(self) -> int:
        return len(self._files)

    @overload
    def __getitem__(self, index: int) -> Frame: ...
    @overload
    def __getitem__(self, index: slice) -> list[Frame]: ...
    def __getitem__(self, index: int | slice) -> Frame | list[Frame]:
        if isinstance(index, slice):
            return [self[place] for place in range(*index.indices(len(self)))]
        try:
            import pyvista
        except ImportError as error:
            remedy = "pip install pyvista"
            raise GelfmuError(f"found no pyvista, which reads frames: {remedy}", remedy=remedy) from error
        time = self.times[index]
        gel, *bodies = (pyvista.read(path) for path in self._files[time])
        return Frame(time, gel, tuple(bodies))

    def __repr__(self) -> str:
        return f"<{len(self)} frames, {self.times[0]:g} to {self.times[-1]:g} s>"
