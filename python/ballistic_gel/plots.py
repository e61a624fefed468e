"""Standard figures of a shot, by matplotlib. Colours are those of Okabe and Ito, which the colour-blind can tell."""

from __future__ import annotations

import io
import itertools
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from .shot import Shot

BLUE, ORANGE, GREEN, PURPLE = "#0072B2", "#D55E00", "#009E73", "#CC79A7"
COLOURS = (BLUE, ORANGE, GREEN, PURPLE, "#E69F00", "#56B4E9", "#000000", "#999999")
# Parts of the energy that are no loss, and balances of the books.
_KEPT = ("kinetic", "projectile", "elastic", "imbalance")
# Curves of the energy ledger that stay below this part of the whole are left out.
_VISIBLE = 1e-2


class ShotPlots:
    """Figures of one shot. Each draws into `ax`, or into a new figure, and returns the axes.

    Examples
    --------
    >>> ax = shot.plot.velocity()
    >>> other.plot.velocity(ax=ax, label="other")
    """

    def __init__(self, shot: Shot) -> None:
        self._shot = shot

    def velocity(self, ax: Axes | None = None, *, label: str | None = None) -> Axes:
        """Draw the speed of the projectile by time."""
        history = self._shot.history
        speed = np.linalg.norm(history[[f"velocity_{axis}_m_per_s" for axis in "xyz"]], axis=1)
        return _line(ax, 1e3 * history["time_s"], speed, "time, ms", "speed, m/s", label)

    def velocity_by_depth(self, ax: Axes | None = None, *, label: str | None = None) -> Axes:
        """Draw the speed of the projectile by the depth of its nose."""
        table = self._shot.by_depth
        return _line(ax, 1e3 * table["depth_m"], table["velocity_m_per_s"], "depth, mm", "speed, m/s", label)

    def force(self, ax: Axes | None = None, *, label: str | None = None) -> Axes:
        """Draw the force on the projectile by depth, means over 4 mm; by time for a shot that has no table by depth."""
        if "by_depth" in self._shot.tables:
            table = self._shot.by_depth
            return _line(ax, 1e3 * table["depth_m"], table["force_N"], "depth, mm", "force, N", label)
        history = self._shot.history
        force = np.linalg.norm(history[[f"force_{axis}_N" for axis in "xyz"]], axis=1)
        return _line(ax, 1e3 * history["time_s"], force, "time, ms", "force, N", label)

    def yaw(self, ax: Axes | None = None, *, label: str | None = None) -> Axes:
        """Draw the angle between axis and velocity of the projectile by depth."""
        table = self._shot.by_depth
        return _line(ax, 1e3 * table["depth_m"], np.degrees(table["yaw_rad"]), "depth, mm", "yaw, °", label)

    def energy_per_cm(self, ax: Axes | None = None, *, label: str | None = None) -> Axes:
        """Draw the energy given to the gel in each centimetre by depth."""
        energy = np.asarray(self._shot.summary["energy_per_centimetre"] or [], dtype=float)
        if not len(energy):
            self._shot.track  # noqa: B018 - says why there is none
        ax = new_axes(ax)
        ax.bar(10.0 * np.arange(len(energy)), energy, width=10.0, align="edge", color=BLUE, edgecolor="w", label=label)
        return _label(ax, "depth, mm", "energy per centimetre, J", label)

    def wound_profile(self, ax: Axes | None = None) -> Axes:
        """Draw the temporary cavity, its greatest diameter at each depth, and the permanent track."""
        cavity, track = self._shot.cavity, self._shot.track
        widest = cavity.groupby("depth_m")["radius_m"].max()
        ax = new_axes(ax)
        for depth, radius, colour, name in (
            (widest.index.to_numpy(), widest.to_numpy(), BLUE, "temporary cavity"),
            (track["depth_m"], track["track_diameter_m"] / 2, ORANGE, "permanent track"),
        ):
            depth, radius = 1e3 * np.asarray(depth), 1e3 * np.asarray(radius)
            ax.fill_between(depth, -radius, radius, color=colour, alpha=0.5, linewidth=0.0, label=name)
        ax.set_aspect("equal", adjustable="datalim")
        return _label(ax, "depth, mm", "radius, mm", "wound profile")

    def energy(self, ax: Axes | None = None) -> Axes:
        """Draw the energy ledger by time: projectile, motion of the gel, elastic energy, and each account of losses.

        The curves add up to the initial energy. An account below zero gave energy, and those below 1 % are left out.
        """
        history = self._shot.history
        columns = {
            name.removeprefix("energy_").removesuffix("_J"): name for name in map(str, history) if name.endswith("_J")
        }
        curves = {"projectile": history["energy_projectile_J"], "elastic": history["energy_elastic_J"]}
        curves["motion of the gel"] = history["energy_kinetic_J"] - history["energy_projectile_J"]
        curves |= {name.replace("_", " "): -history[columns[name]] for name in columns if name not in _KEPT}
        ax = new_axes(ax)
        whole = float(history["energy_kinetic_J"].abs().max())
        colours = itertools.cycle(COLOURS)
        for name, energy in curves.items():
            if energy.abs().max() > _VISIBLE * whole:
                ax.plot(1e3 * history["time_s"], energy, color=next(colours), label=name)
        return _label(ax, "time, ms", "energy, J", "ledger")


def new_axes(ax: Axes | None, size: tuple[float, float] | None = None) -> Axes:
    """Return axes as they are, or those of a new figure, of a size in inches."""
    if ax is not None:
        return ax
    import matplotlib.pyplot as plt

    made: Axes = plt.subplots(figsize=size, layout="constrained")[1]
    made.set_prop_cycle(color=list(COLOURS))
    return made


def svg_of(figure: Any) -> bytes:
    """Return a figure as SVG, the same bytes each time, and close it."""
    import matplotlib.pyplot as plt

    picture = io.BytesIO()
    with plt.rc_context({"svg.hashsalt": "ballistic-gel", "svg.fonttype": "none"}):
        figure.savefig(picture, format="svg", metadata={"Date": None})
    plt.close(figure)
    return picture.getvalue()


def _line(ax: Axes | None, x: object, y: object, x_label: str, y_label: str, name: str | None) -> Axes:
    ax = new_axes(ax)
    ax.plot(np.asarray(x), np.asarray(y), label=name)
    return _label(ax, x_label, y_label, name)


def _label(ax: Axes, x_label: str, y_label: str, name: str | None) -> Axes:
    """Name the axes, and draw a legend if the curves have names."""
    ax.set_xlabel(x_label)
    ax.set_ylabel(y_label)
    ax.spines[["top", "right"]].set_visible(False)
    if name is not None:
        ax.legend(frameon=False)
    return ax
