"""Sweeps: the same table from any engine, after any end."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time
import traceback
from concurrent.futures import ThreadPoolExecutor, as_completed

import pandas as pd
import pytest

import ballistic_gel as bg
from ballistic_gel.__main__ import main
from ballistic_gel.binary import binary_stamp
from ballistic_gel.folder import SweepFolder
from ballistic_gel.tasks import ShotTask, run_task

pytest.importorskip("scipy")

SPREADS = {"projectile.velocity[3]": bg.Uniform(-2.0, -1.0), "gel.shear_modulus": bg.LogNormal(20e3, 0.1)}
STUDY = """
scene = "ball-bounce"
out = "rows of study"
[set]
"scene.end_time" = 2e-4
"mesh.size" = 4e-3
[sampler]
kind = "sobol"
count = 64
seed = 5
[keys]
"projectile.velocity[3]" = { normal = { mean = -1.0, deviation = 0.1 } }
"""


@pytest.fixture(scope="module")
def samples():
    return bg.LatinHypercube(SPREADS, 8, seed=1)


@pytest.fixture(scope="module")
def table(quick, samples, tmp_path_factory):
    """The rows by one worker."""
    folder = tmp_path_factory.mktemp("one")
    return bg.sweep(quick, samples, folder, workers=1), (folder / "results.csv").read_bytes()


def test_equal_seeds_give_equal_samples(samples):
    assert samples.table().equals(bg.LatinHypercube(SPREADS, 8, seed=1).table())
    assert not samples.table().equals(bg.LatinHypercube(SPREADS, 8, seed=2).table())
    assert bg.Sobol(SPREADS, 8, seed=1).table().equals(bg.Sobol(SPREADS, 8, seed=1).table())
    grid = bg.Grid({"mesh.size": [1e-3, 2e-3], "gel.velocity": [[0, 0, 1], [0, 0, 2]]}).table()
    assert list(grid["mesh.size"]) == [1e-3, 1e-3, 2e-3, 2e-3] and grid["gel.velocity"][1] == [0, 0, 2]


def test_the_table_does_not_depend_on_the_number_of_workers(quick, samples, table, tmp_path):
    made, results = table
    assert bg.sweep(quick, samples, tmp_path, workers=3).equals(made)
    assert (tmp_path / "results.csv").read_bytes() == results
    assert made["digest"].is_unique and set(made["status"]) == {"completed"}
    assert list(pd.read_csv(tmp_path / "results.csv")["digest"]) == list(made["digest"])
    assert "wall_seconds" in pd.read_csv(tmp_path / "clock.csv") and "wall_seconds" not in made


def test_finished_rows_are_not_run_again(quick, samples, table, tmp_path, monkeypatch):
    bg.sweep(quick, samples, tmp_path, share="2/4")
    rows = set((tmp_path / "rows").iterdir())
    assert len(rows) == 2 and not (tmp_path / "results.csv").exists()
    assert bg.sweep(quick, samples, tmp_path).equals(table[0])
    times = {row: row.stat().st_mtime_ns for row in (tmp_path / "rows").iterdir()}
    monkeypatch.setattr("ballistic_gel.engines.run_task", None)
    assert bg.sweep(quick, samples, tmp_path).equals(table[0])
    assert times == {row: row.stat().st_mtime_ns for row in (tmp_path / "rows").iterdir()}


def test_a_shot_that_fails_is_a_row_with_its_reason(tmp_path):
    square = bg.Scene.built_in("ball-square").with_values({"scene.end_time": 1e-3})
    made = bg.sweep(square, {"mesh.size": [-1.0, 12.5e-3]}, tmp_path / "a")
    assert made["status"][0] == "refused" and "expected a positive length" in made["reason"][0]
    stopped = bg.sweep(square, {"gel.density": [1000.0]}, tmp_path / "b", keep=True)
    assert stopped["status"][0] == "stopped" and "is inverted" in stopped["reason"][0]
    assert bg.Shot.load(next((tmp_path / "b" / "shots").iterdir())).digest == stopped["digest"][0]


def test_the_reason_of_a_refused_shot_has_no_path(tmp_path):
    scene = bg.Scene.new_shot("bb")
    made = [bg.sweep(scene, {"mesh.size": [-1.0]}, tmp_path / name)["reason"][0] for name in ("a", "b")]
    assert made[0] == made[1] and made[0].startswith("scene bb-180 with --set mesh.size=-1.0: mesh.size: found -1.0")
    with pytest.raises(bg.GelfmuError, match="^scene bb-180 with"):
        scene.with_values({"mesh.size": -1.0}).check()


def test_shots_of_a_table_of_cartridges_equal_shots_of_new(tmp_path):
    cartridges = pd.DataFrame({"projectile": ["bb", "sphere-4.8mm"], "speed": [300, "300 m/s"], "yaw": [None, 0.0]})
    cartridges["block"], cartridges["scene.end_time"] = "10x10x20cm", 1e-4
    made = bg.sweep(None, cartridges, tmp_path, fidelity="draft")
    for row, name in enumerate(cartridges["projectile"]):
        new = bg.Scene.new_shot(name, 300, block="10x10x20cm").with_values({"scene.end_time": 1e-4})
        assert made["digest"][row] == bg.run(new, fidelity="draft", out=tmp_path / name).digest
    assert list(made["projectile"]) == ["bb", "sphere-4.8mm"] and made["digest"].is_unique
    refused = bg.sweep(bg.Scene.new_shot("bb", 300), {"projectile.library": ["sphere-4.8mm"]}, tmp_path / "keys")
    assert refused["status"][0] == "refused" and "gelfmu new --projectile sphere-4.8mm" in refused["reason"][0]


@pytest.mark.parametrize(
    "scene, columns, message",
    [
        (None, {"projectile": ["bb"], "sped": [180]}, "unknown column of cartridges `sped` .did you mean `speed`"),
        (None, {"projectile": ["bb"], "mesh.sizee": [1e-3]}, "did you mean `mesh.size`"),
        (None, {"speed": [180]}, "scene: found none, expected a scene, or a column projectile"),
        (None, {"projectile": ["bb", None]}, "row 1: projectile: found nothing"),
        (None, {"projectile": ["bb", "bbb"]}, "row 1: .*bbb"),
        (None, {"projectile": ["bb"], "yaw": [2.0]}, "row 0: --yaw 2: a sphere has no axis"),
        ("fbi-bb", {"projectile": ["bb"]}, "found cartridges beside a scene, expected None"),
    ],
)
def test_a_table_of_cartridges_that_makes_no_shots_is_refused(tmp_path, scene, columns, message):
    with pytest.raises(bg.GelfmuError, match=message):
        bg.sweep(scene, pd.DataFrame(columns), tmp_path)


def test_a_process_that_dies_is_a_row_that_is_repeated(quick, tmp_path, monkeypatch):
    if sys.platform == "win32":
        pytest.skip("the program is a shell script")
    real = bg.find_binary()
    flag, script = tmp_path / "flag", tmp_path / "gelfmu"
    script.write_text(f'#!/bin/sh\n[ "$1" = run ] && [ -e "{flag}" ] && kill -9 $$\nexec "{real}" "$@"\n')
    script.chmod(0o755)
    flag.touch()
    monkeypatch.setenv("GELFMU", str(script))
    with pytest.warns(bg.CrashWarning, match="1 of 1 shots crashed"):
        assert bg.sweep(quick, {"gel.density": [1000.0]}, tmp_path / "rows")["status"][0] == "crashed"
    study = tmp_path / "study.toml"
    study.write_text('scene = "ball-bounce"\n[keys]\n"gel.density" = [1000.0]\n')
    with pytest.warns(bg.CrashWarning):
        assert main(["sweep", str(study)]) == 1
    flag.unlink()
    assert bg.sweep(quick, {"gel.density": [1000.0]}, tmp_path / "rows")["status"][0] == "completed"


@pytest.mark.parametrize("through_fmu", [False, True])
def test_a_folder_that_cannot_be_written_is_no_fault_of_the_shot(quick, tmp_path, monkeypatch, through_fmu):
    fmu = None
    if through_fmu:
        pytest.importorskip("fmpy")
        fmu = bg.pack(quick, tmp_path / "quick.fmu")
    task = ShotTask(quick, {}, binary_stamp(), fmu=fmu)
    assert run_task(task)["status"] == "completed"
    occupied = tmp_path / "file"
    occupied.touch()
    with monkeypatch.context() as patched:
        patched.setattr("ballistic_gel.tasks.tempfile.mkdtemp", lambda prefix: str(occupied))
        assert run_task(task)["status"] == "crashed"
    assert run_task(task)["status"] == "completed"


def test_a_foreign_folder_is_refused_and_stays_as_it_was(quick, tmp_path):
    for name in ("results.csv", "results.parquet", "clock.csv"):
        (tmp_path / name).write_text("mine")
    with pytest.raises(bg.GelfmuError, match='has "clock.csv" and no gelfmu.jsonl') as refused:
        bg.sweep(quick, {"gel.density": [1000.0]}, tmp_path)
    assert refused.value.remedy == "expected an empty or new folder"
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == dict.fromkeys(
        ("results.csv", "results.parquet", "clock.csv"), "mine"
    )


@pytest.mark.parametrize("name", ["results.csv", "rows"])
def test_a_foreign_file_with_the_name_of_a_result_is_refused(quick, tmp_path, name):
    bg.sweep(quick, {"gel.density": [1000.0]}, tmp_path, share="2/2")
    (tmp_path / "notes.txt").write_text("mine")
    (tmp_path / name).write_text("mine")
    with pytest.raises(bg.GelfmuError, match=f"{name}, which no sweep has made") as refused:
        bg.sweep(quick, {"gel.density": [1000.0]}, tmp_path)
    assert "move the file away" in refused.value.remedy and (tmp_path / name).read_text() == "mine"
    (tmp_path / name).unlink()
    assert len(bg.sweep(quick, {"gel.density": [1000.0]}, tmp_path)) == 1
    assert (tmp_path / "notes.txt").read_text() == "mine"


def test_the_manifest_of_a_sweep_is_one_of_the_command(quick, tmp_path):
    bg.sweep(quick, {"gel.density": [1000.0, 1010.0]}, tmp_path / "a")
    lines = [json.loads(line) for line in (tmp_path / "a" / "gelfmu.jsonl").read_text().splitlines()]
    listed = {line["file"] for line in lines if "file" in line}
    there = {path.relative_to(tmp_path / "a").as_posix() for path in (tmp_path / "a").rglob("*") if path.is_file()}
    assert listed == there - {"gelfmu.jsonl"}
    assert lines[0]["results_of"] == "sweep" and lines[-1] == {"state": "complete"}
    with pytest.raises(bg.GelfmuError, match="found results of gelfmu sweep"):
        bg.run(quick, out=tmp_path / "a", force=True)
    bg.run(quick, out=tmp_path / "b", frames=False, report=False)
    with pytest.raises(bg.GelfmuError, match="found results of gelfmu run"):
        bg.sweep(quick, {"gel.density": [1000.0]}, tmp_path / "b")


def test_a_file_of_a_row_that_is_no_row_is_run_again(quick, samples, table, tmp_path):
    bg.sweep(quick, samples, tmp_path)
    rows = sorted((tmp_path / "rows").iterdir())
    for row, text in zip(rows, ("[]", "5", "{}", '{"status": "crashed", "reason": "", "figures": {}}'), strict=False):
        row.write_text(text)
    assert bg.sweep(quick, samples, tmp_path).equals(table[0])


def test_a_share_without_rows_runs_nothing(quick, tmp_path):
    made = bg.sweep(quick, {"gel.density": [1000.0]}, tmp_path, share="2/2")
    assert len(made) == 0 and {"status", "reason"} <= set(made)


def test_vectors_and_sensors_are_columns(quick, tmp_path):
    values = {"sensor": [{"position": [0.0, 0.0, -0.01]}]}
    made = bg.sweep(quick.with_values(values), {"gel.density": [1000.0]}, tmp_path)
    assert made["sensors[1].position[3]"][0] == -0.01 and made["sensors[1].peak_pressure"][0] > 0.0
    assert made["final_velocity[3]"][0] > -1.0 and pd.isna(made["exit_velocity[3]"][0])
    assert not any("cavity_course" in column or "switched_off" in column for column in made)


def test_a_changed_file_of_the_scene_is_another_shot(tmp_path):
    (tmp_path / "body.stl").write_text("solid one")
    scene = tmp_path / "scene.toml"
    scene.write_text('[projectile]\nshape.stl = { file = "body.stl" }\n')
    before = bg.Scene.load(scene).digest()
    assert bg.Scene.load(scene).digest() == before
    (tmp_path / "body.stl").write_text("solid other")
    assert bg.Scene.load(scene).digest() != before


@pytest.mark.parametrize("runs", ["command", "fmu"])
def test_kept_shots_are_in_folders_that_the_table_names(quick, tmp_path, runs):
    if runs == "fmu":
        pytest.importorskip("fmpy")
    made = bg.sweep(quick, {"gel.density": [1000.0, 1010.0, -1.0]}, tmp_path, workers=2, runs=runs, keep=True)
    assert list(made["status"]) == ["completed", "completed", "refused"] and pd.isna(made["folder"][2])
    for place in (0, 1):
        assert bg.Shot.load(tmp_path / made["folder"][place]).digest == made["digest"][place]
    shutil.rmtree(tmp_path / made["folder"][1])
    bg.sweep(quick, {"gel.density": [1000.0, 1010.0, -1.0]}, tmp_path, workers=2, runs=runs, keep=True)
    assert (tmp_path / made["folder"][1]).is_dir(), "a shot whose folder is lost is run again"


def test_another_program_than_that_of_the_sweep_is_refused(quick):
    with pytest.raises(bg.GelfmuError, match="found another gelfmu"):
        run_task(ShotTask(quick, {}, stamp="other"))


def test_the_last_share_sees_the_rows_of_the_others(quick, samples, table, tmp_path):
    for number in (1, 3, 2):
        bg.sweep(quick, samples, tmp_path, share=f"{number}/3")
    assert (tmp_path / "results.csv").read_bytes() == table[1]


def test_an_unknown_key_is_refused_before_the_first_shot(quick, tmp_path):
    with pytest.raises(bg.GelfmuError, match="did you mean `gel.density`"):
        bg.sweep(quick, {"gel.densty": [1.0]}, tmp_path)
    with pytest.raises(bg.GelfmuError, match="expected number and count"):
        bg.sweep(quick, {"gel.density": [1e3]}, tmp_path, share="3/2")


@pytest.mark.parametrize("setting", [{"workers": -5}, {"workers": "all"}, {"runs": "fmuu"}])
def test_a_setting_that_is_none_is_refused(quick, tmp_path, setting):
    with pytest.raises(bg.GelfmuError) as refused:
        bg.sweep(quick, {"gel.density": [1e3]}, tmp_path, **setting)
    assert refused.value.key == next(iter(setting))


def test_rows_that_are_no_rows_are_refused(quick, tmp_path):
    with pytest.raises(bg.GelfmuError, match="^samples: found int, expected a mapping"):
        bg.sweep(quick, 5, tmp_path)
    rows = pd.DataFrame({"gel.preset": ["gelatin-10", None]}, dtype=object)
    with pytest.raises(bg.GelfmuError, match="^gel.preset: found None in row 1, expected a number"):
        bg.sweep(quick, rows, tmp_path)


def test_a_sweep_without_a_terminal_tells_its_progress(quick, samples, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("ballistic_gel.progress._INTERVAL", 0.0)
    monkeypatch.setattr("ballistic_gel.sweeping.shows_bars", lambda: False)
    bg.sweep(quick, samples, tmp_path, progress=False)
    assert capsys.readouterr().err == ""
    shutil.rmtree(tmp_path)
    bg.sweep(quick, samples, tmp_path)
    assert "shots: 2 of 8, 25 %, 0 s elapsed, " in capsys.readouterr().err


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
@pytest.mark.parametrize("kind", [signal.SIGKILL, signal.SIGTERM])
def test_a_killed_sweep_goes_on_where_it_was(tmp_path, kind):
    (tmp_path / "study.toml").write_text(STUDY)
    command = [sys.executable, "-m", "ballistic_gel", "sweep", str(tmp_path / "study.toml"), "--workers", "1"]
    process = subprocess.Popen(command, stderr=subprocess.PIPE)
    folder = tmp_path / "rows of study" / "rows"
    until = time.monotonic() + 30.0
    while (not folder.is_dir() or len(list(folder.glob("*.json"))) < 5) and time.monotonic() < until:
        time.sleep(0.01)
    process.send_signal(kind)
    _, said = process.communicate(timeout=20.0)
    kept = {row: row.stat().st_mtime_ns for row in folder.glob("*.json")}
    assert 5 <= len(kept) < 64
    assert kind != signal.SIGTERM or f"interrupted: {len(kept)} of 64 shots are kept in" in said.decode()
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert done.stdout.startswith("64 completed")
    assert all(row.stat().st_mtime_ns == at for row, at in kept.items())
    study = bg.Study.load(tmp_path / "study.toml")
    whole = bg.sweep(study.scene(), study.samples(), tmp_path / "whole")
    bytes_of = [(place / "results.csv").read_bytes() for place in (tmp_path / "whole", tmp_path / "rows of study")]
    assert bytes_of[0] == bytes_of[1] and len(whole) == 64


def test_the_fmu_gives_the_rows_of_the_command(quick, samples, table, tmp_path):
    pytest.importorskip("fmpy")
    renamed = samples.table().rename(columns={"projectile.velocity[3]": "projectile.initial_velocity[3]"})
    made = bg.sweep(quick, renamed, tmp_path, workers=2, runs="fmu")
    assert made.iloc[:, 2:].equals(table[0].iloc[:, 2:])
    with pytest.raises(bg.GelfmuError, match="did you mean"):
        bg.sweep(quick, {"projectile.velocitee[3]": [1.0]}, tmp_path, runs="fmu")


def test_an_archive_in_the_folder_is_never_loaded(quick, tmp_path, monkeypatch):
    pytest.importorskip("fmpy")
    scene = quick.with_values({"output.frames": 0, "output.report": False})
    modes = []

    def pack(scene, path):
        modes.append((path.parent.stat().st_mode & 0o777, path))
        return bg.pack(scene, path)

    monkeypatch.setattr("ballistic_gel.sweeping.pack", pack)
    for client in (None, ThreadPoolExecutor(1)):
        folder = tmp_path / type(client).__name__
        SweepFolder(folder).claim()
        (folder / f"{scene.digest(binary_stamp())}.fmu").write_text("foreign")
        # The share has no row: its FMU is packed, loaded and asked for its names all the same.
        bg.sweep(quick, {"mesh.size": [4e-3]}, folder, client=client, runs="fmu", share="2/2")
    assert [mode for mode, _ in modes] == [0o700] * 2 and not any(path.parent.exists() for _, path in modes)


def test_an_executor_gives_the_rows_of_this_machine(quick, samples, table, tmp_path):
    with ThreadPoolExecutor(2) as executor:
        assert bg.sweep(quick, samples, tmp_path, client=executor).equals(table[0])


def test_an_interrupt_cancels_what_has_not_begun_and_keeps_what_has_ended(quick, samples, tmp_path, monkeypatch):
    begun = []

    def interrupted(futures):
        # The one worker has begun a shot or two when the interrupt comes.
        yield next(iter(as_completed(futures)))
        begun.extend(future for future in futures if not future.cancelled())
        raise KeyboardInterrupt

    monkeypatch.setattr("ballistic_gel.sweeping.as_completed", interrupted)
    with ThreadPoolExecutor(1) as executor, pytest.raises(KeyboardInterrupt) as told:
        bg.sweep(quick, samples, tmp_path, client=executor)
    kept = len(list((tmp_path / "rows").iterdir()))
    assert str(told.value) == f"{kept} of 8 shots are kept in {tmp_path}: the same call goes on from there"
    assert "interrupted(futures)" not in "".join(traceback.format_exception(told.value)), "no frame of an executor"
    assert '"interrupted"' in (tmp_path / "gelfmu.jsonl").read_text().splitlines()[-1]
    assert len(begun) == 8 and sum(future.cancelled() for future in begun) >= 5
    ended = sum(not future.cancelled() and future.done() for future in begun)
    assert 1 <= len(list((tmp_path / "rows").iterdir())) <= ended


def test_dask_gives_the_rows_of_this_machine(quick, samples, table, tmp_path):
    distributed = pytest.importorskip("distributed")
    options = {"n_workers": 2, "threads_per_worker": 1, "dashboard_address": None}
    with distributed.LocalCluster(**options) as cluster, distributed.Client(cluster) as client:
        assert bg.sweep(quick, samples, tmp_path, client=client).equals(table[0])


@pytest.mark.skipif("BALLISTIC_GEL_RAY" not in os.environ, reason="Ray takes its time: BALLISTIC_GEL_RAY=1 runs it")
def test_ray_gives_the_rows_of_this_machine(quick, samples, table, tmp_path):
    ray = pytest.importorskip("ray")
    ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False)
    try:
        assert bg.sweep(quick, samples, tmp_path, client=ray).equals(table[0])
    finally:
        ray.shutdown()
