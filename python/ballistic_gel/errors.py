"""Errors of the package: what was found, the key of the scene that is at fault, and the remedy."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .shot import Shot

# The messages of the command have the form `[place: ]key: found X, expected Y`.
_KEY = re.compile(r"(?:^|: )([a-z_]+(?:\[\d+\])?(?:\.[\w-]+(?:\[\d+\])?)+): found")
_HINT = re.compile(r"\((did you mean [^)]*)\)")


class GelfmuError(Exception):
    """Error that `gelfmu` or this package reports.

    Attributes
    ----------
    key : str or None
        Dotted key of the scene that is at fault, if the message names one.
    remedy : str or None
        What to do, or what was expected, if the message says so.
    """

    def __init__(self, message: str, *, key: str | None = None, remedy: str | None = None) -> None:
        super().__init__(message)
        self.key = key if key is not None else _key_in(message)
        self.remedy = remedy if remedy is not None else _remedy_in(message)


class ShotError(GelfmuError):
    """Error of a run that stopped before its end.

    Attributes
    ----------
    shot : Shot or None
        What was computed until then, if anything was kept.
    """

    def __init__(self, message: str, shot: Shot | None = None) -> None:
        super().__init__(message)
        self.shot = shot


class DoubtWarning(UserWarning):
    """Warning that the figures of a run are doubtful."""


def _key_in(message: str) -> str | None:
    found = _KEY.search(message)
    return found.group(1) if found else None


def _remedy_in(message: str) -> str | None:
    hint = _HINT.search(message)
    _, _, expected = message.partition("expected ")
    parts = [hint.group(1) if hint else "", f"expected {expected}" if expected else ""]
    return "; ".join(part for part in parts if part) or None
