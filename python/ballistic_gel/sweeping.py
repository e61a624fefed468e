"""Sweeps: many shots of one scene, as a table that a killed sweep resumes."""

from __future__ import annotations

import json
import os
import sys
import threading
import warnings
from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import BrokenExecutor, Future, as_completed
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any, Literal

import pandas as pd

from .binary import binary_stamp
from .engines import Submit, open_engine
from .errors import CrashWarning, GelfmuError
from .fmu import FmuInstance, pack
from .samplers import Sampler, sample_table
from .scene import Scene, as_scene
from .tasks import CRASHED, REFUSED, Row, ShotTask, failed_row
from .values import Value


def sweep(
    scene: Scene | str | Path,
    samples: Mapping[str, Sequence[Value]] | pd.DataFrame | Sampler,
    out: str | Path,
    *,
    client: Any = None,
    workers: int | None = None,
    runs: Literal["command", "fmu"] = "command",
    fidelity: str | int | None = None,
    share: str | None = None,
    keep: bool = False,
    progress: bool = True,
) -> pd.DataFrame:
    """Run a scene once for each row of a table of samples.

    The rows do not depend on the number of workers, the engine or the machine. Each finished shot is kept in
    ``out/rows``: the same call after a kill runs the others only. A shot that fails is a row with its reason.

    Parameters
    ----------
    scene : Scene, str or Path
        Scene, the name of a built-in one, or the path of a file that ends with ``.toml``.
    samples : mapping, DataFrame or sampler
        Keys and their values, of which all combinations are run; a table with a column for each key; or a `Grid`,
        `LatinHypercube` or `Sobol`. Keys are those of the scene, also of a component, such as
        ``projectile.velocity[3]``; with ``runs="fmu"`` they are parameters of the FMU.
    out : str or Path
        Folder for the rows, ``results.csv`` and, with pyarrow, ``results.parquet``; wall-clock figures are in
        ``clock.csv``, so that the results are the same bits each time.
    client : distributed.Client, the module ray, or concurrent.futures.Executor, optional
        Where the shots run; this machine if absent.
    workers : int, optional
        Number of local workers; all cores if absent.
    runs : {"command", "fmu"}
        One process of `gelfmu` for each shot, or one instance of the FMU in each worker, which is reset between shots.
        The latter starts Python processes: guard the main part of a script by ``if __name__ == "__main__"``.
    fidelity : str or int, optional
        Level of accuracy.
    share : str, optional
        Part of the rows to run, such as ``"2/8"``: every eighth from the second on. Only the last share to finish
        finds all rows, and writes the tables.
    keep : bool
        Keep the folder of each shot, without frames and report, in ``out/shots``; the column ``folder`` names it, and
        `Shot.load` reads it. A finished shot without its folder is run again. All workers must share `out`.
    progress : bool
        Show a bar in notebooks and terminals.

    Returns
    -------
    DataFrame
        One row for each sample that has a result, in the order of the samples: its keys, ``status`` (``completed``,
        ``stopped``, ``refused`` or ``crashed``), ``reason``, and the figures of the summary in SI units, but for its
        tables: components of vectors, fragments and sensors are ``final_velocity[3]`` and ``sensors[1].dent.depth``.

    Raises
    ------
    GelfmuError
        For an unknown key, or if no further shot can be run: a worker has another `gelfmu`, or died.

    Warns
    -----
    CrashWarning
        If the `gelfmu` of a shot died or could not write: such a row is not kept, and is run again by the same call.
    """
    scene = as_scene(scene)
    table, store = sample_table(samples), RowStore(Path(out))
    tasks = _tasks_of(scene, table, store.folder, runs, fidelity, keep)
    keys = [task.key() for task in tasks]
    wanted = dict(zip(keys, tasks, strict=True))
    if share is not None:
        number, count = _parse_share(share)
        wanted = dict(list(zip(keys, tasks, strict=True))[number - 1 :: count])
    rows = {key: row for key in dict.fromkeys(keys) if (row := store.read(key)) is not None}
    if keep:
        for key in [key for key in wanted if key in rows and not store.has_shot(key, rows)]:
            store.forget(key)
            del rows[key]
    missing = {key: task for key, task in wanted.items() if key not in rows}
    if missing:
        rows |= _run_all(missing, store, open_engine(client, workers, runs == "fmu"), progress)
    # Other shares may have ended in the meantime.
    rows |= {key: row for key in set(keys) - set(rows) if (row := store.read(key)) is not None}
    made = _table_of(table, keys, rows)
    if keep:
        made["folder"] = [store.shot_of(keys[place], rows) for place in made.index]
    if len(made) == len(table):
        store.write_tables(made, keys, rows)
    crashed = made[made["status"] == CRASHED]
    if len(crashed):
        counted = f"{len(crashed)} of {len(made)} shots crashed, and are run again by the same call"
        warnings.warn(f"{counted}: {crashed['reason'].iloc[0]}", CrashWarning, stacklevel=2)
    return made


def _run_all(
    tasks: Mapping[str, ShotTask],
    store: RowStore,
    engine: AbstractContextManager[Submit],
    progress: bool,
) -> dict[str, Row]:
    """Run shots and return their rows, each of which is kept once it is there."""
    rows: dict[str, Row] = {}
    shots: dict[Future[Row], str] = {}
    try:
        with engine as submit:
            try:
                for key, task in tasks.items():
                    shots[submit(task)] = key
                for shot in _shown(as_completed(shots), len(shots), progress):
                    store.write(shots[shot], rows.setdefault(shots[shot], _row_in(shot)))
            finally:
                for shot in shots:
                    shot.cancel()
    finally:
        # What ended after an interrupt is kept, too.
        for shot, key in shots.items():
            if key not in rows and shot.done() and not shot.cancelled() and shot.exception() is None:
                store.write(key, shot.result())
    return rows


