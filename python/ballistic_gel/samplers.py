"""Samples of a sweep: full grids, Latin hypercubes and Sobol sequences."""

from __future__ import annotations

import itertools
import math
import numbers
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
import pandas as pd

from .errors import GelfmuError
from .values import Value


class Distribution(Protocol):
    """Distribution of one key."""

    def quantile(self, fraction: np.ndarray) -> np.ndarray:
        """Return the values below which these fractions lie."""


@dataclass(frozen=True)
class Uniform:
    """Uniform distribution between `low` and `high`, finite numbers."""

    low: float
    high: float

    def __post_init__(self) -> None:
        _check_figures(self)

    def quantile(self, fraction: np.ndarray) -> np.ndarray:
        """Return the values below which these fractions lie."""
        return self.low + (self.high - self.low) * fraction


@dataclass(frozen=True)
class Normal:
    """Normal distribution of a mean and a standard deviation, which is greater than 0."""

    mean: float
    deviation: float

    def __post_init__(self) -> None:
        _check_figures(self, "deviation")

    def quantile(self, fraction: np.ndarray) -> np.ndarray:
        """Return the values below which these fractions lie."""
        return np.asarray(import_scipy().stats.norm.ppf(fraction, self.mean, self.deviation))


@dataclass(frozen=True)
class LogNormal:
    """Log-normal distribution of a median and the standard deviation of the logarithm, both greater than 0."""

    median: float
    deviation: float

    def __post_init__(self) -> None:
        _check_figures(self, "median", "deviation")

    def quantile(self, fraction: np.ndarray) -> np.ndarray:
        """Return the values below which these fractions lie."""
        return np.asarray(import_scipy().stats.lognorm.ppf(fraction, self.deviation, scale=self.median))


class Sampler(Protocol):
    """Source of the rows of a sweep."""

    def table(self) -> pd.DataFrame:
        """Return one row for each shot, with a column for each key."""


@dataclass(frozen=True)
class Grid:
    """All combinations of the values of some keys; the last key changes fastest."""

    values: Mapping[str, Sequence[Value]]

    def table(self) -> pd.DataFrame:
        """Return one row for each combination."""
        for key, values in self.values.items():
            if isinstance(values, (str, Mapping)) or not hasattr(values, "__len__"):
                remedy = "a list of values, such as [1.0, 2.0]; a distribution needs a sampler"
                raise GelfmuError(f"{key}: found {values!r}, expected {remedy}", key=key, remedy=remedy)
        rows = list(itertools.product(*self.values.values()))
        return pd.DataFrame({key: pd.Series([row[place] for row in rows]) for place, key in enumerate(self.values)})


@dataclass(frozen=True)
class LatinHypercube:
    """Latin hypercube of `count` shots. Equal seeds give equal samples."""

    spreads: Mapping[str, Distribution]
    count: int
    seed: int = 0

    def table(self) -> pd.DataFrame:
        """Return one row for each sample."""
        _check_counts(self.count, self.seed)
        sampler = import_scipy().stats.qmc.LatinHypercube(len(self.spreads), rng=self.seed)
        return _spread(self.spreads, sampler.random(self.count))


@dataclass(frozen=True)
class Sobol:
    """Scrambled Sobol sequence of `count` shots, best a power of two. Equal seeds give equal samples."""

    spreads: Mapping[str, Distribution]
    count: int
    seed: int = 0

    def table(self) -> pd.DataFrame:
        """Return one row for each sample."""
        _check_counts(self.count, self.seed)
        sampler = import_scipy().stats.qmc.Sobol(len(self.spreads), rng=self.seed)
        return _spread(self.spreads, sampler.random(self.count))


def sample_table(samples: Mapping[str, Sequence[Value]] | pd.DataFrame | Sampler) -> pd.DataFrame:
    """Return the rows of a grid, a table or a sampler, numbered from 0."""
    if isinstance(samples, pd.DataFrame):
        return samples.reset_index(drop=True)
    if not isinstance(samples, Mapping) and not hasattr(samples, "table"):
        remedy = "a mapping of keys to values, a DataFrame, or a Grid, LatinHypercube or Sobol"
        raise GelfmuError(f"samples: found {type(samples).__name__}, expected {remedy}", key="samples", remedy=remedy)
    return (Grid(samples) if isinstance(samples, Mapping) else samples).table()


def is_count(value: Any, least: int) -> bool:
    """Return whether a value is a whole number that is not below another one."""
    return isinstance(value, numbers.Integral) and not isinstance(value, bool) and int(value) >= least


def _check_counts(count: Any, seed: Any) -> None:
    for name, value, least in (("count", count, 1), ("seed", seed, 0)):
        if not is_count(value, least):
            remedy = f"a whole number, {least} or more"
            raise GelfmuError(f"{name}: found {value!r}, expected {remedy}", key=name, remedy=remedy)


def _check_figures(distribution: Any, *positive: str) -> None:
    """Refuse figures of a distribution that are no finite numbers, or not positive where they must be."""
    for name, value in vars(distribution).items():
        is_number = isinstance(value, numbers.Real) and not isinstance(value, bool) and math.isfinite(value)
        if not is_number or (name in positive and value <= 0.0):
            remedy = f"a {'number greater than 0' if name in positive else 'finite number'}"
            raise GelfmuError(f"{name}: found {value!r}, expected {remedy}", key=name, remedy=remedy)


def _spread(spreads: Mapping[str, Distribution], fractions: np.ndarray) -> pd.DataFrame:
    columns = zip(spreads.items(), fractions.T, strict=True)
    return pd.DataFrame({key: spread.quantile(column) for (key, spread), column in columns})


def import_scipy() -> Any:
    """Return scipy.

    Raises
    ------
    GelfmuError
        If it is not installed.
    """
    try:
        import scipy.optimize
        import scipy.stats
    except ImportError as error:
        remedy = 'pip install "ballistic-gel[sweep]"'
        raise GelfmuError(f"found no scipy, which draws samples and fits: {remedy}", remedy=remedy) from error
    return scipy
