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
    ],
)
def test_a_wrong_study_is_refused_with_the_remedy(tmp_path, text, remedy):
    with pytest.raises(bg.GelfmuError) as refused:
        bg.Study.load(write_study(tmp_path, text)).samples()
    assert remedy in refused.value.remedy


def test_the_command_line_tells_errors_and_writes_cluster_scripts(tmp_path, capsys):
    assert main(["sweep", str(tmp_path / "none.toml")]) == 2
    assert "error: study" in capsys.readouterr().err
    path = write_study(tmp_path, "scene = 'fbi-bb'")
    assert main(["slurm", str(path), "--tasks", "20", "--cores", "4"]) == 0
    script = capsys.readouterr().out
    assert script.startswith("#!/bin/bash") and "#SBATCH --array=1-20" in script
    assert '--share "$SLURM_ARRAY_TASK_ID/20" --workers 4' in script
