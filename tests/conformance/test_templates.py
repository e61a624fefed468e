"""The templates of partners take the place of RigidBody.fmu, and give its results."""

import sys

import numpy as np
import pytest
import run_system
from conftest import ON_LINUX, ROOT

TEMPLATES = ROOT / "templates"
sys.path.insert(0, str(TEMPLATES))

from partner import OUTPUTS, RigidBody, scalars  # noqa: E402

STOP, STEP = 2e-3, 4e-5
SHOWN = [("body", name) for name in scalars(OUTPUTS)]


def end(systems, **partners):
    """Every output of the body at the end of a run, gel first."""
    ssp = systems.folder / "gel-and-body-corrected.ssp"
    return run_system.with_sequential_loop(ssp, STEP, STOP, SHOWN, partners)


def test_a_body_in_python_moves_as_the_packed_one(tumbling):
    body = RigidBody.of_fmu(tumbling.folder / "RigidBody.fmu")
    assert end(tumbling, body=body) == pytest.approx(end(tumbling), rel=1e-11, abs=1e-13)


def test_a_template_that_has_a_force_of_its_own_follows_it():
    class Falling(RigidBody):
        def own_wrench(self, time):
            return self.values["mass"] * np.array([0.0, 0.0, -9.81]), np.zeros(3)

    inertia = {f"inertia[{i}]": 1.0 for i in (1, 2, 3)}
    body = Falling({"mass": 2.0, "initial_orientation[1]": 1.0, **inertia})
    body.instantiate()
    body.initialise()
    for k in range(10):
        body.step(k * 0.1, 0.1)
    assert body.get("position[3]") == pytest.approx(-9.81 / 2, rel=1e-12)


def test_the_body_in_python_is_an_fmu_too(systems, tmp_path):
    from pythonfmu.builder import FmuBuilder

    FmuBuilder.build_FMU(TEMPLATES / "partner_fmu.py", dest=tmp_path, project_files=[TEMPLATES / "partner.py"])
    body = run_system.FmuUnit("body", tmp_path / "PythonBody.fmu")
    assert end(systems, body=body) == pytest.approx(end(systems), rel=1e-11, abs=1e-13)


GIVEN = {
    "impulse": [2e-5, 0.0, 1e-4],
    "angular_impulse": [1e-6, -2e-6, 0.0],
    "impulse_moment": [0.0, 0.0, 5e-10],
    "force": [0.0, 0.0, 3.0],
    "torque": [0.0, 0.2, 0.0],
}
STARTS = {
    "mass": [0.033],
    "inertia": [2e-6, 1.32e-6, 1.5e-6, 1e-7, 0.0, 2e-7],
    "initial_position": [0.0, 0.0, 0.01],
    "initial_velocity": [0.0, 0.0, -5.0],
    "initial_orientation": [0.8, 0.6, 0.0, 0.0],
    "initial_angular_velocity": [20.0, 0.0, 100.0],
}


def in_modelica(given, step, n):
    """Outputs of the block in Modelica after n steps with constant inputs, by the compiler rumoca."""
    import rumoca

    text = lambda values: "{" + ", ".join(f"{value:.17g}" for value in values) + "}"  # noqa: E731
    starts = "".join(f", {name} = {text(values)}" for name, values in STARTS.items() if name != "mass")
    inputs = "".join(f"  b.{name} = {text(values)};\n" for name, values in given.items())
    model = f"model Test\n  Partner b(step = {step}{starts});\nequation\n{inputs}end Test;\n"
    source = (TEMPLATES / "Partner.mo").read_text() + model
    result = rumoca.Session().loads(source, model="Test", filename="Test.mo").simulate(n * step, dt=step)
    return [float(np.asarray(result[f"b.{name}"])[-1]) for name in scalars(OUTPUTS)]


@pytest.mark.skipif(not ON_LINUX, reason="the lock has no compiler for this platform")
@pytest.mark.parametrize("predicted", [[0.0] * 4, [np.sqrt(0.5), 0.0, np.sqrt(0.5), 0.0]])
def test_the_block_in_modelica_moves_as_the_body_in_python(predicted):
    given = {**GIVEN, "predicted_orientation": predicted}
    sizes = {name: len(values) for name, values in STARTS.items()}
    body = RigidBody({name: STARTS[variable][i] for name, (variable, i) in scalars(sizes).items()})
    body.instantiate()
    body.initialise()
    for variable, values in given.items():
        body.values[variable][:] = values
    step, n = 1e-5, 10
    for k in range(n):
        body.step(k * step, step)
    expected = [body.get(name) for name in scalars(OUTPUTS)]
    assert in_modelica(given, step, n) == pytest.approx(expected, rel=1e-11, abs=1e-13)
