"""Studies: what a TOML file says, and what is refused."""

import re
from pathlib import Path

import pandas as pd
import pytest

import ballistic_gel as bg
from ballistic_gel.__main__ import main

STUDIES = Path(__file__).resolve().parents[2] / "studies"


def write_study(folder, text):
    path = folder / "spread.toml"
    path.write_text(text)
    return path


def test_a_grid_of_a_shot_of_the_library(tmp_path):
    text = (
        '[shot]\nprojectile = "bb"\nspeed = 180\n[set]\n"mesh.size" = 1e-3\n[keys]\n"gel.strength_scale" = [0.9, 1.1]\n'
    )
    study = bg.Study.load(write_study(tmp_path, text))
    assert study.scene()["mesh.size"] == 1e-3
    assert list(study.samples()["gel.strength_scale"]) == [0.9, 1.1]
    assert study.folder == tmp_path / "spread"


def test_a_grid_of_cartridges_makes_a_scene_for_each(tmp_path):
    keys = "[keys]\nprojectile = ['bb', 'sphere-4.8mm']\nspeed = [200, 300]\n'scene.end_time' = [5e-5]\n"
    text = "fidelity = 'draft'\n[set]\n'scene.end_time' = 1e-4\n" + keys
    made = bg.Study.load(write_study(tmp_path, text)).run()
    assert list(made["speed"]) == [200, 300, 200, 300] and made["digest"].is_unique
    assert made["end_time"].max() < 6e-5, "the value of a row wins over that of all"
    with pytest.raises(bg.GelfmuError, match="scene: found it beside cartridges"):
        bg.Study.load(write_study(tmp_path, "scene = 'fbi-bb'\n" + keys)).run()


@pytest.mark.parametrize(
    "text, remedy",
    [
        ("scen = 'fbi-bb'", "`scene`"),
        ("[sampler]\nkind = 'sobel'", "`sobol`"),
        ("[sampler]\nkind = 'sobol'\ncount = 4\n[keys]\n'mesh.size' = { norml = { mean = 1 } }", "`normal`"),
        (
            "[sampler]\nkind = 'sobol'\ncount = 4\n[keys]\n'mesh.size' = { normal = { mean = 1 } }",
            "give mean, deviation",
        ),
        ("[sampler]\nkind = 'sobol'\ncount = 4\n[keys]\n'mesh.size' = 3", "one of uniform"),
        ("[sampler]\nkind = 'sobol'\nconut = 4", "give spreads, count, seed"),
        ("scene =", "a TOML file"),
        ("[keys]\n'gel.preset' = 'gelatin-10'", "a list of values"),
        ("[keys]\n'mesh.size' = { normal = { mean = 1.0, deviation = 0.1 } }", "needs a sampler"),
        ("[keys]\n'mesh.size' = 3.0", "a list of values"),
        ("[sampler]\ncount = 4\n[keys]\n'mesh.size' = [3.0]", "remove sampler.count"),
        ("[sampler]\nfile = 'none.csv'", "a CSV file"),
        ("[sampler]\nfile = 'none.csv'\n[keys]\n'mesh.size' = [3.0]", "remove keys"),
        ("scene = 'fbi-bb'", "a table [keys]"),
        (
            "[sampler]\nkind = 'sobol'\ncount = -4\n[keys]\n'mesh.size' = { uniform = { low = 1, high = 2 } }",
            "1 or more",
        ),
        (
            "[sampler]\nkind = 'sobol'\ncount = 4\n[keys]\n'mesh.size' = { normal = { mean = 'a', deviation = 1 } }",
            "a finite number",
        ),
        (
            "[sampler]\nkind = 'sobol'\ncount = 4\n[keys]\n'mesh.size' = { normal = { mean = 1, deviation = -1 } }",
            "a number greater than 0",
        ),
    ],
)
def test_a_wrong_study_is_refused_with_the_remedy(tmp_path, text, remedy):
    with pytest.raises(bg.GelfmuError) as refused:
        bg.Study.load(write_study(tmp_path, text)).samples()
    assert remedy in refused.value.remedy


