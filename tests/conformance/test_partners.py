"""The partners of the gel are FMUs in their own right."""

import numpy as np
import pytest
from fmpy.validation import validate_fmu

MASS, SPEED = 0.033, 20.0


def one(unit, name):
    return unit.get(name, 1)[0]


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
    assert abs(one(plate, "energy.imbalance")) < 1e-6


def test_the_bulge_is_given_with_the_step_that_it_made(partner):
    plate, body = partner("Armour"), partner("RigidBody")
    strike(plate, body, 1e-5, 3e-4)
    height, rate = one(plate, "bulge_height"), one(plate, "bulge_height_rate")
    assert one(plate, "height") == pytest.approx(height + 1e-5 * rate, rel=1e-14) and rate > 1.0
    assert one(plate, "bulge_radius") == pytest.approx(0.015 + height, rel=1e-14), "a metre of radius per metre of height"
    assert one(plate, "bulge_radius_rate") == rate


def test_a_torque_turns_a_body_that_nobody_predicts(partner):
    body, step, n = partner("RigidBody"), 1e-4, 8
    start = np.array([0.5, 0.5, -0.5, 0.5])
    body.set("initial_orientation", start)
    body.set("initial_angular_velocity", [0.0, 40.0, 0.0])
    body.start()
    torque = np.array([0.0, 2e-3, 0.0])
    body.set("torque", torque)
    angle = 0.0
    for k in range(n):
        angle += body.get("angular_velocity")[1] * step
        body.fmu.doStep(k * step, step)
    assert np.allclose(body.get("angular_momentum"), 1.32e-6 * np.array([0, 40.0, 0]) + torque * n * step, rtol=1e-12)
    assert body.get("angular_velocity")[1] == pytest.approx(40.0 + 2e-3 * n * step / 1.32e-6, rel=1e-12)
    turned = product([np.cos(angle / 2), 0.0, np.sin(angle / 2), 0.0], start)
    assert np.allclose(body.get("orientation", 4), turned, rtol=0, atol=1e-13), "it turns about the axis of the world"


def product(p, q):
    """Hamilton product of two quaternions."""
    (a, u), (b, v) = (p[0], np.array(p[1:])), (q[0], np.array(q[1:]))
    return [a * b - u @ v, *(a * v + b * u + np.cross(u, v))]


def test_every_entry_of_the_inertia_tensor_counts_and_is_in_the_frame_of_the_body(partner):
    tensor = np.array([[2.0, 0.1, 0.2], [0.1, 3.0, 0.3], [0.2, 0.3, 4.0]]) * 1e-6
    spin, s = np.array([30.0, -20.0, 10.0]), np.sqrt(0.5)
    for orientation, turn in [
        ([1, 0, 0, 0], np.eye(3)),
        ([s, s, 0, 0], np.array([[1.0, 0, 0], [0, 0, -1.0], [0, 1.0, 0]])),
    ]:
        body = partner("RigidBody")
        body.set("inertia", [2e-6, 3e-6, 4e-6, 0.1e-6, 0.2e-6, 0.3e-6])
        body.set("initial_orientation", orientation)
        body.set("initial_angular_velocity", spin)
        body.start()
        assert np.allclose(body.get("angular_momentum"), turn @ tensor @ turn.T @ spin, rtol=1e-12)
        assert np.allclose(body.get("angular_velocity"), spin, rtol=1e-12)


def far_from_the_projectile(plate):
    plate.start()
    plate.set("projectile.position", [0.0, 0.0, 1.0])


def test_an_impulse_on_the_base_radius_works_through_the_spread(partner):
    states = []
    for name, impulse in (("bulge_height_impulse", 4e-4), ("bulge_radius_impulse", 2e-4)):
        plate = partner("Armour")
        plate.set("spread", 2.0)
        far_from_the_projectile(plate)
        plate.set(name, impulse)
        for k in range(5):
            plate.fmu.doStep(k * 1e-5, 1e-5)
        assert one(plate, "impulse.gel") == pytest.approx(5 * 4e-4, rel=1e-12)
        states.append([one(plate, each) for each in ("height", "momentum", "energy.gel", "energy.imbalance")])
    assert states[0] == pytest.approx(states[1], rel=1e-12) and states[0][0] > 0.0


