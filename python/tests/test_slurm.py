"""Script for SLURM: an array of its tasks, as a cluster would run them, gives the table of one sweep."""

import os
import re
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import pytest

import ballistic_gel as bg
from ballistic_gel.__main__ import main

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="the script is one of bash")

STUDY = """
scene = "ball-bounce"
out = "rows of study"
[set]
"scene.end_time" = 2e-4
"mesh.size" = 4e-3
[keys]
"projectile.velocity[3]" = [-2.0, -1.5, -1.0, -0.5, -0.25]
"""


def submit(script):
    """Run the array of a script, two tasks at a time, and return the rows that each task tells."""
    assert "#SBATCH --job-name='my study'\n" in script.read_text(), "SLURM refuses a name of two words"
    first, last = map(int, re.search(r"^#SBATCH --array=(\d+)-(\d+)$", script.read_text(), re.MULTILINE).groups())

    def run(task):
        variables = os.environ | {"SLURM_ARRAY_TASK_ID": str(task)}
        done = subprocess.run(["bash", str(script)], env=variables, capture_output=True, text=True, timeout=60)
        assert done.returncode == 0, done.stderr
        return done.stdout

    with ThreadPoolExecutor(2) as executor:
        return list(executor.map(run, range(first, last + 1)))


@pytest.fixture
def script(tmp_path, capsys):
    """A study of five shots, its name with a space, as an array of three tasks."""
    study = tmp_path / "my study.toml"
    study.write_text(STUDY)
    assert main(["slurm", str(study), "--tasks", "3"]) == 0
    made = tmp_path / "array.sh"
    made.write_text(capsys.readouterr().out)
    return made


def test_the_tasks_of_an_array_give_the_table_of_one_sweep(script, tmp_path):
    assert len(submit(script)) == 3
    study = bg.Study.load(tmp_path / "my study.toml")
    # Each task writes its own rows; the tables are there once one has found all, or after the command in the script.
    again = re.search(r"^#   (.+)$", script.read_text(), re.MULTILINE).group(1)
    subprocess.run(["bash", "-c", again], check=True, capture_output=True, timeout=60)
    bg.sweep(study.scene(), study.samples(), tmp_path / "whole", workers=1)
    tables = [(tmp_path / name / "results.csv").read_bytes() for name in ("rows of study", "whole")]
    assert tables[0] == tables[1]


def test_an_array_that_is_submitted_again_runs_what_is_missing(script, tmp_path):
    submit(script)
    rows = sorted((tmp_path / "rows of study" / "rows").glob("*.json"))
    assert len(rows) == 5
    rows[0].unlink()
    times = {row: row.stat().st_mtime_ns for row in rows[1:]}
    assert any(told.startswith("5 completed") for told in submit(script))
    assert rows[0].exists() and all(row.stat().st_mtime_ns == at for row, at in times.items())


@pytest.mark.parametrize("name", ["study\ntouch run.toml", "study\r.toml", "tab\t.toml"])
def test_a_study_whose_name_has_a_control_character_is_refused(tmp_path, name):
    (tmp_path / name).write_text(STUDY)
    with pytest.raises(bg.GelfmuError, match="^study: found .*, expected a text without line feeds"):
        bg.Study.load(tmp_path / name)


def test_an_option_that_would_be_run_is_refused(tmp_path):
    (tmp_path / "study.toml").write_text(STUDY)
    study = bg.Study.load(tmp_path / "study.toml")
    for time in ("01:00:00\ntouch run", "1 --wrap=touch", "soon", 60):
        with pytest.raises(bg.GelfmuError, match="^time: found .*, expected a time limit of SLURM"):
            study.slurm_script(3, time, 1)
    for name, numbers in (("tasks", ("3\ntouch run", 1)), ("cores", (3, "1\ntouch run")), ("cores", (3, -1))):
        with pytest.raises(bg.GelfmuError, match=f"^{name}: found .*, expected a whole number"):
            study.slurm_script(numbers[0], "1-12", numbers[1])
    assert "#SBATCH --time=1-12:30\n" in study.slurm_script(3, "1-12:30", 1)
