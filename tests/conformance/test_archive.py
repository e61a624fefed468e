"""What is in the archive."""

import zipfile

from fmpy import read_model_description
from fmpy.validation import validate_fmu


def test_fmpy_finds_no_problem(fmu):
    assert validate_fmu(fmu) == []


def test_entries_are_sorted_and_carry_no_time(fmu):
    with zipfile.ZipFile(fmu) as archive:
        entries = archive.infolist()
    names = [e.filename for e in entries]
    assert names == sorted(names)
    assert {e.date_time for e in entries} == {(1980, 1, 1, 0, 0, 0)}
    assert {"modelDescription.xml", "model.png", "documentation/index.html", "resources/scene.toml"} <= set(names)
    assert any(name.startswith("binaries/") for name in names)
    assert "documentation/licenses/linked-crates.txt" in names


def test_the_default_experiment_is_that_of_the_scene(fmu):
    experiment = read_model_description(fmu).defaultExperiment
    assert [float(t) for t in (experiment.startTime, experiment.stopTime, experiment.stepSize)] == [0.0, 0.01, 1e-5]


def test_every_capability_is_declared(fmu):
    offered = read_model_description(fmu).coSimulation
    assert offered.canHandleVariableCommunicationStepSize and offered.canInterpolateInputs
    assert offered.canGetAndSetFMUstate and offered.canSerializeFMUstate and offered.providesDirectionalDerivative
    assert offered.maxOutputDerivativeOrder == 1 and not offered.canRunAsynchronuously


def test_nothing_feeds_through_but_the_carrier_of_the_derivative(fmu):
    for unknown in read_model_description(fmu).outputs:
        inputs = {v.name.split("[")[0] for v in unknown.dependencies}
        carrier = unknown.variable.name.startswith("contact.linear_force")
        assert inputs == ({"projectile.position", "projectile.velocity"} if carrier else set())
