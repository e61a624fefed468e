"""examples/run_system.py as a command, and what its loop leaves behind."""

import sys
from pathlib import Path

import pytest
import run_system


def test_arguments_that_make_no_sense_get_the_usage(capsys):
    for arguments in ([], ["a.ssp", "loop", "1e-5"], ["a.ssp", "no-importer", "1e-5", "1e-4"]):
        assert run_system.main(arguments) == 2
        said = capsys.readouterr()
        assert said.out == "" and said.err.startswith("usage: run_system.py SSP IMPORTER STEP STOP")
        assert "reversed-loop" in said.err


def test_a_file_that_is_not_there_is_an_error_without_a_traceback(capsys):
    assert run_system.main(["nowhere.ssp", "loop", "1e-5", "1e-4"]) == 1
    said = capsys.readouterr().err
    assert said.startswith("error: loop: ") and "nowhere.ssp" in said and len(said.splitlines()) == 1


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere its library brings what it needs")
def test_a_missing_library_of_ecos_is_named(systems, monkeypatch, tmp_path):
    monkeypatch.setattr(sys, "prefix", str(tmp_path))
    with pytest.raises(RuntimeError, match="pip install tbb"):
        run_system.with_ecos(systems.folder / "gel-and-body.ssp", 1e-5, 1e-5)


UNKNOWN = {"watched": [("gel", "no such variable")]}
TWICE = {"order": [["gel"], ["gel"]]}


@pytest.mark.parametrize("fault", [UNKNOWN, TWICE])
def test_the_loop_frees_its_fmus_after_an_error(systems, monkeypatch, fault):
    made = []

    class Kept(run_system.Loop):
        def __init__(self, *options):
            super().__init__(*options)
            made.append(self)

    monkeypatch.setattr(run_system, "Loop", Kept)
    with pytest.raises(Exception, match="no such variable|fmi2DoStep failed with status 3"):
        run_system.with_loop(systems.folder / "gel-and-body.ssp", 1e-5, 1e-5, **fault)
    [loop] = made
    folders = [loop.folder, *(unit.folder for unit in loop.units.values())]
    assert len(folders) == 3 and not any(Path(folder).exists() for folder in folders)
