"""The partners of the gel are FMUs in their own right."""

import numpy as np
import pytest
from fmpy.validation import validate_fmu
from own_body import Gel as Unit

MASS, SPEED = 0.033, 20.0


@pytest.fixture
def partner(systems, request):
    """A function that makes instances of a partner; they are freed after the test."""
    made = []

    def one(name):
        made.append(Unit(systems.unpacked(name), name))
        return made[-1]

    yield one
    for unit in made:
        unit.free()


def strike(plate, body, step, stop):
    """A ball flies onto the plate, without gel behind it."""
    body.set("initial_position", [0.0, 0.0, 0.015])
    body.set("initial_velocity", [0.0, 0.0, -SPEED])
    plate.start()
    body.start()
    for k in range(round(stop / step)):
        for name in ("position", "velocity"):
            plate.set(f"projectile.{name}", body.get(name))
        plate.fmu.doStep(k * step, step)
        body.set("force", plate.get("force"))
        body.fmu.doStep(k * step, step)


def one(unit, name):
    return unit.get(name, 1)[0]


@pytest.mark.parametrize("name", ["RigidBody", "Armour"])
def test_fmpy_finds_no_problem(systems, name):
    assert validate_fmu(str(systems.folder / f"{name}.fmu")) == []


def test_a_body_under_a_constant_force_flies_a_parabola_whatever_the_step(partner):
    for n in (1, 3, 10):
        body, stop, force = partner("RigidBody"), 0.3, np.array([0.1, 0.2, -0.3])
        body.start()
        body.set("force", force)
        for k in range(n):
            body.fmu.doStep(k * stop / n, stop / n)
        fall = np.array([0.0, 0.0, 0.010]) + np.array([0.0, 0.0, -5.0]) * stop + force * stop**2 / MASS / 2
        assert np.allclose(body.get("position"), fall, rtol=0, atol=1e-13)
        assert np.allclose(body.get("velocity"), [0, 0, -5.0] + force * stop / MASS, rtol=0, atol=1e-13)


def test_a_body_keeps_its_angular_momentum_and_turns_by_its_inertia(partner):
    body = partner("RigidBody")
    inertia, spin = np.array([1e-6, 2e-6, 4e-6]), np.array([300.0, 20.0, -40.0])
    body.set("inertia", [*inertia, 0.0, 0.0, 0.0])
    body.set("initial_angular_velocity", spin)
    body.start()
    body.set("angular_impulse", [1e-6, 0.0, 0.0])
    body.fmu.doStep(0.0, 1e-5)
    assert np.allclose(body.get("angular_momentum"), inertia * spin + [1e-6, 0.0, 0.0], rtol=1e-14)
    quarter = np.sqrt(0.5)
    body.set("predicted_orientation", [quarter, 0.0, 0.0, quarter])
    body.fmu.doStep(1e-5, 1e-5)
    x, y, z = body.get("angular_momentum")
    turned = [x / inertia[1], y / inertia[0], z / inertia[2]]
    assert np.allclose(body.get("angular_velocity"), turned, rtol=1e-12), "a quarter turn about z exchanges x and y"


def test_momentum_of_plate_and_projectile_closes(partner):
    for step in (5e-6, 2e-5):
        plate, body = partner("Armour"), partner("RigidBody")
        strike(plate, body, step, 1e-3)
        lost = MASS * (SPEED + body.get("velocity")[2])
        assert one(plate, "perforated") == 1.0 and lost > 0.1 * MASS * SPEED
        assert lost == pytest.approx(one(plate, "impulse.projectile"), rel=1e-12)
        sources = sum(one(plate, f"impulse.{source}") for source in ("projectile", "gel", "support"))
        assert one(plate, "momentum") == pytest.approx(sources, rel=1e-11)


def test_energy_of_plate_and_projectile_closes_with_the_second_order_of_the_step(partner):
    left = []
    for step in (1e-5, 2e-5, 4e-5):
        plate, body = partner("Armour"), partner("RigidBody")
        strike(plate, body, step, 1e-3)
        kept = MASS * body.get("velocity")[2] ** 2 / 2
        kept += sum(one(plate, f"energy.{kind}") for kind in ("kinetic", "elastic", "plastic"))
        left.append(abs(kept - MASS * SPEED**2 / 2))
    assert left[-1] < 1e-3 * MASS * SPEED**2 / 2
    assert all(3.0 < coarse / fine < 7.0 for fine, coarse in zip(left, left[1:], strict=False)), left


