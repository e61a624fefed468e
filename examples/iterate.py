"""Prescribe the motion of the projectile, and repeat each step until motion and impulse agree.

The importer owns the body. It guesses the change of velocity over the step, w, prescribes the motion with the
acceleration w/H, and gets the impulse J. If J/m is not w, it goes back to the state before the step and tries again with
a better w (Aitken's relaxation). What converges is the trapezoidal rule, without jumps.

    pip install fmpy
    gelfmu pack
    python examples/iterate.py BallisticGel.fmu
"""

import shutil
import sys

import numpy as np
from fmpy import extract
from own_body import Gel

PRESCRIBED = 1


def attempt(gel, time, step, change):
    """One step in which the body is accelerated by `change`/`step`; the impulse on it."""
    gel.fmu.setRealInputDerivatives(gel.references("projectile.velocity", 3), [1, 1, 1], (change / step).tolist())
    gel.fmu.doStep(time, step)
    return gel.get("contact.impulse")


def converge(gel, time, step, change, mass, tolerance=1e-9, tries=25):
    """Repeat the step until J/m is `change`, m/s, to within `tolerance`; that change, and how often it was tried."""
    before, weight, last = gel.fmu.getFMUState(), 1.0, None
    for tried in range(1, tries + 1):
        if tried > 1:
            gel.fmu.setFMUState(before)
        residual = attempt(gel, time, step, change) / mass - change
        if np.linalg.norm(residual) <= tolerance:
            break
        if last is not None and np.any(residual != last):
            weight *= -(last @ (residual - last)) / np.sum((residual - last) ** 2)
        change, last = change + weight * residual, residual
    gel.fmu.freeFMUState(before)
    return gel.get("contact.impulse") / mass, tried


def steps(gel, step):
    """Yield, after each step, time, position, velocity, and how often the step was tried."""
    gel.start(mode=PRESCRIBED)
    mass = gel.get("projectile.effective_mass", 1)[0]
    x, v = gel.get("projectile.predicted_position"), gel.get("projectile.predicted_velocity")
    change = np.zeros(3)
    for k in range(round(float(gel.description.defaultExperiment.stopTime) / step)):
        gel.set("projectile.position", x)
        gel.set("projectile.velocity", v)
        change, tried = converge(gel, k * step, step, change, mass)
        x, v = x + step * (v + change / 2), v + change
        yield (k + 1) * step, x, v, tried


if __name__ == "__main__":
    unpacked = extract(sys.argv[1])
    instance = Gel(unpacked)
    taken = list(steps(instance, 2e-4))
    tried = np.mean([tried for *_, tried in taken])
    print(f"{len(taken)} steps, each tried {tried:.1f} times in the mean")
    print(f"velocity at {1e3 * taken[-1][0]:.2f} ms {taken[-1][2][2]:.4f} m/s")
    instance.free()
    shutil.rmtree(unpacked, ignore_errors=True)
