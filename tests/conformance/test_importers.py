"""The system of gel and body in several importers."""

import re
import zipfile
from pathlib import Path
from xml.etree import ElementTree

import pytest
import run_system
from conftest import ON_LINUX
from fmpy import read_model_description

STOP, STEP = 4e-3, 2e-5
WATCHED = [("gel", "projectile.depth"), ("body", "total_impulse[3]"), ("body", "velocity[3]")]
OWN = ["projectile.depth", "contact.total_impulse[3]", "projectile.predicted_velocity[3]"]
FOREIGN = pytest.mark.skipif(not ON_LINUX, reason="there is no wheel for this platform")

EVERY = [
    "fmpy",
    pytest.param("libcosim", marks=FOREIGN),
    pytest.param("ecos", marks=FOREIGN),
    "container",
    "sequential-container",
    "loop",
]
# Scalars wired in each: 13 per body, and 18 per armour, of which an axisymmetric gel takes two less.
SYSTEMS = {
    "gel-and-body": 13,
    "gel-and-body-corrected": 26,
    "gel-armour-body": 31,
    "gel-fragments": 39,
    "gel-soft-armour": 29,
}
JACOBI = ["fmpy", pytest.param("libcosim", marks=FOREIGN), pytest.param("ecos", marks=FOREIGN), "container"]


def run(systems, system, importer, step=STEP, stop=STOP):
    """Depth of the projectile in the gel, total impulse and velocity of the body at the end."""
    return run_system.IMPORTERS[importer](systems.folder / f"{system}.ssp", step, stop, WATCHED)


@pytest.fixture(scope="module")
def alone(systems):
    """Depth, total impulse and velocity of the gel that integrates the projectile, without any importer of systems."""
    gel = run_system.Loop(systems.folder / "gel-and-body.ssp")
    gel.start()
    gel.units["gel"].step(0.0, STOP)
    values = [gel.get(("gel", name)) for name in OWN]
    gel.free()
    return values


@pytest.mark.parametrize("system", SYSTEMS)
def test_what_a_system_wires_and_shows_is_a_port_of_its_fmus(systems, system):
    loop = run_system.Loop(systems.folder / f"{system}.ssp")
    kinds = {(name, v.name): v.causality for name, unit in loop.units.items() for v in unit.variables.values()}
    assert {kinds[at] for at in loop.system.outputs} == {"output"}
    assert {kinds[to] for _, to in loop.system.connections} == {"input"}
    assert all(start in loop.system.outputs for start, _ in loop.system.connections)
    assert len(loop.system.connections) == SYSTEMS[system]
    loop.free()


OMS = "{https://raw.githubusercontent.com/OpenModelica/OMSimulator/master/schema/oms.xsd}"
SSC, SSD = (f"{{http://ssp-standard.org/SSP1/SystemStructure{name}}}" for name in ("Common", "Description"))


@pytest.mark.parametrize("system", SYSTEMS)
def test_a_system_has_the_names_and_the_annotation_without_which_omsimulator_refuses_it(systems, system):
    ssp = systems.folder / f"{system}.ssp"
    with zipfile.ZipFile(ssp) as archive:
        root = ElementTree.fromstring(archive.read("SystemStructure.ssd"))
    names = [root.get("name"), *(each.get("name") for tag in ("System", "Component") for each in root.iter(SSD + tag))]
    assert names[0] == system.replace("-", "_") and all(re.fullmatch("[A-Za-z_][A-Za-z0-9_]*", name) for name in names)
    annotation = root.find(f"{SSD}System/{SSD}Annotations/{SSC}Annotation[@type='org.openmodelica']")
    master = annotation.find(f"{OMS}Annotations/{OMS}SimulationInformation/{OMS}FixedStepMaster")
    experiment = root.find(f"{SSD}DefaultExperiment")
    gel = systems.folder / Path(run_system.System(ssp).files["gel"]).name
    own = read_model_description(str(gel)).defaultExperiment
    assert master.get("description") == "oms-ma" and float(master.get("stepSize")) == float(own.stepSize)
    assert (experiment.get("startTime"), float(experiment.get("stopTime"))) == ("0", float(own.stopTime))


@pytest.mark.parametrize("importer", EVERY)
def test_a_gel_that_integrates_gives_the_same_depth_in_every_importer(systems, alone, importer):
    depth, *_ = run(systems, "gel-and-body", importer)
    assert depth == pytest.approx(alone[0], rel=1e-12)


@pytest.mark.parametrize("importer", EVERY)
def test_the_body_follows_the_gel_in_every_importer(systems, alone, importer):
    late = 0.0 if "sequential" in importer else STEP
    _, impulse, velocity = run(systems, "gel-and-body", importer, stop=STOP + late)
    assert [impulse, velocity] == pytest.approx(alone[1:], rel=1e-12)


@pytest.mark.parametrize("importer", ["sequential-container", "sequential-loop"])
def test_a_body_that_steps_after_the_gel_lands_where_the_gel_predicts(systems, alone, importer):
    for step in (STEP, 10 * STEP):
        assert run(systems, "gel-and-body-corrected", importer, step) == pytest.approx(alone, rel=1e-12)


def test_a_tilted_spinning_capsule_lands_where_the_gel_predicts(tumbling):
    ends = [(4, "orientation"), (3, "angular_velocity"), (3, "position"), (3, "velocity")]
    body = [("body", f"{name}[{i + 1}]") for n, name in ends for i in range(n)]
    gel = [("gel", "projectile.predicted_" + name) for _, name in body]
    for step in (STEP, 20 * STEP):
        ssp = tumbling.folder / "gel-and-body-corrected.ssp"
        values = run_system.with_sequential_loop(ssp, step, STOP, body + gel)
        assert values[: len(body)] == pytest.approx(values[len(body) :], rel=1e-11, abs=1e-14)
        assert abs(values[5] + 150.0) > 10.0, "the contact turned it"


