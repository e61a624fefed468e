"""The command `gelfmu`: where it is found, and how it is called and interrupted."""

from __future__ import annotations

import functools
import hashlib
import json
import os
import shutil
import signal
import subprocess
import sys
import sysconfig
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

from .errors import GelfmuError

_ON_WINDOWS = sys.platform == "win32"
_NAME = "gelfmu.exe" if _ON_WINDOWS else "gelfmu"
_INTERRUPTED = 130
# Seconds between two looks at a process that runs, and for one that was interrupted to write its results.
_INTERVAL = 0.2
_GRACE = 120.0


@dataclass(frozen=True)
class CommandResult:
    """Result of a finished command: exit status, standard output and standard error."""

    status: int
    output: str
    errors: str

    def message(self) -> str:
        """Return the error that the command reported, without its prefix."""
        if told := self._told():
            return str(told["error"])
        lines = [line.removeprefix("error: ") for line in self.errors.splitlines() if line.startswith("error: ")]
        return "\n".join(lines) or self.errors.strip() or f"gelfmu ended with status {self.status}"

    def error(self) -> GelfmuError:
        """Return the error that the command reported, with the key of the scene that it names."""
        return GelfmuError(self.message(), key=self._told().get("key") or None)

    def _told(self) -> dict[str, Any]:
        """Return the error as JSON; empty unless the command was asked for JSON and failed."""
        try:
            told = json.loads(self.output)
        except ValueError:
            return {}
        return told if isinstance(told, dict) and "error" in told else {}

    @property
    def was_refused(self) -> bool:
        """True if the command refused its input."""
        return self.status == 2

    @property
    def was_interrupted(self) -> bool:
        """True if the command ended because it was interrupted."""
        return self.status == _INTERRUPTED


def find_binary() -> Path:
    """Return the path of `gelfmu`.

    The environment variable ``GELFMU`` comes first, then the scripts folder of the Python environment, the folder
    of the Python interpreter, and the search path.

    Raises
    ------
    GelfmuError
        If there is no `gelfmu`, or ``GELFMU`` names no file.
    """
    given = os.environ.get("GELFMU")
    if given:
        if Path(given).is_file():
            return Path(given).resolve()
        raise GelfmuError(f"GELFMU={given}: found no file", remedy="set GELFMU to the path of gelfmu, or unset it")
    folders = [Path(sysconfig.get_path("scripts")), Path(sys.executable).parent]
    for candidate in (folder / _NAME for folder in folders):
        if candidate.is_file():
            return candidate
    on_path = shutil.which("gelfmu")
    if on_path:
        return Path(on_path)
    remedy = "install the wheel of the package, which holds it, or set GELFMU to the path of gelfmu"
    raise GelfmuError(f"found no program gelfmu: {remedy}", remedy=remedy)


def binary_stamp() -> str:
    """Return a hash of the program, which changes whenever its results may."""
    return file_hash(find_binary())


def file_hash(path: Path) -> str:
    """Return a hash of the content of a file, which is read once until it changes."""
    about = path.stat()
    return _hash_of(path, about.st_mtime_ns, about.st_size)


@functools.lru_cache(maxsize=64)
def _hash_of(path: Path, _modified: int, _size: int) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "blake2b").hexdigest()[:32]


def call_binary(
    arguments: Sequence[str],
    *,
    timeout: float | None = None,
    on_wait: Callable[[], None] | None = None,
) -> CommandResult:
    """Run `gelfmu` to its end and return its result.

    The process gets one interrupt, and time to keep what it computed, if this call is interrupted or `on_wait`
    raises; a second interrupt kills it. If this Python process is killed, the end of its input ends it.

    Parameters
    ----------
    arguments : sequence of str
        Subcommand and options.
    timeout : float, optional
        Wall-clock seconds after which the process is interrupted, too. Its result then has the status 130.
    on_wait : callable, optional
        Called about every 0.2 s while the process runs.
    """
    reading, writing = os.pipe()
    # Nothing is written: the pipe ends with this process.
    with os.fdopen(reading, "rb") as input_end, os.fdopen(writing, "wb"):
        return _wait_for(_start([*arguments, "--end-with-input"], input_end), timeout, on_wait)


@contextmanager
def open_binary(arguments: Sequence[str]) -> Iterator[subprocess.Popen[str]]:
    """Give a process of `gelfmu` with pipes to its input and from its output; the end of the context ends it.

    A second end of its input, that of this Python process, ends it, too: it reads nothing more, and finishes.
    """
    process = _start(arguments, subprocess.PIPE)
    try:
        yield process
    finally:
        with suppress(OSError):
            process.stdin and process.stdin.close()
        if process.poll() is None:
            process.terminate()
        process.wait()


def _start(arguments: Sequence[str], input_end: BinaryIO | int) -> subprocess.Popen[str]:
    # A group of its own: a Ctrl-C in the terminal reaches it once, by way of this process.
    group: dict[str, Any] = {"creationflags": 0x200} if _ON_WINDOWS else {"process_group": 0}
    return subprocess.Popen(
        [str(find_binary()), *arguments],
        stdin=input_end,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        encoding="utf-8",
        errors="replace",
        **group,
    )


def _wait_for(
    process: subprocess.Popen[str], timeout: float | None, on_wait: Callable[[], None] | None
) -> CommandResult:
    deadline = None if timeout is None else time.monotonic() + timeout
    try:
        while True:
            try:
                output, errors = process.communicate(timeout=_INTERVAL)
                return CommandResult(process.returncode, output, errors)
            except subprocess.TimeoutExpired:
                pass
            if deadline is not None and time.monotonic() > deadline:
                _end(process)
                return CommandResult(_INTERRUPTED, "", f"error: it ran past the timeout of {timeout} s")
            if on_wait is not None:
                on_wait()
    except BaseException:
        _end(process)
        raise


def _end(process: subprocess.Popen[str]) -> None:
    """Interrupt a process, wait for it, and kill it if it does not end."""
    try:
        if process.poll() is None:
            process.send_signal(_request_to_end())
            process.communicate(timeout=_GRACE)
    except subprocess.TimeoutExpired:
        pass
    finally:
        if process.poll() is None:
            process.kill()
            process.communicate()


def _request_to_end() -> signal.Signals:
    """Return the signal after which `gelfmu` keeps what it computed."""
    if _ON_WINDOWS:
        return signal.Signals["CTRL_BREAK_EVENT"]
    # A program that was started in the background ignores interrupts, and so do those that it starts.
    is_ignored = signal.getsignal(signal.SIGINT) == signal.SIG_IGN
    return signal.SIGTERM if is_ignored else signal.SIGINT


def call_json(arguments: Sequence[str], *, on_wait: Callable[[], None] | None = None) -> Any:
    """Run `gelfmu` with ``--json`` and return what it prints.

    Raises
    ------
    GelfmuError
        If the command fails.
    """
    result = call_binary([*arguments, "--json", "--quiet"], on_wait=on_wait)
    if result.status != 0:
        raise result.error()
    return json.loads(result.output)
