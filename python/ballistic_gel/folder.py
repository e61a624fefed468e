"""Folder of a sweep: claimed and checked by its manifest, by the rules of `gelfmu` for its own result folders."""

from __future__ import annotations

import json
import os
import sys
import threading
import time
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath
from typing import Any, BinaryIO

from .binary import call_binary
from .errors import GelfmuError

if sys.platform != "win32":
    import fcntl

MANIFEST = "gelfmu.jsonl"
# Command that made the folder, as the manifest names it.
_COMMAND = "sweep"
_EMPTY = "an empty or new folder"
# Seconds to wait for a lock, and between attempts: others hold it only while they append a few lines.
_PATIENCE, _PAUSE = 10.0, 0.01


@dataclass
class FolderContents:
    """Contents of a manifest, a journal with one JSON object per line.

    Attributes
    ----------
    command : str or None
        Command that made the folder; None before the first line.
    state : str or None
        Last state: ``claimed``, ``running``, ``complete``, ``interrupted`` or ``failed``.
    files : set of str
        Listed files, relative to the folder, with ``/``.
    """

    command: str | None = None
    state: str | None = None
    files: set[str] = field(default_factory=set)

    @classmethod
    def read(cls, text: bytes) -> FolderContents:
        """Replay a journal up to its last whole line.

        Raises
        ------
        ValueError
            With the number of the first line that is none of a manifest.
        """
        contents = cls()
        for number, line in enumerate(text.split(b"\n")[:-1], 1):
            try:
                contents._apply(json.loads(line))
            except (ValueError, KeyError, TypeError, AttributeError):
                raise ValueError(number) from None
        return contents

    def _apply(self, entry: Mapping[str, Any]) -> None:
        if self.command is None:
            self.command = str(entry["results_of"])
        self.state = entry.get("state") or self.state
        if "file" in entry:
            self.files.add(_inside(entry["file"]))
        self.files.discard(entry.get("removed", ""))


def _inside(name: str) -> str:
    """Return a name that stays inside of the folder."""
    path = PurePosixPath(name)
    if not path.parts or path.is_absolute() or ".." in path.parts:
        raise ValueError(name)
    return name


