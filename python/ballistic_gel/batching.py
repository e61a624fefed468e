"""Shots of the reduced model in one process of `gelfmu`, which answers each line with a line."""

from __future__ import annotations

import json
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from contextlib import contextmanager
from typing import Any

from .binary import open_binary
from .errors import GelfmuError
from .tasks import Row, ShotTask, failed_row, row_of


@contextmanager
def open_batch(workers: int | None) -> Iterator[Callable[[ShotTask], Future[Row]]]:
    """Give the function that submits a task to one `gelfmu`; the end of the context ends that.

    Parameters
    ----------
    workers : int or None
        Shots at the same time; one on each core if None or 0.
    """
    with open_binary(["batch", f"--threads={workers or 0}"]) as process:
        shots: dict[int, Future[Row]] = {}
        entry = process.stdin
        assert entry is not None
        reader = threading.Thread(target=_resolve, args=(process.stdout, shots), daemon=True)
        lock = threading.Lock()

        def submit(task: ShotTask) -> Future[Row]:
            future: Future[Row] = Future()
            with lock:
                shots[len(shots)] = future
                try:
                    entry.write(_line_of(task))
                    entry.flush()
                except OSError:
                    _fail(future)
            return future

        reader.start()
        yield submit


def _line_of(task: ShotTask) -> str:
    """Return the line of a task."""
    scene = task.scene.with_values(task.values)
    source = scene.source_name()
    shot = {"scene": source or scene.name, "set": scene.arguments()[1::2]}
    if source is None:
        shot["text"] = scene.text
    return json.dumps(shot) + "\n"


def _resolve(output: Any, shots: dict[int, Future[Row]]) -> None:
    """Give each shot its row, and what is left an error once the process has ended."""
    for line in output:
        answer = json.loads(line)
        future = shots[answer["index"]]
        if future.set_running_or_notify_cancel():
            made = answer["summary"]
            future.set_result(row_of(made) if made else failed_row(answer["status"], answer["reason"]))
    for future in list(shots.values()):
        if not future.done():
            _fail(future)


def _fail(future: Future[Row]) -> None:
    if future.set_running_or_notify_cancel():
        remedy = "the same call runs what is missing"
        error = GelfmuError(f"the process of the shots has ended before them: {remedy}", remedy=remedy)
        future.set_exception(error)
