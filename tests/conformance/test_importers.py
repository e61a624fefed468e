"""The system of gel and body in several importers."""

import platform
import sys

import pytest
import run_system

STOP, STEP = 4e-3, 2e-5
ON_LINUX = sys.platform == "linux" and platform.machine() == "x86_64"
FOREIGN = pytest.mark.skipif(not ON_LINUX, reason="there is no wheel for this platform")

EVERY = [
    "fmpy",
    pytest.param("libcosim", marks=FOREIGN),
    pytest.param("ecos", marks=FOREIGN),
    "container",
    "sequential-container",
    "loop",
]
JACOBI = ["fmpy", pytest.param("libcosim", marks=FOREIGN), pytest.param("ecos", marks=FOREIGN), "container"]


def run(systems, system, importer, step=STEP):
    """Total impulse, the gel's and the body's velocity at the end."""
    return run_system.IMPORTERS[importer](systems.folder / f"{system}.ssp", step, STOP)


@pytest.fixture(scope="module")
def alone(systems):
    """Total impulse and velocity of the gel that integrates the projectile, without any importer of systems."""
    gel = run_system.Loop(systems.folder / "gel-and-body.ssp")
    gel.start()
    gel.units["gel"].doStep(0.0, STOP)
    values = [gel.get(at) for at in run_system.WATCHED[:2]]
    gel.free()
    return values


@pytest.mark.parametrize("importer", EVERY)
def test_a_gel_that_integrates_gives_the_same_impulse_in_every_importer(systems, alone, importer):
    impulse, velocity, _ = run(systems, "gel-and-body", importer)
    assert [impulse, velocity] == pytest.approx(alone, rel=1e-12)


@pytest.mark.parametrize("importer", ["sequential-container", "sequential-loop"])
def test_a_body_that_steps_after_the_gel_lands_where_the_gel_predicts(systems, alone, importer):
    for step in (STEP, 10 * STEP):
        impulse, velocity, body = run(systems, "gel-and-body-corrected", importer, step)
        assert [impulse, velocity] == pytest.approx(alone, rel=1e-12)
        assert body == pytest.approx(velocity, rel=1e-12)


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
    errors = [run(systems, "gel-and-body-corrected", "loop", step)[0] / alone[0] - 1.0 for step in (4e-5, 8e-5)]
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
    ("gel", "contact.total_impulse[3]"),
    ("gel", "projectile.predicted_velocity[3]"),
    ("body", "velocity[3]"),
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
        gel, velocity, body, armour, pushed, height, perforated = run_armour(systems, importer)
        assert mass * (velocity + speed) == pytest.approx(gel + armour, rel=1e-12)
        assert body == pytest.approx(velocity, rel=1e-12)
        assert perforated == 1.0 and armour > 0.1 and gel > 0.01
        assert pushed < 0.0 < height, "the gel resists the bulge"