@pytest.mark.parametrize("importer", JACOBI)
def test_importers_that_step_all_at_once_agree(systems, importer):
    expected = run(systems, "gel-and-body-corrected", "loop")
    assert run(systems, "gel-and-body-corrected", importer) == pytest.approx(expected, rel=1e-12)


def test_stepping_all_at_once_costs_the_first_order_of_the_step(systems, alone):
    steps = (4e-5, 8e-5)
    runs = [run(systems, "gel-and-body-corrected", "loop", step, STOP + step) for step in steps]
    errors = [impulse / alone[1] - 1.0 for _, impulse, _ in runs]
    assert 1.5 < errors[1] / errors[0] < 2.5 and errors[0] > 1e-3


def test_a_zero_quaternion_is_unset_before_the_first_step_alone(make):
    gel = make()
    gel.start(mode=3)
    for name, n in [("position", 3), ("velocity", 3), ("orientation", 4), ("angular_velocity", 3)]:
        gel.set(f"projectile.{name}", [0.0] * n)
    gel.fmu.doStep(0.0, STEP)
    assert gel.get("projectile.predicted_velocity")[2] == pytest.approx(-5.0, rel=0.1)
    with pytest.raises(Exception, match="fmi2DoStep failed"):
        gel.fmu.doStep(STEP, STEP)


ARMOUR = [
    ("body", "total_impulse[3]"),
    ("body", "velocity[3]"),
    ("gel", "projectile.depth"),
    ("armour", "impulse.projectile"),
    ("armour", "impulse.gel"),
    ("armour", "height"),
    ("armour", "perforated"),
]


def run_armour(systems, importer, step=1e-5, stop=8e-4):
    return run_system.IMPORTERS[importer](systems.folder / "gel-armour-body.ssp", step, stop, ARMOUR)


@pytest.mark.parametrize("importer", JACOBI)
def test_gel_armour_and_body_agree_in_importers_that_step_all_at_once(systems, importer):
    assert run_armour(systems, importer) == pytest.approx(run_armour(systems, "loop"), rel=1e-9)


def test_what_the_projectile_loses_is_what_gel_and_armour_took(systems):
    mass, speed = 0.033, 20.0
    for importer in ("sequential-loop", "sequential-container"):
        gel, velocity, depth, armour, pushed, height, perforated = run_armour(systems, importer)
        assert mass * (velocity + speed) == pytest.approx(gel + armour, rel=1e-12) and depth > 0.0
        assert perforated == 1.0 and armour > 0.1 and gel > 0.01
        assert pushed < 0.0 < height, "the gel resists the bulge"


def test_the_body_behind_the_armour_is_where_the_gel_predicts(systems):
    ends = ["position[3]", "velocity[3]"]
    watched = [("body", name) for name in ends] + [("gel", f"projectile.predicted_{name}") for name in ends]
    values = run_system.with_sequential_loop(systems.folder / "gel-armour-body.ssp", 1e-5, 8e-4, watched)
    assert values[:2] == pytest.approx(values[2:], rel=1e-11)


OWNERS = ["projectile", "fragment[1]", "fragment[2]"]
DEPTHS = [("gel", f"{owner}.depth") for owner in OWNERS]
MOTIONS = ["velocity[1]", "velocity[3]", "angular_velocity[1]"]
FOLLOWERS = [(f"fragment{i}", name) for i in (1, 2, 3) for name in MOTIONS[:2]]


@pytest.fixture(scope="module")
def fragments_alone(systems):
    """Depths and velocities of three fragments that the gel integrates, in one step of 1.5 ms."""
    loop = run_system.Loop(systems.folder / "gel-fragments.ssp")
    loop.start()
    loop.units["gel"].step(0.0, 1.5e-3)
    predicted = [("gel", f"{owner}.predicted_{name}") for owner in OWNERS for name in MOTIONS[:2]]
    values = [loop.get(at) for at in DEPTHS + predicted]
    loop.free()
    return values


@pytest.mark.parametrize("importer", EVERY)
def test_three_fragments_and_their_partners_move_alike_in_every_importer(systems, fragments_alone, importer):
    ssp, step, stop = systems.folder / "gel-fragments.ssp", 3e-5, 1.5e-3
    depths = run_system.IMPORTERS[importer](ssp, step, stop, DEPTHS)
    assert depths == pytest.approx(fragments_alone[:3], rel=1e-12) and min(depths) > 5e-3
    late = 0.0 if "sequential" in importer else step
    velocities = run_system.IMPORTERS[importer](ssp, step, stop + late, FOLLOWERS)
    assert velocities == pytest.approx(fragments_alone[3:], rel=1e-12, abs=1e-13)


def test_each_fragment_turns_with_its_own_partner(systems):
    followers = [(f"fragment{i}", name) for i in (1, 2, 3) for name in MOTIONS]
    predicted = [("gel", f"{owner}.predicted_{name}") for owner in OWNERS for name in MOTIONS]
    ssp = systems.folder / "gel-fragments.ssp"
    values = run_system.with_sequential_loop(ssp, 1e-4, 1.5e-3, followers + predicted)
    assert values[:9] == pytest.approx(values[9:], rel=1e-11, abs=1e-12)
    speeds = [values[i] for i in (1, 4, 7)]
    assert len({round(speed, 1) for speed in speeds}) == 3 and abs(values[8] - 100.0) > 1.0, "the cuboid is turned"
