"""Studies: what a TOML file says, and what is refused."""

import pytest

import ballistic_gel as bg
from ballistic_gel.__main__ import main


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
