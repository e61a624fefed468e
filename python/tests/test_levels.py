"""Errors of the levels: rows of a table, which no other file becomes."""

import pandas as pd
import pytest

import ballistic_gel as bg
from ballistic_gel import levels
from ballistic_gel.__main__ import main

DEPTHS = {"draft": 0.08, "coarse": 0.09, "standard": 0.099, "fine": 0.1}


@pytest.fixture
def sweeps(monkeypatch):
    """Depths in place of the runs of a sweep, and its folders."""
    folders, changes = [], {}

    def sweep(scene, samples, out, **_):
        folders.append(out)
        rows = [
            {"scene.fidelity": level, "status": "completed", "reason": None, "perforated": False, "final_depth": 1.0}
            | {"rest_depth": DEPTHS[level]}
            | changes.get(level, {})
            for level in samples["scene.fidelity"]
        ]
        return pd.DataFrame(rows)

    monkeypatch.setattr(levels, "sweep", sweep)
    return folders, changes


def test_the_error_of_a_level_is_that_of_its_depth_against_the_reference(sweeps, tmp_path):
    table = tmp_path / "level-errors.csv"
    rows = bg.level_errors("bb", [180, "720 m/s"], out=tmp_path / "runs", table=table, progress=False)
    assert list(rows["level"]) == ["draft", "coarse", "standard"] * 2 and list(rows["reference"].unique()) == ["fine"]
    assert list(rows["error"].round(6)) == [0.2, 0.1, 0.01] * 2
    assert list(rows["command"].unique()) == [
        f"python -m ballistic_gel levels bb --speed {speed}" for speed in ("180.0", "720.0")
    ]
    assert len(set(sweeps[0])) == 2, "a folder for each speed"
    kept = table.read_text()
    assert kept.splitlines()[0] == ",".join(levels.COLUMNS)
    assert [line.split(",")[:2] for line in kept.splitlines()[1:]] == [["bb", "sphere"]] * 6
    bg.level_errors("bb", [180], out=tmp_path / "runs", table=table, progress=False)
    assert sorted(table.read_text().splitlines()) == sorted(kept.splitlines()), "a row is replaced"


def test_a_projectile_at_the_end_of_its_run_or_beyond_the_block_is_told(sweeps, tmp_path):
    sweeps[1]["draft"] = {"rest_depth": None, "final_depth": 0.07}
    rows = bg.level_errors("bb", [180], out=tmp_path / "runs", progress=False)
    assert rows["depth"][0] == 0.07
    sweeps[1]["fine"] = {"perforated": True}
    with pytest.raises(bg.GelfmuError, match="bb-180 at fine: the projectile left the block.*take a longer block"):
        bg.level_errors("bb", [180], out=tmp_path / "runs", progress=False)
    sweeps[1]["fine"] = {"status": "refused", "reason": "mesh.size: found 1.0"}
    with pytest.raises(bg.GelfmuError, match="bb-180 at fine: .*refused .mesh.size: found 1.0"):
        bg.level_errors("bb", [180], out=tmp_path / "runs", progress=False)


def test_another_file_is_not_replaced(sweeps, tmp_path, capsys):
    table = tmp_path / "mine.csv"
    table.write_text("a,b\n1,2\n")
    assert main(["levels", "bb", "--speed", "180", "--out", str(tmp_path / "runs"), "--table", str(table)]) == 2
    assert "found a table of something else" in capsys.readouterr().err
    assert table.read_text() == "a,b\n1,2\n" and not sweeps[0], "refused before the first run"
    assert main(["levels", "bb", "--speed", "180", "--reference", "reference"]) == 2
    assert "expected one of coarse, standard, fine" in capsys.readouterr().err
