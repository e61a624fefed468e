"""States, several instances, reset, and the communication step."""

import json
import os
import subprocess
import sys
import time
from pathlib import Path

import bits
import pytest
from fmpy.fmi1 import FMICallException
from own_body import Gel

STEP = 5e-5


def test_a_state_is_restored_in_a_new_process_to_the_bit(make, coarse, tmp_path):
    gel = make()
    gel.set("gel.shear_modulus", 5e4)
    gel.start()
    bits.run(gel, 0, 20, STEP)
    file = tmp_path / "state.bin"
    file.write_bytes(bits.state(gel))
    bits.run(gel, 20, 40, STEP)

    here = Path(__file__).parent
    path = os.pathsep.join([str(here), str(here.parents[1] / "examples")])
    command = [sys.executable, str(here / "restore.py"), coarse, str(file), repr(STEP)]
    output = subprocess.run(command, env={**os.environ, "PYTHONPATH": path}, check=True, capture_output=True, text=True)
    other = json.loads(output.stdout.splitlines()[-1])
    assert other["reals"] == bits.reals(gel)
    assert other["state"] == bits.state(gel).hex()


def test_going_back_and_on_again_gives_the_same_bits(make):
    gel = make()
    gel.start()
    bits.run(gel, 0, 10, STEP)
    pointer = gel.fmu.getFMUState()
    bits.run(gel, 10, 20, STEP)
    end = bits.reals(gel)
    gel.fmu.setFMUState(pointer)
    gel.fmu.freeFMUState(pointer)
    bits.run(gel, 10, 20, STEP)
    assert bits.reals(gel) == end


def test_interleaved_instances_do_not_meet(make):
    alone, one, two = (make(name=name) for name in ("alone", "one", "two"))
    two.set("projectile.initial_velocity", [0.0, 0.0, -3.0])
    for gel in (alone, one, two):
        gel.start()
    bits.run(alone, 0, 20, STEP)
    for k in range(20):
        bits.run(one, k, k + 1, STEP)
        bits.run(two, k, k + 1, STEP)
    assert bits.state(one) == bits.state(alone)
    assert bits.digest(two) != bits.digest(alone)


def test_a_reset_instance_runs_like_a_fresh_one(make):
    gel, fresh = make(), make()
    gel.set("projectile.mass", 0.05)
    gel.start()
    bits.run(gel, 0, 5, STEP)
    gel.fmu.reset()
    for each in (gel, fresh):
        each.start()
        bits.run(each, 0, 20, STEP)
    assert bits.state(gel) == bits.state(fresh)


def test_the_communication_step_leaves_no_trace(make):
    digests = set()
    for n in (1, 7, 100, 12345):
        gel = make()
        gel.start()
        bits.run(gel, 0, n, 2e-3 / n)
        digests.add(bits.digest(gel))
    assert len(digests) == 1


@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="threads are counted in /proc")
def test_no_thread_survives_its_instance(coarse):
    before = set(os.listdir("/proc/self/task"))
    gel = Gel(coarse)
    gel.fmu.setInteger(gel.references("threads", 1), [4])
    gel.start()
    bits.run(gel, 0, 2, STEP)
    assert len(set(os.listdir("/proc/self/task")) - before) > 0
    gel.free()
    # A joined thread may stay in /proc for a moment: the kernel wakes who joins it before it forgets it.
    deadline = time.monotonic() + 1.0
    while not set(os.listdir("/proc/self/task")) <= before and time.monotonic() < deadline:
        time.sleep(0.01)
    assert set(os.listdir("/proc/self/task")) <= before


def test_a_bad_call_raises_and_harms_nothing(make):
    gel = make()
    gel.start()
    before = bits.state(gel)
    with pytest.raises(FMICallException):
        gel.set("projectile.external_force", [float("nan"), 0.0, 0.0])
    with pytest.raises(FMICallException):
        gel.fmu.doStep(0.0, -STEP)
    assert bits.state(gel) == before
    bits.run(gel, 0, 2, STEP)


def test_input_derivatives_act_for_one_step(make):
    gel = make()
    gel.start()
    mass = gel.get("projectile.effective_mass", 1)[0]
    reference = gel.references("projectile.external_force", 3)[0]
    gel.fmu.setRealInputDerivatives([reference], [1], [1e5])
    gel.fmu.doStep(0.0, STEP)
    speed = gel.get("projectile.predicted_velocity")[0]
    contact = gel.get("contact.total_impulse")[0]
    assert speed == pytest.approx((1e5 * STEP**2 / 2 + contact) / mass, rel=1e-12)
