"""`sphere-block` through the FMU, driven by fmpy: everything that an importer does, from unpacking to freeing.

    pip install fmpy
    gelfmu pack
    python benches/peers/ours.py BallisticGel.fmu --step 1e-4
"""

import argparse
import json
import shutil
import sys
import time
from pathlib import Path

from fmpy import extract

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "examples"))
from own_body import Gel

# What is read after each step, and its number of components; depth and velocity are reported.
READ = {"projectile.depth": 1, "projectile.predicted_velocity": 3, "contact.force": 3}


def run(gel, step):
    """Every communication step, and seven outputs after each: greatest depth and its time, velocity at the end."""
    read = [reference for name, n in READ.items() for reference in gel.references(name, n)]
    depth = deepest_at = 0.0
    for k in range(round(float(gel.description.defaultExperiment.stopTime) / step)):
        gel.fmu.doStep(k * step, step)
        deep, *vectors = gel.fmu.getReal(read)
        if deep > depth:
            depth, deepest_at = deep, (k + 1) * step
    return {"depth": depth, "deepest_at": deepest_at, "rebound": vectors[2]}


def elements(gel):
    """The number of elements of the mesh."""
    return gel.fmu.getInteger([gel.variables["cost.elements"].valueReference])[0]


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
    instance.start()
    since = time.process_time()
    answer = run(instance, given.step)
    answer |= {"stepping_cpu_s": time.process_time() - since, "elements": elements(instance)}
    instance.free()
    shutil.rmtree(unpacked)
    print(json.dumps(answer | {"version": instance.description.version}))