def _row_in(shot: Future[Row]) -> Row:
    """Return the row of a shot that ended.

    Raises
    ------
    GelfmuError
        If no further shot can be run: a worker has another `gelfmu`, or died.
    """
    error = shot.exception()
    if error is None:
        return shot.result()
    if isinstance(error, GelfmuError):
        raise error
    if isinstance(error, BrokenExecutor):
        remedy = "the same call runs what is missing"
        raise GelfmuError(f"the process of a worker died ({error}): {remedy}", remedy=remedy) from error
    return failed_row(CRASHED, str(error) or type(error).__name__)


# Folder of the shots that are kept.
SHOTS = "shots"


class RowStore:
    """Rows of a sweep in its folder, one file for each."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder.resolve()
        self._rows = self.folder / "rows"
        self._rows.mkdir(parents=True, exist_ok=True)

    def read(self, key: str) -> Row | None:
        """Return a row, or None if there is no whole one."""
        try:
            row: Row = json.loads((self._rows / f"{key}.json").read_text(encoding="utf-8"))
            return row
        except (OSError, ValueError):
            return None

    def has_shot(self, key: str, rows: Mapping[str, Row]) -> bool:
        """Return whether the folder of a shot is there, if it has one."""
        name = self.shot_of(key, rows)
        return name is None or (self.folder / name).is_dir()

    @staticmethod
    def shot_of(key: str, rows: Mapping[str, Row]) -> str | None:
        """Return the folder of a shot, relative to that of the sweep; one that was refused or crashed has none."""
        return None if rows[key]["status"] in (REFUSED, CRASHED) else f"{SHOTS}/{key}"

    def write(self, key: str, row: Row) -> None:
        """Keep a row, unless the process of its shot died."""
        if row["status"] != CRASHED:
            write_whole(self._rows / f"{key}.json", json.dumps(row).encode())

    def forget(self, key: str) -> None:
        """Remove a row, whose shot is to be run again."""
        (self._rows / f"{key}.json").unlink(missing_ok=True)

    def write_tables(self, table: pd.DataFrame, keys: Sequence[str], rows: Mapping[str, Row]) -> None:
        """Write the results, and the figures of the clock apart."""
        write_whole(self.folder / "results.csv", table.to_csv(index_label="index").encode())
        clock = pd.DataFrame([rows[key].get("clock", {}) for key in keys])
        write_whole(self.folder / "clock.csv", clock.to_csv(index_label="index").encode())
        try:
            import pyarrow  # noqa: F401
        except ImportError:
            return
        write_whole(self.folder / "results.parquet", table.to_parquet(engine="pyarrow"))


def write_whole(path: Path, content: bytes) -> None:
    """Write a file so that it is there as a whole or not at all."""
    part = path.with_name(f".{path.name}.{os.getpid()}.{threading.get_ident()}")
    part.write_bytes(content)
    part.replace(path)


def _tasks_of(
    scene: Scene, table: pd.DataFrame, folder: Path, runs: str, fidelity: str | int | None, keep: bool
) -> list[ShotTask]:
    """Return the task of each row, after a check of the keys."""
    stamp, options, fmu = binary_stamp(), "" if fidelity is None else f"--fidelity={fidelity}", None
    if runs == "fmu":
        level = {} if fidelity is None else {"scene.fidelity": fidelity}
        scene, options = scene.with_values({"output.frames": 0, "output.report": False, **level}), ""
        fmu = folder / f"{scene.digest(stamp)}.fmu"
        fmu = fmu if fmu.exists() else pack(scene, fmu)
        with FmuInstance(fmu) as instance:
            instance.check_names(map(str, table.columns))
    records: list[dict[str, Any]] = [
        dict(zip(map(str, table), row, strict=True)) for row in table.itertuples(index=False)
    ]
    if fmu is None:
        for record in records:
            scene.with_values(record)  # refuses an unknown key before the first shot
    return [ShotTask(scene, record, stamp, options, fmu, folder / SHOTS if keep else None) for record in records]


def _table_of(table: pd.DataFrame, keys: Sequence[str], rows: Mapping[str, Row]) -> pd.DataFrame:
    """Return the samples that have a row, beside status, reason and figures."""
    found = [place for place, key in enumerate(keys) if key in rows]
    results = [rows[keys[place]] for place in found]
    records = [{"status": row["status"], "reason": row["reason"], **row["figures"]} for row in results]
    figures = pd.DataFrame(records) if records else pd.DataFrame(columns=["status", "reason"])
    figures.index = pd.Index(found)
    return pd.concat([table.iloc[found], figures], axis=1)


def _parse_share(share: str) -> list[int]:
    number, slash, count = share.partition("/")
    if slash and number.isdecimal() and count.isdecimal() and 1 <= int(number) <= int(count):
        return [int(number), int(count)]
    remedy = "number and count of the shares, such as 2/8"
    raise GelfmuError(f"share {share}: found no share, expected {remedy}", remedy=remedy)


def _shown(shots: Iterable[Any], count: int, progress: bool) -> Iterable[Any]:
    if not progress or not ("ipykernel" in sys.modules or sys.stderr.isatty()):
        return shots
    from tqdm.auto import tqdm

    bar: Iterable[Any] = tqdm(shots, total=count, desc="shots", unit="shot")
    return bar