def test_a_membrane_that_yields_holds_no_more_than_its_yield_force(partner):
    plate, step, pull = partner("Armour"), 1e-5, 250.0
    far_from_the_projectile(plate)
    plate.set("bulge_height_impulse", pull * step)
    momenta = []
    for k in range(40):
        plate.fmu.doStep(k * step, step)
        momenta.append(one(plate, "momentum"))
    assert momenta[-1] - momenta[-2] == pytest.approx((pull - 150.0) * step, rel=1e-9)
    height, left = one(plate, "height"), one(plate, "membrane_set")
    assert height - left == pytest.approx(150.0 / 1e6, rel=1e-6) and left > 1e-4
    assert one(plate, "energy.plastic") == pytest.approx(150.0 * left, rel=1e-6)
    assert one(plate, "energy.elastic") == pytest.approx(150.0**2 / 1e6 / 2, rel=1e-6)


def test_a_bulge_that_is_there_from_the_start_is_at_rest_and_spreads_from_there(partner):
    plate = partner("Armour")
    for name, value in (("initial_height", 3e-3), ("initial_radius", 0.02), ("spread", 0.5)):
        plate.set(name, value)
    far_from_the_projectile(plate)
    assert [one(plate, name) for name in ("height", "bulge_height", "membrane_set")] == [3e-3] * 3
    plate.fmu.doStep(0.0, 1e-5)
    assert [one(plate, name) for name in ("height", "energy.elastic", "bulge_radius_rate")] == [3e-3, 0.0, 0.0]
    plate.set("bulge_height_impulse", 2e-3)
    for k in (1, 2):
        plate.fmu.doStep(k * 1e-5, 1e-5)
    height, rate = one(plate, "bulge_height"), one(plate, "bulge_height_rate")
    assert height > 3e-3 and rate > 0.1
    assert one(plate, "bulge_radius") == pytest.approx(0.02 + 0.5 * (height - 3e-3), rel=1e-14)
    assert one(plate, "bulge_radius_rate") == pytest.approx(0.5 * rate, rel=1e-14)


def test_a_bulge_that_spreads_picks_up_armour_and_keeps_its_momentum(partner):
    for step in (5e-6, 2e-5):
        plate, body = partner("Armour"), partner("RigidBody")
        for name, value in (("areal_density", 5.0), ("bulge_mass", 2e-3), ("membrane_yield_force", 1e-6)):
            plate.set(name, value)
        strike(plate, body, step, 1e-3)
        radius = 0.015 + one(plate, "height")
        grown = 2e-3 + 5.0 * np.pi * (radius**2 - 0.015**2)
        assert one(plate, "moving_mass") == pytest.approx(grown, rel=1e-9) and grown > 5e-3
        pushed, pulled = one(plate, "impulse.projectile"), one(plate, "impulse.support")
        assert one(plate, "momentum") == pytest.approx(pushed + pulled, rel=1e-11)
        assert MASS * (SPEED + body.get("velocity")[2]) == pytest.approx(pushed, rel=1e-12)
        assert abs(one(plate, "energy.imbalance")) < 1e-3 * MASS * SPEED**2 / 2


def test_a_bulge_that_goes_back_drops_no_armour(partner):
    plate = partner("Armour")
    for name, value in (("areal_density", 5.0), ("bulge_mass", 2e-3)):
        plate.set(name, value)
    far_from_the_projectile(plate)
    plate.set("bulge_height_impulse", 5e-3)
    for k in range(4):
        plate.fmu.doStep(k * 1e-5, 1e-5)
    plate.set("bulge_height_impulse", -5e-3)
    masses = []
    for k in range(4, 40):
        plate.fmu.doStep(k * 1e-5, 1e-5)
        masses.append(one(plate, "moving_mass"))
    assert one(plate, "height") == 0.0 and masses[-1] == max(masses) > 2e-3
