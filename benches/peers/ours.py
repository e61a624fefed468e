"""`sphere-block` through the FMU, driven by fmpy: everything that an importer does, from unpacking to freeing.

    python benches/peers/ours.py sphere-block.fmu --step 1e-4
"""

import argparse
import json
import shutil
import time

from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave

READ = ["projectile.depth", "projectile.predicted_velocity[3]", "contact.force[3]"]


class Gel:
    """One instance of the FMU, initialised."""

    def __init__(self, folder):
        self.description = read_model_description(folder, validate=False)
        self.reference = {v.name: v.valueReference for v in self.description.modelVariables}
        self.fmu = FMU2Slave(
            guid=self.description.guid,
            unzipDirectory=folder,
            modelIdentifier=self.description.coSimulation.modelIdentifier,
            instanceName="gel",
        )
        self.fmu.instantiate()
        self.fmu.setupExperiment(startTime=0.0)
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()

    def integer(self, name):
        """An integer output."""
        return self.fmu.getInteger([self.reference[name]])[0]

    def free(self):
        """End the instance."""
        self.fmu.terminate()
        self.fmu.freeInstance()


def run(gel, step):
    """Every communication step, and a few outputs after each: the greatest depth, its time, the velocity at the end."""
    references = [gel.reference[name] for name in READ]
    deepest = (0.0, 0.0)
    for k in range(round(float(gel.description.defaultExperiment.stopTime) / step)):
        gel.fmu.doStep(k * step, step)
        depth, velocity, _ = gel.fmu.getReal(references)
        deepest = max(deepest, (depth, (k + 1) * step))
    return deepest, velocity


def arguments():
    """The FMU, and the communication step."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("fmu")
    parser.add_argument("--step", type=float, default=1e-5, help="s")
    return parser.parse_args()


if __name__ == "__main__":
    given = arguments()
    unpacked = extract(given.fmu)
    instance = Gel(unpacked)
    since = time.process_time()
    (depth, deepest_at), rebound = run(instance, given.step)
    spent = time.process_time() - since
    answer = {"version": instance.description.modelName, "elements": instance.integer("cost.elements")}
    instance.free()
    shutil.rmtree(unpacked)
    answer |= {"stepping_cpu_s": spent, "depth": depth, "deepest_at": deepest_at, "rebound": rebound}
    print(json.dumps(answer))
