"""Progress of long calls: a bar in terminals and notebooks, lines on standard error elsewhere."""

from __future__ import annotations

import sys
import time

# Seconds between two lines, and before the first one.
_INTERVAL = 30.0


def shows_bars() -> bool:
    """Return True in a notebook, or if standard error is a terminal."""
    return "ipykernel" in sys.modules or (sys.stderr is not None and sys.stderr.isatty())


class ProgressLines:
    """Lines on standard error, such as ``shots: 17 of 24, 71 %, 62 s elapsed, 26 s left``.

    There is at most one every 30 s, and none in the first 30 s.
    """

    def __init__(self, name: str) -> None:
        self._name = name
        self._begun = self._told = time.monotonic()

    def tell(self, task: str, fraction: float | None) -> None:
        """Write a line, if it is time.

        Parameters
        ----------
        task : str
            What is done, such as ``17 of 24``.
        fraction : float or None
            The completed fraction, from 0 to 1; None if it is not known.
        """
        now = time.monotonic()
        if now - self._told < _INTERVAL:
            return
        self._told, gone = now, now - self._begun
        parts = [task] if fraction is None else [task, f"{100 * fraction:.0f} %"]
        left = [f"{gone / fraction - gone:.0f} s left"] if fraction else []
        print(f"{self._name}: {', '.join([*parts, f'{gone:.0f} s elapsed', *left])}", file=sys.stderr, flush=True)