@pytest.mark.parametrize(
    "text, told",
    [
        ("keys = 5", "keys: found 5, expected a table"),
        ("scene = 5", "scene: found 5, expected a text"),
        ("out = 5", "out: found 5, expected a text"),
        ("workers = 'all'", "workers: found 'all', expected a whole number"),
        ("workers = true", "workers: found True, expected a whole number"),
        ("keep = 1", "keep: found 1, expected true or false"),
        ("fidelity = 0.5", "fidelity: found 0.5, expected a level"),
        ("sampler = []", "sampler: found [], expected a table"),
        ("[sampler]\nkind = 5", "sampler.kind: found 5, expected a text"),
        ("[sampler]\ncount = 1.5", "sampler.count: found 1.5, expected a whole number"),
        ("[set]\n'scene.end_time' = 2020-01-01", "set.scene.end_time: found 2020-01-01, expected a number"),
        (r'scene = "fbi\nbb"', r"scene: found 'fbi\nbb', expected a text without line feeds"),
        ('[keys]\n"mesh\\u0009size" = [1]', r"key of keys: found 'mesh\tsize', expected a text without"),
        ('[keys]\n"gel.preset" = ["a\\nb"]', r"keys.gel.preset: found 'a\nb', expected a text without"),
    ],
)
def test_a_study_of_wrong_types_is_refused_as_it_is_read(tmp_path, text, told):
    with pytest.raises(bg.GelfmuError) as refused:
        bg.Study.load(write_study(tmp_path, text))
    assert str(refused.value).startswith(told)


def test_a_scene_beside_a_shot_is_refused(tmp_path):
    study = bg.Study.load(write_study(tmp_path, "scene = 'fbi-bb'\n[shot]\nprojectile = 'bb'"))
    with pytest.raises(bg.GelfmuError, match="scene: found it beside shot"):
        study.scene()


def test_the_command_line_tells_errors_and_writes_cluster_scripts(tmp_path, capsys):
    assert main(["sweep", str(tmp_path / "none.toml")]) == 2
    assert "error: study" in capsys.readouterr().err
    (tmp_path / "workers.toml").write_text("workers = -5\n[keys]\n'gel.density' = [1000.0]")
    assert main(["sweep", str(tmp_path / "workers.toml")]) == 2
    assert "error: workers: found -5, expected a whole number of workers" in capsys.readouterr().err
    path = write_study(tmp_path, f"[keys]\n'gel.density' = {[1000.0 + number for number in range(20)]}")
    for wanted in ("20", "30"):
        assert main(["slurm", str(path), "--tasks", wanted, "--cores", "4"]) == 0
        script = capsys.readouterr().out
        # A task without a row would have nothing to do.
        assert script.startswith("#!/bin/bash") and "#SBATCH --array=1-20" in script
        assert '--share "$SLURM_ARRAY_TASK_ID/20" --workers 4' in script


CASES = """
scene = "sphere-block"
out = "rows"

[set]
"mesh.size" = 10e-3
"scene.end_time" = 4e-4

[[case]]
name = "fast"
set = { "projectile.velocity" = [0.0, 0.0, -10.0] }

[[case]]
name = "of the library"
shot = { projectile = "bb", speed = 180 }
set = { "mesh.size" = 1.4e-3, "scene.end_time" = 4e-5 }

[keys]
"gel.density" = [1000.0, 1060.0]

[columns]
"shot" = "case"
"density" = { value = "gel.density", format = ".0f" }
"depth, mm" = { value = "peak_depth", unit = "mm", format = ".3f" }
"contact, %" = { value = "energy.contact", per = "energy.initial", unit = "%", format = "+.1f", expect = [-100, 0] }
"end" = "status"
"""


def test_cases_run_with_all_keys_and_columns_show_their_figures(tmp_path, capsys):
    path = write_study(tmp_path, CASES)
    assert main(["sweep", str(path), "--workers", "1"]) == 0
    told = capsys.readouterr().out.splitlines()
    assert told[0].startswith("4 completed in")
    assert told[1] == "| shot | density | depth, mm | contact, % | end |"
    rows = [line.strip("| ").split(" | ") for line in told[3:]]
    assert [row[:2] for row in rows] == [[case, rho] for case in ("fast", "of the library") for rho in ("1000", "1060")]
    study = bg.Study.load(path)
    table = study.run()
    values = study.table_of(table).values
    assert (
        [float(row[2]) for row in rows]
        == list((1e3 * table["peak_depth"]).round(3))
        == list(values["depth, mm"].round(3))
    )
    assert list(values["contact, %"]) == pytest.approx(list(100.0 * table["energy.contact"] / table["energy.initial"]))
    assert table["cpu_seconds"].notna().all()
    assert "--array=1-4\n" in study.slurm_script(10, "01:00:00", 1)


