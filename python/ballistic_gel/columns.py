"""Columns of the tables of a run: their units, and a data set with coordinates."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pandas as pd

if TYPE_CHECKING:
    import xarray

    from .shot import Shot

# Endings of column names, the longest first, and the unit that each stands for.
UNITS = {
    "_m_per_s": "m/s",
    "_rad_per_s": "rad/s",
    "_kg_per_m3": "kg/m3",
    "_N_m_s": "N m s",
    "_N_s": "N s",
    "_rad": "rad",
    "_m2": "m2",
    "_s": "s",
    "_m": "m",
    "_N": "N",
    "_J": "J",
    "_Pa": "Pa",
}
_VECTOR = ("x", "y", "z")
_QUATERNION = ("w", "x", "y", "z")


def split_unit(column: str) -> tuple[str, str]:
    """Split the name of a column into quantity and unit; a quantity without one has the unit 1."""
    for ending, unit in UNITS.items():
        if column.endswith(ending):
            return column.removesuffix(ending), unit
    return column, "1"


def stack_components(table: pd.DataFrame, dimension: str) -> dict[str, Any]:
    """Return the columns of a table as variables of xarray; components of one quantity become an axis.

    Parameters
    ----------
    table : DataFrame
        Table of a run.
    dimension : str
        Name of the dimension along its rows.
    """
    named = {quantity: (column, unit) for column in table.columns for quantity, unit in [split_unit(column)]}
    variables: dict[str, Any] = {}
    for quantity, (column, unit) in named.items():
        base, _, letter = quantity.rpartition("_")
        for axis, letters in (("quaternion", _QUATERNION), ("axis", _VECTOR)):
            if letter in letters and all(f"{base}_{each}" in named for each in letters):
                columns = [named[f"{base}_{each}"][0] for each in letters]
                variables[base] = ((dimension, axis), table[columns].to_numpy(), {"units": unit})
                break
        else:
            variables[quantity] = ((dimension,), table[column].to_numpy(), {"units": unit})
    return variables


def to_dataset(shot: Shot) -> xarray.Dataset:
    """Return the tables of a shot as one data set; see `Shot.to_xarray`."""
    import xarray

    history = stack_components(shot.history, "time")
    coordinates = {"time": history.pop("time"), "axis": list(_VECTOR), "quaternion": list(_QUATERNION)}
    data = xarray.Dataset(history, coordinates, {"scene": shot.summary["scene"], "digest": shot.summary["digest"]})
    if "by_depth" in shot.tables:
        by_depth = stack_components(shot.by_depth, "path_depth")
        data = data.assign_coords(path_depth=by_depth.pop("depth"))
        data = data.assign({f"{name}_by_depth": variable for name, variable in by_depth.items()})
    if "cavity" in shot.tables:
        grid = shot.cavity.pivot(index="time_s", columns="depth_m", values="diameter_m")
        places = {"cavity_time": grid.index.to_numpy(), "cavity_depth": grid.columns.to_numpy()}
        variable = xarray.DataArray(grid.to_numpy(), places, tuple(places), attrs={"units": "m"})
        data = data.assign(cavity_diameter=variable)
    if "track" in shot.tables:
        track = stack_components(shot.track, "track_depth")
        data = data.assign_coords(track_depth=track.pop("depth")).assign(track)
    if "cracks" in shot.tables:
        middle = shot.cracks[["depth_from_m", "depth_to_m"]].mean(axis="columns").to_numpy()
        cracks = stack_components(shot.cracks, "slice_depth")
        data = data.assign_coords(slice_depth=("slice_depth", middle, {"units": "m"}))
        data = data.assign({f"{name}_by_slice": variable for name, variable in cracks.items()})
    if "layers" in shot.tables:
        layers = stack_components(shot.layers, "layer")
        data = data.assign_coords(layer=layers.pop("layer")[1].tolist())
        data = data.assign({f"{name}_by_layer": variable for name, variable in layers.items()})
    return data
