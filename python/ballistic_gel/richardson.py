"""Richardson extrapolation to cells of no size, from three meshes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from .samplers import import_scipy

# Orders that can be trusted: below, the limit is mostly extrapolation, above, mostly chance.
_ORDERS = (0.5, 6.0)
# Greatest distance of the finest value from the limit, relative to the scale.
_LARGEST_REACH = 0.1


class NoLimit(ValueError):
    """Three values without a limit that can be trusted; the message says why."""


@dataclass(frozen=True)
class RefinementLimit:
    """Limit of refinement.

    Attributes
    ----------
    value : float
        Extrapolated value f₀.
    order : float
        Observed order p.
    scale : float
        Value that errors are relative to.
    reach : float
        Distance of the finest value from the limit, relative to the scale: a bound on the error of the limit.
    """

    value: float
    order: float
    scale: float
    reach: float


def extrapolate_limit(sizes: Sequence[float], values: Sequence[float], scale: float | None = None) -> RefinementLimit:
    """Return f₀ of f(h) = f₀ + C hᵖ through three values.

    Parameters
    ----------
    sizes, values : sequence of 3 floats
        Sizes h of the cells, the finest last, and the values there.
    scale : float, optional
        Value that errors are relative to; |f₀| if absent.

    Raises
    ------
    NoLimit
        If the values are not monotone, have no order from 0.5 to 6, or end far from their limit.
    """
    a, b, c = sizes
    fa, fb, fc = values
    if not (fa - fb) * (fb - fc) > 0.0:
        raise NoLimit("not monotone")
    ratio = (fa - fb) / (fb - fc)

    def misfit(order: float) -> float:
        return float((a**order - b**order) / (b**order - c**order) - ratio)

    if misfit(_ORDERS[0]) * misfit(_ORDERS[1]) > 0.0:
        raise NoLimit(f"of no order from {_ORDERS[0]} to {_ORDERS[1]:.0f}")
    order = float(import_scipy().optimize.brentq(misfit, *_ORDERS, xtol=1e-13))
    limit = fc - (fb - fc) / (b**order - c**order) * c**order
    scale = abs(limit) if scale is None else scale
    if scale == 0.0:
        raise NoLimit("not converged: their limit is 0")
    reach = abs(fc - limit) / scale
    if reach > _LARGEST_REACH:
        raise NoLimit(f"not converged: the finest is {100.0 * reach:.0f} % away")
    return RefinementLimit(limit, order, scale, reach)