def test_a_share_shows_the_table_once_all_rows_are_there(tmp_path, capsys):
    path = str(write_study(tmp_path, CASES))
    heads = []
    for share in ("1/2", "2/2"):
        assert main(["sweep", path, "--workers", "1", "--share", share]) == 0
        heads.append("| shot | density |" in capsys.readouterr().out)
    assert heads == [False, True]


def test_a_value_beyond_what_is_expected_is_bold_and_the_status_is_1(tmp_path, capsys):
    narrow = CASES.replace("expect = [-100, 0]", "expect = [1, 2]").replace("1000.0, 1060.0", "1000.0")
    assert main(["sweep", str(write_study(tmp_path, narrow)), "--workers", "1"]) == 1
    assert capsys.readouterr().out.count("| **-") == 2


def test_a_study_whose_shots_are_refused_says_why(tmp_path, capsys):
    text = "scene = 'sphere-block'\n[keys]\n'mesh.size' = [-1.0]\n[columns]\ndepth = 'peak_depth'\n"
    assert main(["sweep", str(write_study(tmp_path, text))]) == 0
    told = capsys.readouterr()
    assert "row 1: refused: " in told.err and "mesh.size: found -1.0" in told.err and "| – |" in told.out
    wanted = text.replace("'peak_depth'", "{ value = 'peak_depth', expect = [0, 1] }")
    assert main(["sweep", str(write_study(tmp_path, wanted))]) == 1, "nothing is as expected"


@pytest.mark.parametrize(
    "text, remedy",
    [
        ("[[case]]\nset = { 'mesh.size' = 1e-3 }", "a table with a name"),
        ("[[case]]\nname = 'a'\nkeys = 3", "key of a case"),
        ("case = 3", "a list of tables"),
        ("fidelity = 'draft'\n[[case]]\nname = 'a'", "remove fidelity"),
        ("[columns]\ndepth = { value = 'peak_depth', expect = [2, 1] }", "the name of a value, or a table"),
        ("[columns]\ndepth = 3", "the name of a value, or a table"),
        ("[columns]\ndepth = { value = 'peak_depth', units = 'mm' }", "`unit`"),
        ("[columns]\ndepth = { value = 'peak_depth', unit = 'furlong' }", "unit of a column"),
        ("[columns]\ndepth = { value = 'peak_depth', format = 'x' }", "the name of a value, or a table"),
        ("[columns]\ndepth = { value = 'peak_depth', expect = [1] }", "the name of a value, or a table"),
    ],
)
def test_cases_and_columns_without_sense_are_refused_as_they_are_read(tmp_path, text, remedy):
    with pytest.raises(bg.GelfmuError, match=re.escape(remedy)):
        bg.Study.load(write_study(tmp_path, text))


def test_a_column_of_no_figure_names_the_nearest(tmp_path):
    study = bg.Study.load(write_study(tmp_path, CASES.replace('"peak_depth"', '"peak_deph"')))
    with pytest.raises(bg.GelfmuError, match="`peak_depth`"):
        study.run()
    assert not study.folder.exists(), "nothing was run"


def test_a_summand_is_added_before_the_division(tmp_path):
    study = bg.Study.load(write_study(tmp_path, "[columns]\nboth = { value = 'taken', plus = 'given', per = 'whole' }"))
    rows = pd.DataFrame({"taken": [-3.0], "given": [2.0], "whole": [4.0]})
    assert list(study.table_of(rows).values["both"]) == [-0.25]


def test_a_text_is_no_number_of_a_column(tmp_path):
    study = bg.Study.load(write_study(tmp_path, "[columns]\nend = { value = 'status', expect = [0, 1] }"))
    with pytest.raises(bg.GelfmuError, match="columns.end: found status"):
        study.table_of(pd.DataFrame({"status": ["completed"]}))


def test_a_study_without_rows_is_refused(tmp_path):
    with pytest.raises(bg.GelfmuError, match="found no rows"):
        bg.Study.load(write_study(tmp_path, "case = []")).count()


def test_every_study_of_the_repository_is_read_and_its_scenes_are_made():
    files = [path for path in STUDIES.glob("*.toml") if path.name != "Cargo.toml"]
    assert len(files) > 5
    for path in files:
        study = bg.Study.load(path)
        assert study.content["title"].endswith("?") and study.content["columns"]
        assert study.folder.resolve() == STUDIES.parent / "gelfmu-out" / "studies" / path.stem
        assert "#SBATCH --array=1-" in study.slurm_script(1000, "10", 1)
