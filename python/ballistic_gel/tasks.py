"""Single shots of a sweep: a task in, a row out."""

from __future__ import annotations

import atexit
import json
import math
import shutil
import tempfile
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from .binary import binary_stamp, call_binary
from .errors import GelfmuError
from .fmu import FmuInstance
from .scene import Scene
from .shot import Shot
from .values import Value, toml_text

Row = dict[str, Any]
# Status of a row: it reached its end, it stopped before, the scene was refused, or the process died. A row of the last
# kind is not kept, so that the next sweep repeats the shot.
COMPLETED, STOPPED, REFUSED, CRASHED = "completed", "stopped", "refused", "crashed"
# Figures of the summary that depend on the machine.
CLOCK = ("wall_seconds", "cpu_seconds", "serial_seconds", "parallel_seconds", "updates_per_second")
# Texts that are the same in all rows, and tables whose length is not.
_CONSTANT = ("format", "threads", "version", "interface", "failure", "doubt", "completed", "scene", "switched_off")
_LEFT_OUT = (*CLOCK, *_CONSTANT, "cavity_course", "energy_per_centimetre")
_VECTORS = ("exit_velocity", "final_velocity", "total_impulse", "position")


@dataclass(frozen=True)
class ShotTask:
    """One shot of a sweep.

    Attributes
    ----------
    scene : Scene
        Scene without the values of the row.
    values : mapping
        Keys and values of the row; for an FMU the names of its parameters.
    stamp : str
        Hash of the program.
    options : str
        Further option of the command, such as ``--fidelity=draft``; may be empty.
    fmu : Path or None
        Archive through which the shot is run.
    folder : Path or None
        Folder in which the results are kept; without it they are removed.
    batch : bool
        True for one of many shots in one process, whose figures by step are coarser.
    """

    scene: Scene
    values: Mapping[str, Value]
    stamp: str
    options: str = ""
    fmu: Path | None = None
    folder: Path | None = None
    batch: bool = False

    def key(self) -> str:
        """Return the name of the row: a hash of the program, the scene and the values."""
        own = [f"{name}={toml_text(value)}" for name, value in sorted(self.values.items())]
        return self.scene.digest(self.stamp, self.options, self._way(), *own)

    def _way(self) -> str:
        return "fmu" if self.fmu else "batch" if self.batch else "command"


def run_task(task: ShotTask, on_wait: Callable[[], None] | None = None) -> Row:
    """Run a shot and return its row: status, reason, figures, and the clock apart."""
    made = tempfile.mkdtemp(prefix="ballistic-gel-") if task.folder is None else None
    folder = Path(made) / "shot" if made else Path(str(task.folder)) / task.key()
    try:
        return _run_fmu(task, folder) if task.fmu else _run_command(task, folder, on_wait)
    finally:
        if made:
            shutil.rmtree(made, ignore_errors=True)


def _run_command(task: ShotTask, folder: Path, on_wait: Callable[[], None] | None) -> Row:
    if binary_stamp() != task.stamp:
        remedy = "install the same gelfmu on all machines of the sweep"
        raise GelfmuError(f"found another gelfmu here than where the sweep was started: {remedy}", remedy=remedy)
    scene = task.scene.with_values(task.values)
    options = ["--direct", "--no-frames", "--no-report", "--quiet", "--json", "--threads=1", f"--out={folder}"]
    options += [task.options] if task.options else []
    options += ["--force"] if task.folder else []
    with scene.source() as name:
        result = call_binary(["run", name, *scene.arguments(), *options], on_wait=on_wait)
    if result.status == 0 or (result.status == 1 and '"digest"' in result.output):
        return row_of(json.loads(result.output))
    message = result.message()
    # A folder that is refused, as on a full disk, is no fault of the shot.
    status = REFUSED if result.was_refused and not message.startswith("--out ") else CRASHED
    # Paths of this run are no part of a row.
    return failed_row(status, message.replace(name, scene.name).replace(str(folder), "the folder"))


