"""The packed FMUs that the driver in tests/conformance.rs made, unpacked once."""

import os
import platform
import sys
from pathlib import Path

import pytest
from fmpy import extract

ROOT = Path(__file__).resolve().parents[2]
ON_LINUX = sys.platform == "linux" and platform.machine() == "x86_64"
sys.path.insert(0, str(ROOT / "examples"))

from own_body import Gel  # noqa: E402


@pytest.fixture(scope="session")
def fmu():
    """`sphere-block` as it is built in."""
    return os.environ["BALLISTIC_GEL_FMU"]


@pytest.fixture(scope="session")
def unpacked(fmu, tmp_path_factory):
    """Its folder, with a space and an umlaut in the name."""
    return extract(fmu, str(tmp_path_factory.mktemp("fu\u00df ball")))


@pytest.fixture(scope="session")
def coarse_fmu():
    """A coarse and therefore quick `sphere-block`."""
    return os.environ["BALLISTIC_GEL_COARSE_FMU"]


@pytest.fixture(scope="session")
def other_fmu():
    """A coarse `fbi-bb`."""
    return os.environ["BALLISTIC_GEL_OTHER_FMU"]


@pytest.fixture(scope="session")
def coarse(coarse_fmu, tmp_path_factory):
    """The folder of the coarse `sphere-block`."""
    return extract(coarse_fmu, str(tmp_path_factory.mktemp("coarse")))


@pytest.fixture(scope="session")
def fragments_fmu():
    """A scene with two fragments, one of which waits."""
    return os.environ["BALLISTIC_GEL_FRAGMENTS_FMU"]


@pytest.fixture(scope="session")
def fragments_folder(fragments_fmu, tmp_path_factory):
    """Its folder."""
    return extract(fragments_fmu, str(tmp_path_factory.mktemp("fragments")))


class Systems:
    """The folder of partners and systems; what is unpacked is unpacked once."""

    def __init__(self, folder, scratch):
        self.folder, self.scratch, self.known = Path(folder), scratch, {}

    def unpacked(self, name):
        if name not in self.known:
            self.known[name] = extract(str(self.folder / f"{name}.fmu"), str(self.scratch / name))
        return self.known[name]


@pytest.fixture(scope="session")
def systems(tmp_path_factory):
    """The partners and the systems with them, with the coarse scene."""
    return Systems(os.environ["BALLISTIC_GEL_SYSTEMS"], tmp_path_factory.mktemp("systems"))


@pytest.fixture(scope="session")
def tumbling(tmp_path_factory):
    """The systems with a tilted, spinning capsule."""
    return Systems(os.environ["BALLISTIC_GEL_TUMBLING_SYSTEMS"], tmp_path_factory.mktemp("tumbling"))


@pytest.fixture
def make(coarse):
    """A function that makes instances of the coarse scene; they are freed after the test."""
    made = []

    def one(folder=coarse, name="gel"):
        made.append(Gel(folder, name))
        return made[-1]

    yield one
    for gel in made:
        gel.free()


@pytest.fixture
def partner(systems, request):
    """A function that makes instances of a partner; they are freed after the test."""
    made = []

    def one(name):
        made.append(Gel(systems.unpacked(name), name))
        return made[-1]

    yield one
    for unit in made:
        unit.free()
