"""How the partners of the gel answer to an importer: order, refusals, states, times."""

import math
from pathlib import Path

import pytest

LAST_SUCCESSFUL_TIME, MODEL_EXCHANGE, CO_SIMULATION = 2, 0, 1
NAN, INFINITE = math.nan, math.inf


def one(unit, name):
    return unit.get(name, 1)[0]


def refuses(call, message="failed with status 3"):
    with pytest.raises(Exception, match=message):
        call()


def test_a_state_that_is_set_again_continues_with_the_same_bits(partner):
    plate = partner("Armour")
    plate.start()
    plate.set("projectile.position", [0.0, 0.0, 0.014])
    plate.set("projectile.velocity", [0.0, 0.0, -20.0])
    for k in range(20):
        plate.fmu.doStep(k * 1e-5, 1e-5)
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
        refuses(refused)
    body.fmu.doStep(0.0, 1e-5)


def test_a_body_without_mass_is_refused_before_it_starts(partner):
    body = partner("RigidBody")
    body.set("mass", 0.0)
    refuses(body.start, "fmi2ExitInitializationMode failed")


def test_an_orientation_that_is_none_is_refused_and_moves_nothing(partner):
    body = partner("RigidBody")
    body.set("initial_orientation", [1.0, 1.0, 0.0, 0.0])
    refuses(body.start, "fmi2ExitInitializationMode failed")
    body = partner("RigidBody")
    body.start()
    body.set("predicted_orientation", [0.5, 0.0, 0.0, 0.0])
    refuses(lambda: body.fmu.doStep(0.0, 1e-3))
    assert body.get("position")[2] == 0.010
    body.set("predicted_orientation", [0.6, 0.8, 0.0, 0.0])
    body.fmu.doStep(0.0, 1e-3)
    assert body.get("orientation", 4).tolist() == pytest.approx([0.6, 0.8, 0.0, 0.0], rel=1e-15)


def test_values_are_set_all_or_none(partner):
    body = partner("RigidBody")
    refuses(lambda: body.set("initial_velocity", [1.0, 2.0, NAN]))
    assert body.get("initial_velocity").tolist() == [0.0, 0.0, -5.0]
    mass, position = body.references("mass", 1), body.references("position", 3)
    refuses(lambda: body.fmu.setReal(mass + position[:1], [2.0, 1.0]))
    refuses(lambda: body.fmu.setReal([*mass, 10_000], [2.0, 1.0]))
    assert one(body, "mass") == 0.033
    body.fmu.setReal(mass, [2.0])
    assert one(body, "mass") == 2.0


def test_times_are_finite_and_follow_each_other(partner):
    body = partner("RigidBody")
    for time in (NAN, INFINITE, -INFINITE):
        refuses(lambda time=time: body.fmu.setupExperiment(startTime=time))
    body.fmu.setupExperiment(startTime=5.0)
    body.fmu.enterInitializationMode()
    refuses(lambda: body.fmu.setupExperiment(startTime=0.0))
    body.fmu.exitInitializationMode()
    for time, step in [(0.0, 1e-3), (NAN, 1e-3), (INFINITE, 1e-3), (5.0, NAN), (5.0, INFINITE), (5.0, -1e-3)]:
        refuses(lambda time=time, step=step: body.fmu.doStep(time, step))
    assert body.fmu.getRealStatus(LAST_SUCCESSFUL_TIME) == 5.0
    body.fmu.doStep(5.0, 1e-3)
    assert body.fmu.getRealStatus(LAST_SUCCESSFUL_TIME) == 5.001
    refuses(lambda: body.fmu.doStep(5.0, 1e-3))
    assert body.get("position")[2] == pytest.approx(0.010 - 5.0 * 1e-3, rel=1e-14), "what was refused moved nothing"


def test_what_overflows_is_an_error_and_no_answer(partner):
    body = partner("RigidBody")
    body.start()
    body.set("force", [1e300, 0.0, 0.0])
    refuses(lambda: body.fmu.doStep(0.0, 1e10))
    assert body.get("velocity").tolist() == [0.0, 0.0, -5.0]
    body.set("force", [0.0, 0.0, 0.0])
    body.fmu.doStep(0.0, 1e-5)
    body = partner("RigidBody")
    body.set("inertia", [1e200, 1e200, 1e200, 0.0, 0.0, 0.0])
    body.set("initial_angular_velocity", [1e200, 0.0, 0.0])
    refuses(body.start, "fmi2ExitInitializationMode failed")


def test_a_substep_that_would_never_end_is_refused(partner):
    plate = partner("Armour")
    plate.set("longest_substep", 1e-30)
    plate.start()
    plate.set("projectile.position", [0.0, 0.0, 1.0])
    refuses(lambda: plate.fmu.doStep(0.0, 1e-5))
    assert plate.fmu.getRealStatus(LAST_SUCCESSFUL_TIME) == 0.0


def test_after_the_end_values_are_read_and_nothing_else(partner):
    body = partner("RigidBody")
    refuses(body.fmu.terminate)
    body.start()
    body.fmu.doStep(0.0, 1e-3)
    position = body.get("position").tolist()
    body.fmu.terminate()
    assert body.get("position").tolist() == position
    refuses(lambda: body.fmu.doStep(1e-3, 1e-3))
    refuses(lambda: body.set("force", [1.0, 0.0, 0.0]))
    refuses(body.fmu.terminate)


def test_a_reset_instance_is_a_fresh_one(partner):
    body = partner("RigidBody")
    body.set("mass", 1.0)
    body.start()
    body.set("force", [1.0, 2.0, 3.0])
    body.fmu.doStep(0.0, 1e-3)
    body.fmu.reset()
    assert one(body, "mass") == 0.033
    body.start()
    assert body.fmu.getRealStatus(LAST_SUCCESSFUL_TIME) == 0.0
    body.fmu.doStep(0.0, 1e-3)
    assert body.get("velocity").tolist() == [0.0, 0.0, -5.0] and body.get("position")[0] == 0.0


def test_a_state_of_another_partner_is_refused(partner):
    body, plate = partner("RigidBody"), partner("Armour")
    body.start()
    plate.start()
    state = body.fmu.getFMUState()
    content = body.fmu.serializeFMUstate(state)
    body.fmu.freeFMUState(state)
    refuses(lambda: plate.fmu.deSerializeFMUstate(content))
    refuses(lambda: body.fmu.deSerializeFMUstate(content[:-8]))
    refuses(lambda: body.fmu.deSerializeFMUstate(b"{0" + content[2:] if content[1:2] != b"0" else b"{1" + content[2:]))
    body.fmu.freeFMUState(body.fmu.deSerializeFMUstate(content))


def test_another_kind_or_another_interface_is_refused(partner):
    from ctypes import byref

    fmu = partner("RigidBody").fmu

    resources = (Path(fmu.unzipDirectory) / "resources").as_uri()

    def instance(kind, guid, resources=resources):
        return fmu.fmi2Instantiate(b"other", kind, guid.encode(), resources.encode(), byref(fmu.callbacks), 0, 0)

    assert instance(CO_SIMULATION, fmu.guid, resources="") is None
    assert instance(MODEL_EXCHANGE, fmu.guid) is None
    assert instance(CO_SIMULATION, "{another}") is None
    made = instance(CO_SIMULATION, fmu.guid)
    assert made is not None
    fmu.fmi2FreeInstance(made)
