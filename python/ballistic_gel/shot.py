"""A shot: the results of a run, in its folder."""

from __future__ import annotations

import functools
import html
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pandas as pd

from .binary import call_json
from .columns import to_dataset
from .errors import GelfmuError
from .frames import FrameSequence
from .plots import ShotPlots

if TYPE_CHECKING:
    import xarray

_FILES = {
    "history": "history.csv",
    "by_depth": "shot.csv",
    "cavity": "cavity.csv",
    "track": "track.csv",
    "cracks": "cracks.csv",
    "layers": "layers.csv",
}
# Columns of the table of the layers.
_LAYERS = (
    *("layer", "depth_from_m", "depth_to_m", "density_kg_per_m3"),
    *("entry_speed_m_per_s", "energy_J", "energy_fraction"),
)
_ONLY_DEEP = "it is written for a projectile that goes deeper along -z than its length"
# Key figures of a shot: key of the summary, caption, factor and unit.
_FIGURES = (
    ("rest_depth", "rest depth", 1e3, "mm"),
    ("peak_depth", "greatest depth", 1e3, "mm"),
    ("greatest_cavity_diameter", "temporary cavity, greatest diameter", 1e3, "mm"),
    ("greatest_track_diameter", "permanent track, greatest diameter", 1e3, "mm"),
    ("neck_length", "length of the neck", 1e3, "mm"),
    ("energy_deposited", "energy given to the gel", 1.0, "J"),
    ("peak_force", "peak force", 1.0, "N"),
)
# Columns of the residuals of measured curves.
_RESIDUALS = (
    *("quantity", "column", "by", "unit", "points", "outside"),
    *("rms", "greatest", "greatest_at", "rms_percent", "greatest_percent"),
)
# Figures that each summary has, and their types.
_EACH = {"scene": str, "completed": bool, "doubts": list, "digest": str, "ended_by": str}


# Format of ``summary.json`` that can be read.
_FORMAT = 2


class _ForeignSummaryError(ValueError):
    """Summary of another release."""

    def __init__(self, figures: dict[str, Any]) -> None:
        written = f"format {figures['format']}" if "format" in figures else "no format"
        release = f", written by gelfmu {figures['version']}" if "version" in figures else ""
        super().__init__(f"{written}{release}, in the place of format {_FORMAT}")


def _figures_in(text: str) -> dict[str, Any]:
    """Return the figures of a summary.

    Raises
    ------
    ValueError
        For a text that is none.
    """
    figures = json.loads(text)
    if not isinstance(figures, dict):
        raise ValueError(f"{type(figures).__name__} in the place of figures")
    if figures.get("format") != _FORMAT:
        raise _ForeignSummaryError(figures)
    wrong = [name for name, kind in _EACH.items() if not isinstance(figures.get(name), kind)]
    if wrong:
        raise ValueError(f"without {', '.join(wrong)}")
    return figures


