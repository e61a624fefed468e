"""Prescribe the motion of the projectile and let the energy residual choose the communication step.

The importer owns the body and moves it by the impulse J alone: v' = v + J/m, x' = x + H (v + v')/2. What that misses in
a step is `coupling.energy_residual`. The next step is as long as keeps it below a given part of the body's energy.

    pip install fmpy
    gelfmu pack
    python examples/step_control.py BallisticGel.fmu
"""

import shutil
import sys

import numpy as np
from fmpy import extract
from own_body import Gel

PRESCRIBED = 1
LONGEST = 1e-3  # also without contact, so as not to fly far into the gel before the first impulse
# The residual of one step grows with H to the power of 2: that of all steps together is of first order.
EXPONENT = 1 / 2


def next_step(gel, step, allowed):
    """Step after one of this length, s: fivefold shorter to fivefold longer.

    Never shorter than `coupling.step_min`: there impulses come one by one, and the residual falls no further. Never
    longer than `coupling.step_advice`, what is stable.
    """
    residual = abs(gel.get("coupling.energy_residual", 1)[0])
    ratio = (allowed / max(residual, 1e-300)) ** EXPONENT
    shortest, stable = gel.get("coupling.step_min", 1)[0], gel.get("coupling.step_advice", 1)[0]
    wanted = step * np.clip(0.8 * ratio, 0.2, 5.0)
    return float(np.clip(wanted, shortest, max(shortest, min(stable, LONGEST))))


def steps(gel, tolerance):
    """Yield, after each step, time, length of the step, position and velocity."""
    gel.start(mode=PRESCRIBED)
    stop = float(gel.description.defaultExperiment.stopTime)
    mass = gel.get("projectile.effective_mass", 1)[0]
    x, v = gel.get("projectile.predicted_position"), gel.get("projectile.predicted_velocity")
    allowed = tolerance * mass * (v @ v) / 2
    # Well below what is stable, until the first residual is known.
    time, step = 0.0, gel.get("coupling.step_advice", 1)[0] / 100
    while time < stop:
        step = min(step, stop - time)
        gel.set("projectile.position", x)
        gel.set("projectile.velocity", v)
        gel.fmu.doStep(time, step)
        time += step
        after = v + gel.get("contact.impulse") / mass
        x, v = x + step * (v + after) / 2, after
        yield time, step, x, v
        step = next_step(gel, step, allowed)


if __name__ == "__main__":
    unpacked = extract(sys.argv[1])
    instance = Gel(unpacked)
    taken = list(steps(instance, tolerance=1e-3))
    lengths = [step for _, step, _, _ in taken]
    print(f"{len(taken)} steps of {1e6 * min(lengths):.1f} to {1e6 * max(lengths):.1f} us")
    print(f"velocity at {1e3 * taken[-1][0]:.2f} ms {taken[-1][3][2]:.4f} m/s")
    instance.free()
    shutil.rmtree(unpacked, ignore_errors=True)
