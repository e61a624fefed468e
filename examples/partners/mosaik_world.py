"""mosaik scenario of the FMUs of a system (SSP): one simulator for each FMU, run by fmpy.

    pip install mosaik fmpy
    cargo run --release --manifest-path partners/Cargo.toml -- gelfmu-out/systems
    python examples/partners/mosaik_world.py gelfmu-out/systems/gel-and-body.ssp 1e-5 1e-2

A connection to a later unit of the SSP is used in the same step, one to an earlier unit in the next step: mosaik then
steps the units in the order of the SSP (Gauss-Seidel).
"""

import sys
from pathlib import Path

import mosaik
import mosaik_api_v3

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from fmpy import extract  # noqa: E402
from own_body import Gel as Instance  # noqa: E402
from run_system import System  # noqa: E402

SHOWN = ("total_impulse[3]", "velocity[3]")  # outputs of a body


class FmuSimulator(mosaik_api_v3.Simulator):
    """Simulator with one entity, an instance of an FMU; one unit of mosaik's time is one communication step."""

    def __init__(self):
        super().__init__({"type": "time-based", "models": {}})

    def init(self, sid, time_resolution, file=None):
        self.length = time_resolution
        self.instance = Instance(extract(file), name=sid)
        self.instance.start()
        kinds = ("input", "output", "local")
        names = [name for name, each in self.instance.variables.items() if each.causality in kinds]
        self.meta["models"] = {"Fmu": {"public": True, "params": [], "attrs": names}}
        return self.meta

    def create(self, num, model):
        return [{"eid": "fmu", "type": model}]

    def step(self, time, inputs, max_advance):
        for name, values in inputs.get("fmu", {}).items():
            self.instance.set(name, next(iter(values.values())))
        self.instance.fmu.doStep(time * self.length, self.length)
        return time + 1

    def get_data(self, outputs):
        return {"fmu": {name: float(self.instance.get(name, 1)[0]) for name in outputs["fmu"]}}

    def finalize(self):
        for name in SHOWN:
            if name in self.instance.variables:
                print(f"{self.instance.fmu.instanceName}.{name} = {float(self.instance.get(name, 1)[0])!r}")
        self.instance.free()


if __name__ == "__main__":
    ssp, step, stop = sys.argv[1], float(sys.argv[2]), float(sys.argv[3])
    system, folder = System(ssp), extract(sys.argv[1])
    order = list(system.files)
    world = mosaik.World({"Fmu": {"python": f"{__name__}:FmuSimulator"}}, time_resolution=step, skip_greetings=True)
    entities = {}
    for unit, file in system.files.items():
        simulator = world.start("Fmu", sim_id=unit, file=str(Path(folder) / file))
        entities[unit] = simulator.Fmu.create(1)[0]
    for (source, name), (target, inlet) in system.connections:
        back = order.index(source) > order.index(target)
        # In the first step such an input is 0; the FMUs take a quaternion of zeros as not set.
        late = {"time_shifted": True, "initial_data": {name: 0.0}} if back else {}
        world.connect(entities[source], entities[target], (name, inlet), **late)
    world.run(until=round(stop / step), print_progress=False)