class Shot:
    """Results of a run.

    Attributes
    ----------
    folder : Path
        Folder that holds them.
    plot : ShotPlots
        Standard figures, such as ``shot.plot.velocity()``.
    frames : FrameSequence
        Meshes of gel and bodies by time, for pyvista.
    """

    def __init__(self, folder: str | Path) -> None:
        self.folder = Path(folder)
        self.plot = ShotPlots(self)
        self.frames = FrameSequence(self.folder)

    @classmethod
    def load(cls, folder: str | Path) -> Shot:
        """Read the results of a run.

        Raises
        ------
        GelfmuError
            If the folder holds no finished run, or a damaged summary.
        """
        shot = cls(folder)
        shot.summary  # noqa: B018 - refuses a folder without results
        return shot

    @functools.cached_property
    def summary(self) -> dict[str, Any]:
        """All of ``summary.json``, in SI units; the function `ballistic_gel.figures` has units and meanings."""
        path = self.folder / "summary.json"
        try:
            return _figures_in(path.read_text(encoding="utf-8"))
        except FileNotFoundError as error:
            remedy = "name the folder of a run that ended; gelfmu.jsonl in it tells the state"
            raise GelfmuError(f"{path}: found no summary of a run", remedy=remedy) from error
        except _ForeignSummaryError as error:
            remedy = "run its scene.toml, or pack the FMU, with this release"
            raise GelfmuError(f"{path}: found {error}: {remedy}", remedy=remedy) from error
        except (OSError, ValueError) as error:
            remedy = "expected the summary that gelfmu writes: run it again"
            raise GelfmuError(f"{path}: found a damaged summary ({error}), {remedy}", remedy=remedy) from error

    @property
    def tables(self) -> tuple[str, ...]:
        """Names of the tables that this run has, of history, by_depth, cavity, track, cracks and layers."""
        return tuple(name for name, file in _FILES.items() if (self.folder / file).is_file())

    @functools.cached_property
    def history(self) -> pd.DataFrame:
        """One row for each communication step: motion, force, energies; units end the names of the columns."""
        return self._table("history", "the run was not begun")

    @functools.cached_property
    def by_depth(self) -> pd.DataFrame:
        """Speed, force, energy given to the gel, yaw and side force, by depth of the nose."""
        return self._table("by_depth", _ONLY_DEEP)

    @functools.cached_property
    def cavity(self) -> pd.DataFrame:
        """Radius and diameter of the temporary cavity, by time and depth."""
        return self._table("cavity", _ONLY_DEEP)

    @functools.cached_property
    def track(self) -> pd.DataFrame:
        """Diameter of the permanent track, and energy given to the gel in each centimetre, by depth."""
        return self._table("track", _ONLY_DEEP)

    @functools.cached_property
    def cracks(self) -> pd.DataFrame:
        """Estimated total crack length of each slice of one centimetre, one row each; the last ends at the peak depth.

        Columns are ``depth_from_m`` and ``depth_to_m`` (faces of the slice), ``cavity_diameter_m`` (D, the widest over
        the run), ``tear_diameter_m`` (d, width of the projectile across its line of flight), ``energy_J`` given to the
        gel in the slice, and ``crack_length_m``, π max(0, D - d). D and the length are NaN where there was no cavity
        and down to the depth d, where the crater of the entry is.

        The simulation models no crack. The factor of 1 and d are assumed, and compared with no measured cracks.
        """
        return self._table("cracks", _ONLY_DEEP)

    @functools.cached_property
    def layers(self) -> pd.DataFrame:
        """Layers of the target front to back, and last the gel below them, one row each.

        Columns are ``layer`` (its name, ``gel`` in the last row), ``depth_from_m`` and ``depth_to_m`` (undeformed
        interfaces below the entry surface), ``density_kg_per_m3``, ``entry_speed_m_per_s`` (when the nose first passes
        the upper interface, NaN where it does not), ``energy_J`` given to the gel while the nose is between the
        interfaces, and ``energy_fraction``, its part of that of all rows.

        Without rows for a scene without layers, and for a projectile that goes less deep than its length.
        """
        if "layers" not in self.tables:
            return pd.DataFrame(columns=list(_LAYERS))
        return self._table("layers", _ONLY_DEEP)

    def _table(self, name: str, reason: str) -> pd.DataFrame:
        path = self.folder / _FILES[name]
        if not path.is_file():
            raise GelfmuError(f"{path}: this run has no such table: {reason}", remedy="Shot.tables lists its tables")
        try:
            # A layer may be called 1 or NA; only an empty cell has no value.
            return pd.read_csv(path, dtype={"layer": str}, keep_default_na=False, na_values=[""])
        except (OSError, ValueError) as error:
            remedy = "expected the table that gelfmu writes: run it again"
            raise GelfmuError(f"{path}: found a damaged table ({error}), {remedy}", remedy=remedy) from error

    @property
    def measured(self) -> pd.DataFrame:
        """Residuals, computed minus measured, one row for each curve that a table of a laboratory has.

        Columns are ``quantity``, ``column`` of the table, ``by`` (``time`` or ``depth``), ``unit``, ``points`` that
        are compared, those ``outside`` of the computed curve, ``rms`` and ``greatest`` (in that unit), ``greatest_at``
        (s or m), ``rms_percent`` and ``greatest_percent`` of the greatest measured value; NaN where nothing is
        compared. A run without a table has none, which is a `GelfmuError`.
        """
        found = self.summary.get("measured")
        if found is None:
            remedy = "run with measured=, or Shot.report(measured=)"
            raise GelfmuError(f"{self.folder}: this run was compared with no table: {remedy}", remedy=remedy)
        rows = [{**curve, **(curve["residual"] or {})} for curve in found["curves"]]
        return pd.DataFrame(rows, columns=_RESIDUALS)

    @property
    def completed(self) -> bool:
        """True if the run reached its end."""
        return bool(self.summary["completed"])

    @property
    def doubts(self) -> list[str]:
        """Reasons to doubt the figures."""
        return list(self.summary["doubts"])

    @property
    def digest(self) -> str:
        """Hash of the final state: equal digests mean equal bits."""
        return str(self.summary["digest"])

    def to_xarray(self) -> xarray.Dataset:
        """Return the tables as one data set, with units as attributes.

        Returns
        -------
        Dataset
            The history by ``time``, vectors of shape (time, axis); the table by depth by ``path_depth``;
            ``cavity_diameter`` of shape (cavity_time, cavity_depth), NaN where there is no cavity; the track by
            ``track_depth``, the cracks by ``slice_depth``, the depth of the middle of each slice; the layers by
            ``layer``, their names.
        """
        return to_dataset(self)

    def report(self, measured: str | Path | None = None) -> Path:
        """Make ``report.html`` from the files of the run, by ``gelfmu report``, and return its path.

        Parameters
        ----------
        measured : str or Path, optional
            Table of a laboratory, CSV: its curves are drawn over those of the run, and the residuals are told.

        Raises
        ------
        GelfmuError
            If the folder or the table is refused.
        """
        options = [] if measured is None else [f"--measured={measured}"]
        made = call_json(["report", str(self.folder), *options])
        self.__dict__.pop("summary", None)  # it holds the residuals now
        return Path(made["file"])

    def figures(self) -> dict[str, float]:
        """Return the key figures that this shot has, by caption with unit.

        The caption of the peak force names the window of its mean, that of a cavity that grew until the end says so.
        """
        found = (
            (f"{caption}{self._condition(key)}, {unit}", factor, self.summary.get(key))
            for key, caption, factor, unit in _FIGURES
        )
        return {caption: factor * value for caption, factor, value in found if value is not None}

    def _condition(self, key: str) -> str:
        """Return the condition on which a figure depends, as the end of its caption."""
        if key == "peak_force":
            return f", mean over {1e6 * self.summary['force_window']:.4g} µs"
        is_open = key == "greatest_cavity_diameter" and self.summary.get("cavity_still_opening")
        return ", still opening" if is_open else ""

    def __repr__(self) -> str:
        figures = "; ".join(f"{caption}: {value:.4g}" for caption, value in self.figures().items())
        return f"<Shot {self.summary['scene']} in {self.folder}: {figures}>"

    def _repr_html_(self) -> str:
        figures = {caption: f"{value:.4g}" for caption, value in self.figures().items()}
        figures |= {"ended by": self.summary["ended_by"], "digest": self.digest}
        figures |= {f"doubt {number}": doubt for number, doubt in enumerate(self.doubts, 1)}
        cells = "".join(
            f"<tr><th style='text-align:left'>{html.escape(caption)}</th><td>{html.escape(str(value))}</td></tr>"
            for caption, value in figures.items()
        )
        return f"<table><caption>{html.escape(self.summary['scene'])}</caption>{cells}</table>"