class SweepFolder:
    """Folder for the files of a sweep, into which several shares may write at the same time.

    A new or empty folder is claimed by its manifest. Each file is listed there before it is written, and only listed
    files are replaced or removed.

    Attributes
    ----------
    path : Path
        The folder, absolute.
    """

    def __init__(self, path: str | Path) -> None:
        self._given = path
        self.path = Path(path).resolve()

    def claim(self, needs: Iterable[str] = ()) -> None:
        """Claim the folder, which is made if it is missing.

        Parameters
        ----------
        needs : iterable of str
            Names of the files to write, relative to the folder, with ``/``.

        Raises
        ------
        GelfmuError
            If the folder was not made by a sweep, has a foreign file with the name of one that is needed, or cannot be
            written; its files are unchanged then.
        """
        with self._told():
            self.path.mkdir(parents=True, exist_ok=True)
            if not os.path.lexists(self.path / MANIFEST):
                names = sorted(os.listdir(self.path))
                # Another share may have claimed the folder meanwhile.
                if names and not os.path.lexists(self.path / MANIFEST):
                    there = f'it has "{names[0]}" and no {MANIFEST}'
                    raise self._refusal(f"a folder that is not empty and was not made by a sweep ({there})")
        with self._journal() as (_, contents):
            self._refuse_foreign(needs, contents)

    def list_files(self, names: Iterable[str]) -> None:
        """List files before they are written.

        Raises
        ------
        GelfmuError
            If an unlisted file has one of the names.
        """
        names = list(names)
        with self._journal() as (file, contents):
            self._refuse_foreign(names, contents)
            _append(file, [{"file": name} for name in names if name not in contents.files])

    def mark(self, state: str) -> None:
        """Record the state of the sweep."""
        with self._journal() as (file, contents):
            if contents.state != state:
                _append(file, [{"state": state}])

    def write(self, name: str, content: bytes) -> None:
        """Write a listed file so that it is there as a whole or not at all."""
        path = self.path / name
        with self._told():
            path.parent.mkdir(parents=True, exist_ok=True)
            write_whole(path, content)

    def publish(self, contents: Mapping[str, bytes]) -> None:
        """List and write some files, and record that the sweep is complete."""
        self.list_files(contents)
        for name, content in contents.items():
            self.write(name, content)
        self.mark("complete")

    @contextmanager
    def _journal(self) -> Iterator[tuple[BinaryIO, FolderContents]]:
        """Give the locked manifest, and its contents; a new one gets its first lines."""
        with self._told():
            place = self.path / MANIFEST
            if place.is_symlink() or (place.exists() and place.stat().st_nlink > 1):
                raise self._refusal("a manifest that is a link", "a copy of the folder, or another folder")
            with open(os.open(place, os.O_RDWR | os.O_CREAT | os.O_APPEND, 0o666), "r+b") as file:
                # Refuses the folder of another command before waiting: a run holds its lock until it ends.
                self._contents_of(file)
                is_locked = self._lock(file)
                contents, whole = self._contents_of(file)
                if is_locked:  # otherwise another share may be writing the line behind it
                    file.truncate(whole)  # what is behind it was left by a killed process
                if contents.command is None:
                    version = call_binary(["--version"]).output.partition("\n")[0].removeprefix("gelfmu ")
                    contents.command, contents.state = _COMMAND, "claimed"
                    _append(file, [{"results_of": _COMMAND, "version": version}, {"state": "claimed"}])
                yield file, contents

    def _contents_of(self, file: BinaryIO) -> tuple[FolderContents, int]:
        """Return the contents of the manifest, and the length of its whole lines, bytes."""
        file.seek(0)
        text = file.read()
        try:
            contents = FolderContents.read(text)
        except ValueError as line:
            raise self._refusal(f"a {MANIFEST} whose line {line} is none of a manifest of gelfmu") from None
        if contents.command not in (None, _COMMAND):
            remedy = f"{_EMPTY}: remove this one yourself if nobody needs it"
            raise self._refusal(f"results of gelfmu {contents.command}", remedy)
        return contents, text.rfind(b"\n") + 1

    def _lock(self, file: BinaryIO) -> bool:
        """Lock the manifest until it is closed; return False where the system has no locks, and the sweep goes on."""
        if sys.platform == "win32":
            return False
        until = time.monotonic() + _PATIENCE
        while True:
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
                return True
            except BlockingIOError:
                if time.monotonic() > until:
                    other = "a folder that no other run uses"
                    raise self._refusal("that another run is writing there", other) from None
                time.sleep(_PAUSE)
            except OSError:
                return False

    def _refuse_foreign(self, needs: Iterable[str], contents: FolderContents) -> None:
        """Refuse unlisted files in the place of results, and links out of the folder."""
        names = [*needs, *contents.files]
        folders = {str(parent) for name in names for parent in PurePosixPath(name).parents} - {"."}
        strange = [self.path / name for name in sorted(folders) if _is_no_folder(self.path / name)]
        strange += [place for name in names if _is_strange(place := self.path / name, name in contents.files)]
        if strange:
            what = f"{strange[0]}, which no sweep has made and which has the name of a result"
            raise self._refusal(what, f"{_EMPTY}: or move the file away")

    def _refusal(self, found: str, expected: str = _EMPTY) -> GelfmuError:
        return GelfmuError(f"out {self._given}: found {found}, expected {expected}", remedy=f"expected {expected}")

    @contextmanager
    def _told(self) -> Iterator[None]:
        """Tell an error of the system with the folder."""
        try:
            yield
        except OSError as error:
            raise self._refusal(f"{error.strerror or error}", "a folder that can be written") from error


def write_whole(path: Path, content: bytes) -> None:
    """Write a file so that it is there as a whole or not at all."""
    part = path.with_name(f".{path.name}.{os.getpid()}.{threading.get_ident()}")
    try:
        part.write_bytes(content)
        part.replace(path)
    except BaseException:
        part.unlink(missing_ok=True)
        raise


def _is_no_folder(path: Path) -> bool:
    return os.path.lexists(path) and (path.is_symlink() or not path.is_dir())


def _is_strange(path: Path, is_listed: bool) -> bool:
    return os.path.lexists(path) and (not is_listed or (path.is_dir() and not path.is_symlink()))


def _append(file: BinaryIO, entries: Iterable[Mapping[str, str]]) -> None:
    """Append lines to a journal in one piece."""
    lines = "".join(json.dumps(entry, ensure_ascii=False, separators=(",", ":")) + "\n" for entry in entries)
    file.write(lines.encode())
    file.flush()
