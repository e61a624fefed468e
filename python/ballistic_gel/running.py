"""Runs of scenes by the command `gelfmu`."""

from __future__ import annotations

import contextlib
import functools
import os
import tomllib
import warnings
from collections.abc import Mapping
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from .binary import CommandResult, binary_stamp, call_binary
from .errors import DoubtWarning, GelfmuError, ShotError
from .progress import ProgressLines, shows_bars
from .scene import Scene, as_scene
from .shot import Shot
from .values import Value

# End of a history that is read for its last row, bytes.
_TAIL_BYTES = 8192


def run(
    scene: Scene | str | Path,
    *,
    values: Mapping[str, Value] | None = None,
    fidelity: str | int | None = None,
    accuracy: float | str | None = None,
    out: str | Path | None = None,
    force: bool = False,
    frames: bool = True,
    report: bool = True,
    measured: str | Path | None = None,
    threads: int = 0,
    progress: bool = True,
    timeout: float | None = None,
) -> Shot:
    """Run a scene and return its results.

    Parameters
    ----------
    scene : Scene, str or Path
        Scene, the name of a built-in one, or the path of a file that ends with ``.toml``.
    values : mapping, optional
        Dotted keys and values that replace those of the scene, such as ``{"mesh.size": 2e-3}``.
    fidelity : str or int, optional
        Level of accuracy: ``"draft"``, ``"coarse"``, ``"standard"``, ``"fine"``, ``"reference"`` or ``"instant"``, or
        0 to 5.
    accuracy : float or str, optional
        Largest expected error, as a fraction or in the form ``"2%"``; the cheapest level that meets it is run.
    out : str or Path, optional
        Folder for the results. Without it a folder in ``gelfmu-out`` that is named after the scene and a hash of its
        text and values: the same run goes into the same folder, and replaces what it computed before.
    force : bool
        Replace the results of an earlier run in `out`.
    frames, report : bool
        Write meshes for `Shot.frames`, and ``report.html``.
    measured : str or Path, optional
        Table of a laboratory, CSV, by time or depth: its curves are compared with those of the run, in the report and
        in `Shot.measured`.
    threads : int
        Threads, 0 for all cores. Results do not depend on it.
    progress : bool
        Show a bar in notebooks and terminals, elsewhere a line on standard error every 30 s.
    timeout : float, optional
        Wall-clock seconds after which the run is stopped. What it computed is kept.

    Raises
    ------
    GelfmuError
        If the scene, the folder or the table is refused; `key` and `remedy` say why.
    ShotError
        If the run stopped before its end; `shot` has what was computed.
    KeyboardInterrupt
        If it was interrupted. The folder has what was computed; the note of the exception names it.
    """
    scene = as_scene(scene).with_values(values or {})
    options = [] if fidelity is None else [f"--fidelity={fidelity}"]
    if accuracy is not None:
        options.append(f"--accuracy={accuracy if isinstance(accuracy, str) else f'{100 * accuracy:.12g}%'}")
    if out is None:
        out = Path("gelfmu-out") / f"{scene.name}-{scene.digest(binary_stamp(), *options)}"
        force = True
    folder = Path(out)
    options += [] if frames else ["--no-frames"]
    options += [] if report else ["--no-report"]
    options += [] if measured is None else [f"--measured={measured}"]
    options += ["--force"] if force else []
    with scene.source() as name, ProgressBar(folder, scene.name, progress) as bar:
        command = ["run", name, *scene.arguments(), *options, f"--out={folder}", f"--threads={threads}"]
        try:
            result = call_binary([*command, "--direct", "--quiet", "--json"], timeout=timeout, on_wait=bar.update)
        except KeyboardInterrupt as interrupt:
            interrupt.add_note(f"what was computed is in {folder}: ballistic_gel.Shot.load({str(folder)!r})")
            raise
        return shot_of(result, folder)


def shot_of(result: CommandResult, folder: Path) -> Shot:
    """Return the shot of a command that ended, or raise the error of the command."""
    if result.status == 0:
        shot = Shot.load(folder)
        for doubt in shot.doubts:
            warnings.warn(doubt, DoubtWarning, stacklevel=3)
        return shot
    if result.was_refused:
        raise result.error()
    shot = None
    with contextlib.suppress(GelfmuError):
        shot = Shot.load(folder)
    # The folder may still hold a completed shot of an earlier run, if this one failed before it replaced that.
    raise ShotError(result.message(), None if shot is None or shot.completed else shot)


class ProgressBar:
    """Bar or lines of the simulated time of a run, read from the history that it writes."""

    def __init__(self, folder: Path, name: str, wanted: bool) -> None:
        self._folder = folder
        self._name = name
        self._wanted = wanted
        self._lines = None if shows_bars() else ProgressLines(name)
        self._bar: Any = None
        self._begun = _modified(folder / "history.csv")

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._bar is not None:
            if kind is None and self._bar.total is not None:
                # A run that ended by the exit or the rest of the projectile is over before the latest end.
                self._bar.total = self._bar.n
            self._bar.close()

    def update(self) -> None:
        """Move the bar to the last time of the history, or tell it."""
        time = self._time() if self._wanted else None
        if time is None:
            return
        if self._lines is not None:
            end = self._end_time
            # A run may end much earlier, by the exit or the rest of the projectile: no time left is told.
            most = "" if end is None else f" of at most {1e3 * end:.3f}"
            self._lines.tell(f"{1e3 * time:.3f}{most} ms", None)
            return
        if self._bar is None:
            from tqdm.auto import tqdm

            end = self._end_time
            style = "{desc} {percentage:3.0f} %|{bar}| {n:.3f} of at most {total:.3f} ms, {elapsed} elapsed"
            self._bar = tqdm(total=end and 1e3 * end, desc=self._name, bar_format=style if end else None, unit="ms")
        self._bar.update(1e3 * time - self._bar.n)

    def _time(self) -> float | None:
        """Return the time of the last whole row, s, once this run has written one."""
        path = self._folder / "history.csv"
        if _modified(path) == self._begun:
            return None
        try:
            with path.open("rb") as file:
                file.seek(max(0, path.stat().st_size - _TAIL_BYTES))
                lines = file.read().split(b"\n")
            return float(lines[-2].split(b",")[0])
        except (OSError, ValueError, IndexError):
            # The run replaces its files at this moment, or has written no row yet.
            return None

    @functools.cached_property
    def _end_time(self) -> float | None:
        """End time of the scene, s, if it is a number without a unit."""
        try:
            with (self._folder / "scene.toml").open("rb") as file:
                end = tomllib.load(file).get("scene", {}).get("end_time")
        except (OSError, tomllib.TOMLDecodeError):
            return None
        return float(end) if isinstance(end, (int, float)) else None


def _modified(path: Path) -> int:
    try:
        return os.stat(path).st_mtime_ns
    except OSError:
        return 0
