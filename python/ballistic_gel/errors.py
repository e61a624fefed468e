"""Errors of the package: what was found, the key of the scene that is at fault, and the remedy."""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .shot import Shot

# The messages have the form `[place: ]key: found X, expected Y`, and those of the FMU `key = X: expected Y`.
_KEY = re.compile(r"(?:^|: )([a-z_]+(?:\[\d+\])?(?:\.[\w-]+(?:\[\d+\])?)+)(?:: found| = \S+: expected)")
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


class CrashWarning(UserWarning):
    """Warning that processes of shots died."""


class FitWarning(UserWarning):
    """Warning that a calibration ended without a fit."""


def unknown_name(name: str, known: Iterable[str], kind: str) -> GelfmuError:
    """Return the error for an unknown name, with the known one that is nearest."""
    near = difflib.get_close_matches(name, list(known), n=1, cutoff=0.0)
    remedy = f"did you mean `{near[0]}`?" if near else None
    hint = f" ({remedy})" if remedy else ""
    return GelfmuError(f"{name}: found the unknown {kind} `{name}`{hint}", key=name, remedy=remedy)


def _key_in(message: str) -> str | None:
    found = _KEY.search(message)
    return found.group(1) if found else None


def _remedy_in(message: str) -> str | None:
    hint = _HINT.search(message)
    _, _, expected = message.partition("expected ")
    parts = [hint.group(1) if hint else "", f"expected {expected}" if expected else ""]
    return "; ".join(part for part in parts if part) or None
