"""Runs: results, ends before their time, interrupts."""

import os
import signal
import subprocess
import sys
import time

import pytest

import ballistic_gel as bg
from ballistic_gel.binary import call_binary
from ballistic_gel.running import ProgressBar

INTERRUPTED = """
import signal
import sys
import ballistic_gel as bg
# The tests may run where interrupts are ignored.
signal.signal(signal.SIGINT, signal.default_int_handler)
scene = bg.Scene.built_in("fbi-bb").with_values({"scene.fidelity": "coarse"})
try:
    bg.run(scene, out=sys.argv[1], frames=False, report=False, threads=1)
except KeyboardInterrupt as interrupt:
    print(interrupt.__notes__[0])
    sys.exit(42)
"""


def test_a_run_gives_a_shot_that_its_folder_gives_too(quick, tmp_path):
    shot = bg.run(quick, out=tmp_path / "a", frames=False, report=False, threads=1)
    assert shot.completed
    assert bg.Shot.load(tmp_path / "a").digest == shot.digest
    assert bg.run(quick, out=tmp_path / "b", frames=False, report=False, threads=2).digest == shot.digest
    with pytest.raises(bg.GelfmuError):
        bg.run(quick, out=tmp_path / "a")
    assert bg.run(quick, out=tmp_path / "a", frames=False, force=True).report().is_file()


def test_a_run_without_a_folder_has_one_of_its_own(quick, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    folders = {
        bg.run(quick, values={"gel.density": density}, frames=False, report=False).folder
        for density in (1e3, 1e3, 1100)
    }
    assert len(folders) == 2


def test_a_run_is_compared_with_the_table_of_a_laboratory(quick, tmp_path):
    lab = tmp_path / "lab.csv"
    lab.write_text("time_ms,velocity_m_per_s\n0,1\n0.1,1\n9,1\n", encoding="utf-8")
    shot = bg.run(quick, out=tmp_path / "a", frames=False, report=False, measured=lab)
    [row] = shot.measured.to_dict("records")
    assert (row["quantity"], row["by"], row["unit"], row["points"], row["outside"]) == ("velocity", "time", "m/s", 2, 1)
    assert abs(row["greatest"]) >= row["rms"] > 0.0
    with pytest.raises(bg.GelfmuError, match="compared with no table: run with measured="):
        bg.run(quick, out=tmp_path / "b", frames=False, report=False).measured  # noqa: B018
    with pytest.raises(bg.GelfmuError, match=r"nowhere\.csv"):
        bg.run(quick, out=tmp_path / "c", measured=tmp_path / "nowhere.csv")


def test_a_run_that_stops_gives_what_it_computed(tmp_path):
    with pytest.raises(bg.ShotError, match="is inverted") as stopped:
        bg.run("ball-square", values={"scene.end_time": 1e-3}, out=tmp_path / "s", frames=False, report=False)
    assert stopped.value.shot.summary["end_time"] < 1e-3
    assert "add a `remesh` table" in stopped.value.remedy


def test_a_refused_run_leaves_no_shot(quick, tmp_path):
    with pytest.raises(bg.GelfmuError) as refused:
        bg.run(quick, values={"gel.density": -1.0}, out=tmp_path / "r")
    assert refused.value.key == "gel.density"
    assert not isinstance(refused.value, bg.ShotError)


def test_a_run_past_its_timeout_is_kept(long_scene, tmp_path):
    with pytest.raises(bg.ShotError, match="timeout of 0.7 s") as late:
        bg.run(long_scene, out=tmp_path / "t", frames=False, report=False, threads=1, timeout=0.7)
    assert late.value.shot.summary["ended_by"] != "end_time"
    assert len(late.value.shot.history) > 1


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
def test_an_interrupt_keeps_what_was_computed_and_leaves_no_process(tmp_path):
    out = tmp_path / "i"
    python = subprocess.Popen([sys.executable, "-c", INTERRUPTED, str(out)], stdout=subprocess.PIPE, text=True)
    _wait_until(lambda: (out / "history.csv").is_file())
    children = _children_of(python.pid)
    time.sleep(0.3)
    python.send_signal(signal.SIGINT)
    said, _ = python.communicate(timeout=20.0)
    assert python.returncode == 42
    assert "Shot.load" in said
    assert not bg.Shot.load(out).completed
    assert children and not any(os.path.exists(f"/proc/{child}") for child in children)


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
def test_a_killed_python_leaves_no_process(tmp_path):
    out = tmp_path / "k"
    python = subprocess.Popen([sys.executable, "-c", INTERRUPTED, str(out)], stdout=subprocess.DEVNULL)
    _wait_until(lambda: (out / "history.csv").is_file())
    python.kill()
    python.wait()
    _wait_until(lambda: '"state":"interrupted"' in (out / "gelfmu.jsonl").read_text())
    assert not bg.Shot.load(out).completed, "what was computed is kept"


def _wait_until(is_true):
    until = time.monotonic() + 20.0
    while not is_true():
        assert time.monotonic() < until
        time.sleep(0.05)


def test_an_error_while_waiting_ends_the_process(long_scene, tmp_path):
    def stop():
        raise RuntimeError("enough")

    with long_scene.source() as name, pytest.raises(RuntimeError, match="enough"):
        call_binary(["run", name, *long_scene.arguments(), "--direct", f"--out={tmp_path / 'e'}"], on_wait=stop)
    assert not bg.Shot.load(tmp_path / "e").completed


def test_the_bar_follows_the_history_of_this_run_only(tmp_path):
    (tmp_path / "history.csv").write_text("time_s,depth_m\n0e0,0\n")
    bar = ProgressBar(tmp_path, "shot", wanted=True)
    assert bar._time() is None
    (tmp_path / "history.csv").write_text("time_s,depth_m\n0e0,0\n1e-3,2\n2e-")
    os.utime(tmp_path / "history.csv", ns=(1, 1))
    assert bar._time() == 1e-3


def test_the_bar_waits_while_a_run_replaces_its_files(tmp_path):
    (tmp_path / "history.csv").write_text("time_s,depth_m\n0e0,0\n")
    bar = ProgressBar(tmp_path, "shot", wanted=True)
    (tmp_path / "history.csv").unlink()
    (tmp_path / "scene.toml").write_text("[scene")
    assert bar._time() is None and bar._end_time is None


def test_a_run_without_a_terminal_tells_its_progress(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("ballistic_gel.running.shows_bars", lambda: False)
    monkeypatch.setattr("ballistic_gel.progress._INTERVAL", 0.0)
    bars = [ProgressBar(tmp_path, "shot", wanted) for wanted in (True, False)]
    (tmp_path / "history.csv").write_text("time_s,depth_m\n1e-3,2\n")
    (tmp_path / "scene.toml").write_text("scene.end_time = 4e-3")
    for bar in bars:
        bar.update()
    assert capsys.readouterr().err.startswith("shot: 1.000 of at most 4.000 ms, 0 s elapsed\n")
    monkeypatch.setattr("ballistic_gel.progress._INTERVAL", 30.0)
    bars[0].update()
    assert capsys.readouterr().err == "", "not before 30 s"


def _children_of(process):
    listed = subprocess.run(["ps", "-o", "pid=", "--ppid", str(process)], capture_output=True, text=True)
    return listed.stdout.split()