def test_a_slow_projectile_is_stopped_and_does_not_perforate(partner):
    plate, body = partner("Armour"), partner("RigidBody")
    plate.set("yield_force", 4000.0)
    strike(plate, body, 1e-5, 2e-3)
    assert one(plate, "perforated") == 0.0 and one(plate, "penetration") < 5e-3
    assert body.get("velocity")[2] > -0.5 * SPEED


def test_the_bulge_answers_to_the_gel(partner):
    heights = []
    for impulse in (0.0, -1e-3):
        plate, body = partner("Armour"), partner("RigidBody")
        plate.set("bulge_height_impulse", impulse)
        strike(plate, body, 1e-5, 1e-3)
        heights.append(one(plate, "height"))
        assert one(plate, "impulse.gel") == pytest.approx(100 * impulse, rel=1e-9)
    assert heights[0] > heights[1]


def test_the_bulge_does_not_go_back_behind_the_plate(partner):
    plate = partner("Armour")
    plate.start()
    plate.set("projectile.position", [0.0, 0.0, 1.0])
    plate.set("bulge_height_impulse", -1e-3)
    for k in range(20):
        plate.fmu.doStep(k * 1e-5, 1e-5)
        assert one(plate, "height") == 0.0
    assert one(plate, "impulse.gel") == pytest.approx(-0.02, rel=1e-12)
    assert one(plate, "impulse.support") == pytest.approx(0.02, rel=1e-3)
    assert abs(one(plate, "energy.closure")) < 1e-6


def test_the_bulge_is_given_with_the_step_that_it_made(partner):
    plate, body = partner("Armour"), partner("RigidBody")
    strike(plate, body, 1e-5, 3e-4)
    height, rate = one(plate, "bulge_height"), one(plate, "bulge_height_rate")
    assert one(plate, "height") == pytest.approx(height + 1e-5 * rate, rel=1e-14) and rate > 1.0
    assert one(plate, "bulge_radius") == pytest.approx(0.015 + height, rel=1e-14), "a metre of radius per metre of height"
    assert one(plate, "bulge_radius_rate") == rate


def test_a_state_that_is_set_again_continues_with_the_same_bits(partner):
    plate, body = partner("Armour"), partner("RigidBody")
    strike(plate, body, 1e-5, 2e-4)
    saved = plate.fmu.getFMUState()
    content = plate.fmu.serializeFMUstate(saved)

    def on(unit):
        for k in range(20, 60):
            unit.fmu.doStep(k * 1e-5, 1e-5)
        return [one(unit, "height"), *unit.get("force"), one(unit, "energy.plastic"), one(unit, "impulse.support")]

    first = on(plate)
    plate.fmu.setFMUState(saved)
    assert on(plate) == first
    plate.fmu.freeFMUState(saved)
    other = partner("Armour")
    other.fmu.setFMUState(other.fmu.deSerializeFMUstate(content))
    assert on(other) == first, "also in an instance where nothing was set up"


def test_what_is_not_meant_is_refused(partner):
    body = partner("RigidBody")
    refusals = [
        lambda: body.set("position", [0.0, 0.0, 0.0]),
        lambda: body.set("mass", 1.0),
        lambda: body.set("force", [float("nan"), 0.0, 0.0]),
        lambda: body.fmu.doStep(1e-5, 1e-5),
        lambda: body.fmu.doStep(0.0, 0.0),
        lambda: body.fmu.getReal([10_000]),
        lambda: body.fmu.getInteger([0]),
        lambda: body.fmu.deSerializeFMUstate(b"not a state"),
    ]
    body.start()
    for refused in refusals:
        with pytest.raises(Exception, match="failed with status 3"):
            refused()
    body.fmu.doStep(0.0, 1e-5)


def test_a_body_without_mass_is_refused_before_it_starts(partner):
    body = partner("RigidBody")
    body.set("mass", 0.0)
    with pytest.raises(Exception, match="fmi2ExitInitializationMode failed"):
        body.start()
