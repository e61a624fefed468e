"""Engines that run the shots of a sweep: local processes, Dask, Ray, or any executor."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import contextmanager
from typing import Any

from .tasks import Row, ShotTask, run_task

Submit = Callable[[ShotTask], "Future[Row]"]


class _Cancelled(Exception):
    """The sweep ends, and with it the process of a shot."""


@contextmanager
def open_engine(client: Any, workers: int | None, through_fmu: bool) -> Iterator[Submit]:
    """Give the function that submits a task; the end of the context cancels what has not begun.

    Shots that run are interrupted, if they run by the command on this machine or by Ray; FMUs of this machine are
    waited for, and others left to the client.

    Parameters
    ----------
    client : None, distributed.Client, the module ray, or concurrent.futures.Executor
        Where the shots run; None is this machine.
    workers : int or None
        Number of local workers; all cores that this process may use if None.
    through_fmu : bool
        True for shots through an FMU, which need a Python process each.
    """
    if client is None:
        with (_local_processes if through_fmu else _local_commands)(workers or _core_count()) as submit:
            yield submit
    elif hasattr(client, "get_executor"):
        executor = client.get_executor(pure=False)
        try:
            yield lambda task: executor.submit(run_task, task)
        finally:
            executor.shutdown(wait=False)
    elif hasattr(client, "remote"):
        with _remote_tasks(client) as submit:
            yield submit
    elif isinstance(client, Executor):
        yield lambda task: client.submit(run_task, task)
    else:
        raise TypeError(f"client: found {type(client).__name__}, expected a distributed.Client, ray or an Executor")


@contextmanager
def _remote_tasks(ray: Any) -> Iterator[Submit]:
    """Run tasks of Ray."""
    shooter, references = ray.remote(num_cpus=1)(run_task), []

    def submit(task: ShotTask) -> Future[Row]:
        references.append(shooter.remote(task))
        future: Future[Row] = references[-1].future()
        return future

    try:
        yield submit
    finally:
        for reference in references:
            ray.cancel(reference)  # nothing to one that has ended


@contextmanager
def _local_commands(workers: int) -> Iterator[Submit]:
    """Run `gelfmu` once for each shot; threads of this process only wait."""
    ended = threading.Event()

    def wait() -> None:
        if ended.is_set():
            raise _Cancelled

    with ThreadPoolExecutor(workers, thread_name_prefix="shot") as executor:
        try:
            yield lambda task: executor.submit(run_task, task, wait)
        finally:
            ended.set()
            executor.shutdown(wait=True, cancel_futures=True)


@contextmanager
def _local_processes(workers: int) -> Iterator[Submit]:
    """Keep one instance of the FMU in each of some Python processes."""
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(workers, context, _ignore_interrupts) as executor:
        try:
            yield lambda task: executor.submit(run_task, task)
        finally:
            executor.shutdown(wait=True, cancel_futures=True)


def _ignore_interrupts() -> None:
    """Leave a Ctrl-C to the process that started the sweep."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _core_count() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
