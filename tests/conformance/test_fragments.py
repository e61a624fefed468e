"""A packed scene with fragments: what its description says of each body, and that it runs."""

import pytest
from fmpy import read_model_description
from fmpy.validation import validate_fmu


@pytest.fixture(scope="module")
def variables(fragments_fmu):
    return {v.name: v for v in read_model_description(fragments_fmu).modelVariables}


def test_fmpy_finds_no_problem(fragments_fmu):
    assert validate_fmu(fragments_fmu) == []


def test_every_fragment_of_the_scene_has_variables_and_no_other(variables):
    bodies = {name.split(".")[0] for name in variables if name.startswith("fragment")}
    assert bodies == {"fragment[1]", "fragment[2]"}
    own, dome = [
        {name.split(".", 1)[1] for name in variables if name.startswith(f"fragment[{i}].")} for i in (1, 2)
    ]
    moves = {f"{name}[{i}]" for name in ("position", "velocity", "angular_velocity") for i in (1, 2, 3)}
    moves |= {f"orientation[{i}]" for i in (1, 2, 3, 4)}
    forces = {f"{name}[{i}]" for name in ("external_force", "external_torque") for i in (1, 2, 3)}
    bulges = {name for name in dome if "bulge" in name}
    assert own - dome == moves | forces and dome - own == bulges and len(bulges) == 6
    assert {"contact.linear_force[3]", "coupling.energy_residual", "active", "predicted_position[3]"} <= own & dome
    references = [v.valueReference for v in variables.values()]
    assert len(set(references)) == len(references)


def test_starts_are_those_of_each_body(variables):
    starts = {name: v.start for name, v in variables.items()}
    active = ("projectile.active", "fragment[1].active", "fragment[2].active")
    assert [starts[name] for name in active] == ["true", "false", "true"]
    assert [variables[name].type for name in active] == ["Boolean"] * 3
    assert float(starts["fragment[1].mass"]) == 0.02 and float(starts["projectile.mass"]) == 0.033
    assert float(starts["fragment[1].position[1]"]) == 0.03 and float(starts["fragment[1].velocity[3]"]) == -4.0
    assert float(starts["fragment[2].bulge_radius"]) == 0.015 and float(starts["fragment[2].bulge_height"]) == 0.0


def test_nothing_that_is_offered_feeds_through(fragments_fmu):
    outputs = read_model_description(fragments_fmu).outputs
    assert {unknown.variable.name for unknown in outputs if unknown.dependencies} == set() and len(outputs) > 40


def test_the_first_outputs_of_a_fragment_come_from_the_parameters_alone(fragments_fmu):
    unknowns = read_model_description(fragments_fmu).initialUnknowns
    fragments = [u for u in unknowns if u.variable.name.startswith("fragment[2].")]
    assert {u.variable.causality for u in fragments} == {"output", "calculatedParameter"}
    for unknown in fragments:
        names = {v.name for v in unknown.dependencies}
        assert {v.causality for v in unknown.dependencies} == {"parameter"}
        assert {"fragment[1].mass", "fragment[2].initial_position[3]", "projectile.mass"} <= names


def test_a_fragment_that_waits_flies_once_it_is_active(make, fragments_folder):
    gel = make(fragments_folder)
    gel.start()
    gel.fmu.doStep(0.0, 1e-4)
    assert gel.get("fragment[1].predicted_position").tolist() == [0.03, 0.0, 0.02]
    gel.fmu.setBoolean([gel.variables["fragment[1].active"].valueReference], [True])
    gel.fmu.doStep(1e-4, 1e-4)
    assert gel.get("fragment[1].predicted_position")[2] == pytest.approx(0.02 - 4e-4, rel=1e-14)
