"""Own the projectile and let the FMU correct it: coupling mode `corrected`.

The importer keeps position and velocity of the body itself. In each step it hands them over, together with its own
force F on the body, and then moves the body by F and by what the contact gave back: the impulse J and its moment S.

    pip install fmpy
    gelfmu pack
    python examples/own_body.py BallisticGel.fmu
"""

import shutil
import sys

import numpy as np
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave

CORRECTED = 3


class Gel:
    """One instance of the FMU, addressed by names of variables."""

    def __init__(self, folder, name="gel"):
        self.description = read_model_description(folder)
        self.variables = {v.name: v for v in self.description.modelVariables}
        self.fmu = FMU2Slave(
            guid=self.description.guid,
            unzipDirectory=folder,
            modelIdentifier=self.description.coSimulation.modelIdentifier,
            instanceName=name,
        )
        self.fmu.instantiate()

    def start(self, mode=None, **experiment):
        if mode is not None:
            self.fmu.setInteger([self.variables["coupling.mode"].valueReference], [mode])
        self.fmu.setupExperiment(startTime=0.0, **experiment)
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()

    def references(self, name, n):
        names = [name] if n == 1 else [f"{name}[{i + 1}]" for i in range(n)]
        return [self.variables[each].valueReference for each in names]

    def get(self, name, n=3):
        return np.array(self.fmu.getReal(self.references(name, n)))

    def set(self, name, values):
        values = np.atleast_1d(values)
        self.fmu.setReal(self.references(name, len(values)), values.tolist())

    def free(self):
        self.fmu.freeInstance()


def steps(gel, step, force):
    """Yield, after each step, time, own and predicted position, own and predicted velocity."""
    gel.start(mode=CORRECTED)
    force = np.asarray(force, dtype=float)
    mass = gel.get("projectile.effective_mass", 1)[0]
    x, v = gel.get("projectile.predicted_position"), gel.get("projectile.predicted_velocity")
    gel.set("projectile.external_force", force)
    for k in range(round(float(gel.description.defaultExperiment.stopTime) / step)):
        for name, n in [("orientation", 4), ("angular_velocity", 3)]:
            gel.set(f"projectile.{name}", gel.get(f"projectile.predicted_{name}", n))
        gel.set("projectile.position", x)
        gel.set("projectile.velocity", v)
        gel.fmu.doStep(k * step, step)
        x = x + v * step + (force * step**2 / 2 + gel.get("contact.impulse_moment")) / mass
        v = v + (force * step + gel.get("contact.impulse")) / mass
        yield (k + 1) * step, x, gel.get("projectile.predicted_position"), v, gel.get("projectile.predicted_velocity")


if __name__ == "__main__":
    unpacked = extract(sys.argv[1])
    instance = Gel(unpacked)
    apart = deepest = 0.0
    for time, x, predicted, v, _ in steps(instance, 1e-4, force=[0.0, 0.0, 0.0]):
        apart = max(apart, float(np.linalg.norm(x - predicted)))
        deepest = min(deepest, x[2])
    print(f"lowest centre {1e3 * deepest:.3f} mm, velocity at {1e3 * time:.2f} ms {v[2]:.4f} m/s")
    print(f"own and predicted position were at most {apart:.1e} m apart")
    instance.free()
    shutil.rmtree(unpacked, ignore_errors=True)
