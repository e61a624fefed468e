"""Sweeps: many shots of one scene, as a table that a killed sweep resumes."""

from __future__ import annotations

import json
import shutil
import tempfile
import warnings
from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import BrokenExecutor, Future, as_completed
from contextlib import AbstractContextManager, contextmanager, nullcontext, suppress
from pathlib import Path
from typing import Any, Literal

import pandas as pd

from .batching import open_batch
from .binary import binary_stamp
from .cartridges import cartridge_scenes
from .engines import Submit, open_engine
from .errors import CrashWarning, GelfmuError
from .fmu import FmuInstance, pack
from .folder import SweepFolder
from .progress import ProgressLines, shows_bars
from .samplers import Sampler, is_count, sample_table
from .scene import Scene, as_scene
from .tasks import CRASHED, REFUSED, Row, ShotTask, failed_row, is_row
from .values import Value, toml_text


def sweep(
    scene: Scene | str | Path | None,
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
    scene : Scene, str or Path, or None
        Scene, the name of a built-in one, or the path of a file that ends with ``.toml``; None for cartridges.
    samples : mapping, DataFrame or sampler
        Keys and their values, of which all combinations are run; a table with a column for each key; or a `Grid`,
        `LatinHypercube` or `Sobol`. Keys are those of the scene, also of a component, such as
        ``projectile.velocity[3]``; with ``runs="fmu"`` they are parameters of the FMU. Cartridges have a column
        ``projectile``, and may have ``speed``, ``yaw``, ``roll``, ``block`` and ``gel``: each row makes its own scene
        with these arguments, as `Scene.new_shot`, and an empty cell stands for the usual value.
    out : str or Path
        New or empty folder, or that of an earlier sweep, for the rows, ``results.csv`` and, with pyarrow,
        ``results.parquet``; wall-clock figures are in ``clock.csv``, so that the results are the same bits each time.
        Its manifest ``gelfmu.jsonl`` lists the files, and only those are ever replaced.
    client : distributed.Client, the module ray, or concurrent.futures.Executor, optional
        Where the shots run; this machine if absent.
    workers : int, optional
        Number of local workers; all cores if absent or 0.
    runs : {"command", "fmu"}
        One process of `gelfmu` for each shot, or one instance of the FMU in each worker, which is reset between shots.
        The latter starts Python processes: guard the main part of a script by ``if __name__ == "__main__"``.
    fidelity : str or int, optional
        Level of accuracy. Without a `client`, and if nothing is kept, shots at ``"instant"`` run in one process, with
        at most 100 communication steps each.
    share : str, optional
        Part of the rows to run, such as ``"2/8"``: every eighth from the second on. Only the last share to finish
        finds all rows, and writes the tables.
    keep : bool
        Keep the folder of each shot, without frames and report, in ``out/shots``; the column ``folder`` names it, and
        `Shot.load` reads it. A finished shot without its folder is run again. All workers must share `out`.
    progress : bool
        Show a bar in notebooks and terminals, elsewhere a line on standard error at most every 30 s.

    Returns
    -------
    DataFrame
        One row for each sample that has a result, in the order of the samples: its keys, ``status`` (``completed``,
        ``stopped``, ``refused`` or ``crashed``), ``reason``, and the figures of the summary in SI units, but for its
        tables: components of vectors, fragments and sensors are ``final_velocity[3]`` and ``sensors[1].dent.depth``.

    Raises
    ------
    GelfmuError
        For an unknown key, a row that makes no scene, a folder that no sweep has made, a foreign file with the name of
        a result, or if no further shot can be run: a worker has another `gelfmu`, or died.
    KeyboardInterrupt
        If it was interrupted; its message tells how many shots are kept.

    Warns
    -----
    CrashWarning
        If the `gelfmu` of a shot died or could not write: such a row is not kept, and is run again by the same call.
    DoubtWarning
        If the block of a cartridge is too small for its shot, or a level of it cannot be run.
    """
    scene = None if scene is None else as_scene(scene)
    table, folder = sample_table(samples), SweepFolder(out)
    _refuse_settings(runs, workers)
    _refuse_cartridges(scene, table, runs)
    with nullcontext() if scene is None or runs != "fmu" else _packed(scene, folder, fidelity, client) as fmu:
        is_batch = client is None and runs == "command" and not keep and str(fidelity) in INSTANT
        tasks = _tasks_of(scene, table, folder, fmu, fidelity, keep, is_batch)
        engine = open_batch(workers) if is_batch else open_engine(client, workers, runs == "fmu")
        return _sweep_tasks(tasks, table, folder, engine, share, progress)


def run_scenes(
    scenes: Sequence[Scene],
    out: str | Path,
    *,
    labels: pd.DataFrame | None = None,
    clock: bool = False,
    keep: bool = False,
    client: Any = None,
    workers: int | None = None,
    share: str | None = None,
    progress: bool = True,
) -> pd.DataFrame:
    """Run some scenes, each by its own, and return a table like that of `sweep`.

    Parameters
    ----------
    scenes : sequence of Scene
        Scenes with their replaced keys.
    out : str or Path
        Folder, as of `sweep`. Finished shots of other scenes in it stay.
    labels : DataFrame, optional
        Columns that come before the figures, one row for each scene.
    clock : bool
        Add the figures that depend on the machine, such as ``cpu_seconds``.
    keep : bool
        Keep the folder of each shot, as `sweep`.
    client, workers, share, progress
        As of `sweep`.

    Returns
    -------
    DataFrame
        One row for each scene that has a result: ``labels``, ``status``, ``reason`` and the figures. A label takes
        the place of a figure of its name; ``status`` and ``reason`` are no names of labels.

    Raises
    ------
    GelfmuError
        For labels of another number, and as `sweep`.
    """
    _refuse_settings("command", workers)
    folder, stamp = SweepFolder(out), binary_stamp()
    kept = folder.path / SHOTS if keep else None
    tasks = [ShotTask(scene, {}, stamp, folder=kept) for scene in scenes]
    table = pd.DataFrame(index=range(len(tasks))) if labels is None else labels.reset_index(drop=True)
    if len(table) != len(tasks):
        remedy = f"{len(tasks)}, one for each scene"
        raise GelfmuError(f"labels: found {len(table)} rows, expected {remedy}", key="labels", remedy=remedy)
    return _sweep_tasks(tasks, table, folder, open_engine(client, workers, False), share, progress, clock)


def _sweep_tasks(
    tasks: Sequence[ShotTask],
    table: pd.DataFrame,
    folder: SweepFolder,
    engine: AbstractContextManager[Submit],
    share: str | None,
    progress: bool,
    clock: bool = False,
) -> pd.DataFrame:
    """Run what is missing of some shots, and return them beside the columns of a table; with their times if asked."""
    number, count = (1, 1) if share is None else _parse_share(share)
    keys, keep = [task.key() for task in tasks], any(task.folder for task in tasks)
    store = RowStore(folder, keys)
    wanted = dict(list(zip(keys, tasks, strict=True))[number - 1 :: count])
    rows = {key: row for key in dict.fromkeys(keys) if (row := store.read(key)) is not None}
    if keep:
        for key in [key for key in wanted if key in rows and not store.has_shot(key, rows)]:
            store.forget(key)
            del rows[key]
    missing = {key: task for key, task in wanted.items() if key not in rows}
    if missing:
        rows |= _run_or_tell(missing, len(wanted), store, engine, progress)
    # Other shares may have ended in the meantime.
    rows |= {key: row for key in set(keys) - set(rows) if (row := store.read(key)) is not None}
    made = _table_of(table, keys, rows)
    if keep:
        made["folder"] = [store.shot_of(keys[place], rows) for place in made.index]
    if len(made) == len(table):
        store.write_tables(made, keys, rows)
    if clock:
        times = pd.DataFrame([rows[keys[place]].get("clock", {}) for place in made.index], made.index)
        made = pd.concat([made, times], axis=1)
    crashed = made[made["status"] == CRASHED]
    if len(crashed):
        counted = f"{len(crashed)} of {len(made)} shots crashed, and are run again by the same call"
        warnings.warn(f"{counted}: {crashed['reason'].iloc[0]}", CrashWarning, stacklevel=3)
    return made


def _run_or_tell(
    tasks: Mapping[str, ShotTask], wanted: int, store: RowStore, engine: AbstractContextManager[Submit], progress: bool
) -> dict[str, Row]:
    """Run the shots that are missing of those that are wanted; an interrupt tells how many are kept."""
    store.begin(tasks)
    try:
        return _run_all(tasks, store, engine, progress)
    except KeyboardInterrupt:
        store.end("interrupted")
        kept = wanted - sum(store.read(key) is None for key in tasks)
        told = f"{kept} of {wanted} shots are kept in {store.folder.path}: the same call goes on from there"
        # How the engine waited is of no use to who interrupts it.
        raise KeyboardInterrupt(told) from None
    except BaseException:
        store.end("failed")
        raise


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
                    row = _row_in(shot)
                    store.write(shots[shot], row)
                    rows[shots[shot]] = row
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


# Names of the level of the reduced model.
INSTANT = ("instant", "5")
# Folder of the shots that are kept.
SHOTS = "shots"


class RowStore:
    """Rows of a sweep in its folder, one file for each.

    Parameters
    ----------
    folder : SweepFolder
        Folder of the sweep, which is claimed.
    keys : sequence of str
        Names of all rows.
    """

    def __init__(self, folder: SweepFolder, keys: Sequence[str]) -> None:
        self.folder = folder
        folder.claim([*map(_file_of, keys), *_TABLES])

    def read(self, key: str) -> Row | None:
        """Return a row, or None if there is no whole one, whose shot is to be run again."""
        try:
            row = json.loads((self.folder.path / _file_of(key)).read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return None
        return row if is_row(row) else None

    def has_shot(self, key: str, rows: Mapping[str, Row]) -> bool:
        """Return whether the folder of a shot is there, if it has one."""
        name = self.shot_of(key, rows)
        return name is None or (self.folder.path / name).is_dir()

    @staticmethod
    def shot_of(key: str, rows: Mapping[str, Row]) -> str | None:
        """Return the folder of a shot, relative to that of the sweep; one that was refused or crashed has none."""
        return None if rows[key]["status"] in (REFUSED, CRASHED) else f"{SHOTS}/{key}"

    def begin(self, keys: Iterable[str]) -> None:
        """Begin to write rows."""
        self.folder.list_files(map(_file_of, keys))
        self.folder.mark("running")

    def end(self, state: str) -> None:
        """Record how the sweep ended early, if that can be written."""
        with suppress(GelfmuError):
            self.folder.mark(state)

    def write(self, key: str, row: Row) -> None:
        """Keep a row, unless the process of its shot died."""
        if row["status"] != CRASHED:
            self.folder.write(_file_of(key), json.dumps(row).encode())

    def forget(self, key: str) -> None:
        """Remove a row, whose shot is to be run again."""
        (self.folder.path / _file_of(key)).unlink(missing_ok=True)

    def write_tables(self, table: pd.DataFrame, keys: Sequence[str], rows: Mapping[str, Row]) -> None:
        """Write the results, and the figures of the clock apart."""
        clock = pd.DataFrame([rows[key].get("clock", {}) for key in keys])
        texts = [made.to_csv(index_label="index").encode() for made in (table, clock)]
        with suppress(ImportError):
            import pyarrow  # noqa: F401

            # A column of numbers and texts, such as speeds with and without a unit, is one of texts there.
            mixed = [name for name in table if table[name].dropna().map(type).nunique() > 1]
            columns = {str(name): table[name].map(str, na_action="ignore") for name in mixed}
            texts.append(table.assign(**columns).to_parquet(engine="pyarrow"))
        self.folder.publish(dict(zip(_TABLES, texts, strict=False)))


_TABLES = ("results.csv", "clock.csv", "results.parquet")


def _file_of(key: str) -> str:
    return f"rows/{key}.json"


@contextmanager
def _packed(scene: Scene, folder: SweepFolder, fidelity: str | int | None, client: Any) -> Iterator[Path]:
    """Pack the FMU into a new folder that only this user may enter, and remove it in the end.

    The folder is one of this machine; for a client, whose workers may be elsewhere, it is in that of the sweep.
    """
    folder.claim()
    place = tempfile.mkdtemp(prefix=".fmu-", dir=None if client is None else folder.path)
    try:
        yield pack(_scene_of_fmu(scene, fidelity), Path(place) / "sweep.fmu")
    finally:
        shutil.rmtree(place, ignore_errors=True)


def _scene_of_fmu(scene: Scene, fidelity: str | int | None) -> Scene:
    level = {} if fidelity is None else {"scene.fidelity": fidelity}
    return scene.with_values({"output.frames": 0, "output.report": False, **level})


def _tasks_of(
    scene: Scene | None,
    table: pd.DataFrame,
    folder: SweepFolder,
    fmu: Path | None,
    fidelity: str | int | None,
    keep: bool,
    is_batch: bool,
) -> list[ShotTask]:
    """Return the task of each row, after a check of the keys."""
    stamp, options = binary_stamp(), "" if fidelity is None else f"--fidelity={fidelity}"
    if scene is not None and fmu is not None:
        scene, options = _scene_of_fmu(scene, fidelity), ""
        with FmuInstance(fmu) as instance:
            instance.check_names(map(str, table.columns))
    scenes, keys = cartridge_scenes(table) if scene is None else ([scene] * len(table), table)
    # The index comes first: without further keys there are rows nevertheless.
    records: list[dict[str, Any]] = [dict(zip(map(str, keys), row[1:], strict=True)) for row in keys.itertuples()]
    shots = list(zip(scenes, records, strict=True))
    for place, (own, record) in enumerate(shots):
        _refuse_cells(place, record)
        if fmu is None:
            own.with_values(record)  # refuses an unknown key before the first shot
    kept = folder.path / SHOTS if keep else None
    if is_batch:
        shots = [(own.with_values({"scene.fidelity": "instant"}), record) for own, record in shots]
        options = ""
    return [ShotTask(own, record, stamp, options, fmu, kept, is_batch) for own, record in shots]


def _refuse_cartridges(scene: Scene | None, table: pd.DataFrame, runs: str) -> None:
    """Refuse cartridges as FMUs, and beside a scene."""
    if scene is None and runs == "fmu":
        remedy = 'runs="command": each cartridge has a scene of its own'
        raise GelfmuError(f'runs: found "fmu" for cartridges, expected {remedy}', key="runs", remedy=remedy)
    if scene is not None and "projectile" in table and any(isinstance(name, str) for name in table["projectile"]):
        remedy = "None as the scene: each cartridge makes its own"
        raise GelfmuError(f"projectile: found cartridges beside a scene, expected {remedy}", remedy=remedy)


def _refuse_cells(place: int, record: Mapping[str, Any]) -> None:
    """Refuse a row with a value that no scene has, such as None."""
    for key, value in record.items():
        try:
            toml_text(value)
        except TypeError as error:
            remedy = "a number, a text, a switch, a list or a table in each row"
            raise GelfmuError(
                f"{key}: found {value!r} in row {place}, expected {remedy}", key=key, remedy=remedy
            ) from error


def _table_of(table: pd.DataFrame, keys: Sequence[str], rows: Mapping[str, Row]) -> pd.DataFrame:
    """Return the samples that have a row, beside status, reason and figures."""
    found = [place for place, key in enumerate(keys) if key in rows]
    results = [rows[keys[place]] for place in found]
    records = [{"status": row["status"], "reason": row["reason"], **row["figures"]} for row in results]
    figures = pd.DataFrame(records) if records else pd.DataFrame(columns=["status", "reason"])
    figures.index = pd.Index(found)
    # A column of the samples goes before a figure of the same name.
    figures = figures.drop(columns=[name for name in figures if name in table and name not in ("status", "reason")])
    return pd.concat([table.iloc[found], figures], axis=1)


def _refuse_settings(runs: Any, workers: Any) -> None:
    """Refuse settings of a sweep that are none."""
    if runs not in ("command", "fmu"):
        remedy = '"command" or "fmu"'
        raise GelfmuError(f"runs: found {runs!r}, expected {remedy}", key="runs", remedy=remedy)
    if workers is not None and not is_count(workers, 0):
        remedy = "a whole number of workers, or 0 for all cores"
        raise GelfmuError(f"workers: found {workers!r}, expected {remedy}", key="workers", remedy=remedy)


def _parse_share(share: str) -> list[int]:
    number, slash, count = share.partition("/")
    if slash and number.isdecimal() and count.isdecimal() and 1 <= int(number) <= int(count):
        return [int(number), int(count)]
    remedy = "number and count of the shares, such as 2/8"
    raise GelfmuError(f"share {share}: found no share, expected {remedy}", remedy=remedy)


def _shown(shots: Iterable[Any], count: int, progress: bool) -> Iterable[Any]:
    if not progress:
        return shots
    if not shows_bars():
        return _told(shots, count)
    from tqdm.auto import tqdm

    bar: Iterable[Any] = tqdm(shots, total=count, desc="shots", unit="shot")
    return bar


def _told(shots: Iterable[Any], count: int) -> Iterator[Any]:
    lines = ProgressLines("shots")
    for number, shot in enumerate(shots, 1):
        yield shot
        lines.tell(f"{number} of {count}", number / count)
