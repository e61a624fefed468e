"""Scenes of milliseconds, and one deep shot, for all tests. `gelfmu` is that of the variable GELFMU or the path."""

import os

import pytest

import ballistic_gel as bg

os.environ.setdefault("MPLBACKEND", "Agg")


@pytest.fixture(scope="session")
def quick():
    """A ball on coarse cells, for 20 communication steps: about 10 ms."""
    return bg.Scene.built_in("ball-bounce").with_values({"scene.end_time": 2e-4, "mesh.size": 4e-3})


@pytest.fixture(scope="session")
def long_scene():
    """A shot of some seconds, to be interrupted."""
    return bg.Scene.built_in("fbi-bb").with_values({"scene.fidelity": "coarse"})


@pytest.fixture(scope="session")
def layered(tmp_path_factory):
    """The same shot for a fifth of a millisecond, into two layers and the gel."""
    folder = tmp_path_factory.mktemp("layered")
    layers = '\n[[layer]]\nname = "NA"\nthickness = 0.01\n[[layer]]\nthickness = 0.008\n'
    scene = folder / "two.toml"
    scene.write_text(bg.Scene.built_in("fbi-bb").text + layers, encoding="utf-8")
    values = {"scene.end_time": 2e-4, "mesh.size": 2e-3}
    return bg.run(scene, values=values, out=folder / "shot", frames=False, report=False, threads=1)


@pytest.fixture(scope="session")
def deep(tmp_path_factory):
    """The first millisecond of the calibration shot, with frames."""
    values = {"scene.end_time": 1e-3, "output.frames": 3}
    out = tmp_path_factory.mktemp("deep") / "shot"
    return bg.run("fbi-bb", values=values, fidelity="draft", out=out, report=False, threads=1)