def _run_fmu(task: ShotTask, folder: Path) -> Row:
    """Run a shot through an instance of the FMU."""
    place = folder if task.folder else folder.parent / _SHARED
    try:
        with _instance_for(task, place) as instance:
            try:
                instance.set({**task.values, "output_directory": str(place.parent)})
                instance.initialize()
            except GelfmuError as error:
                # A folder that is refused, as on a full disk, and a lack of memory are no fault of the shot.
                if instance.is_lost or "output_directory" in str(error) or "memory: " in str(error):
                    raise
                return failed_row(REFUSED, str(error))
            instance.step_to_end()
        return row_of(Shot.load(place).summary)
    except GelfmuError as error:
        return failed_row(CRASHED, str(error))


_SHARED = "shot"
_instances: dict[Path, FmuInstance] = {}
_instance_lock = threading.Lock()


@contextmanager
def _instance_for(task: ShotTask, place: Path) -> Iterator[FmuInstance]:
    """Give the instance of this process, reset; or, for results that are kept, one with the name of their folder."""
    assert task.fmu is not None
    if task.folder:
        with FmuInstance(task.fmu, place.name) as instance:
            yield instance
        return
    with _instance_lock:
        # The archives of earlier sweeps are gone.
        for lost in [path for path in _instances if not path.exists()]:
            _instances.pop(lost).close()
        if task.fmu not in _instances:
            _instances[task.fmu] = FmuInstance(task.fmu, _SHARED)
            atexit.register(_instances[task.fmu].close)
        try:
            _instances[task.fmu].reset()
            yield _instances[task.fmu]
        except BaseException:
            # The next shot gets a new one.
            _instances.pop(task.fmu).close()
            raise


def is_row(found: Any) -> bool:
    """Return whether what a file holds is a row with a result, and whole."""
    return (
        isinstance(found, dict)
        and found.get("status") in (COMPLETED, STOPPED, REFUSED)
        and isinstance(found.get("reason", 0), (str, type(None)))
        and isinstance(found.get("figures"), dict)
        and isinstance(found.get("clock", {}), dict)
    )


def failed_row(status: str, reason: str) -> Row:
    """Return the row of a shot without results."""
    return {"status": status, "reason": reason, "figures": {}}


def value_of(figure: Any) -> float:
    """Return a figure of a row as a number; NaN for one without a value."""
    return math.nan if figure is None else float(figure)


def depth_of(place: str, row: Any) -> float:
    """Return the depth at rest of a completed row of a table, or at its end for a projectile that does not rest, m.

    Raises
    ------
    GelfmuError
        If the shot did not reach its end, or left the block.
    """
    if row["status"] != COMPLETED:
        remedy = "take a cheaper level, or another shot"
        found = f"the shot has no depth, it is {row['status']} ({row['reason']})"
        raise GelfmuError(f"{place}: {found}: {remedy}", remedy=remedy)
    if row["perforated"]:
        remedy = "take a longer block"
        raise GelfmuError(f"{place}: the projectile left the block, which has no depth: {remedy}", remedy=remedy)
    rest = value_of(row.get("rest_depth"))
    return value_of(row["final_depth"]) if math.isnan(rest) else rest


def row_of(summary: dict[str, Any]) -> Row:
    """Return the row of a shot with these figures."""
    return {
        "status": COMPLETED if summary["completed"] else STOPPED,
        "reason": summary["failure"],
        "figures": dict(_flatten(summary)),
        "clock": {name: summary.get(name) for name in CLOCK},
    }


def _flatten(figures: Mapping[str, Any], place: str = "") -> Iterator[tuple[str, Any]]:
    """Yield single figures; vectors, fragments and sensors count from 1, doubts are joined."""
    for name, value in figures.items():
        path = place + name
        if path == "energy_per_centimetre":
            yield "greatest_energy_per_centimetre", max(value or [], default=None)
        if path in _LEFT_OUT:
            continue
        if name == "doubts":
            yield path, "; ".join(value) or None
        elif name in _VECTORS:
            yield from ((f"{path}[{number}]", part) for number, part in enumerate(value or [None] * 3, 1))
        elif isinstance(value, dict):
            yield from _flatten(value, f"{path}.")
        elif isinstance(value, list):
            for number, part in enumerate(value, 1):
                yield from _flatten(part, f"{path}[{number}].")
        else:
            yield path, value
