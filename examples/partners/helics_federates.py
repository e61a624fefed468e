"""HELICS federation of the FMUs of a system (SSP): one federate and one process for each FMU.

    pip install helics fmpy
    cargo run --release --manifest-path partners/Cargo.toml -- gelfmu-out/systems
    python examples/partners/helics_federates.py gelfmu-out/systems/gel-and-body.ssp 1e-5 1e-2

Every connection of the SSP is a publication of one federate and an input of another. A federate publishes at its
granted time and requests the next one: all step from the same time and exchange afterwards (Jacobi).
"""

import multiprocessing
import sys
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import helics

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from fmpy import extract  # noqa: E402
from own_body import Gel as Instance  # noqa: E402
from run_system import System  # noqa: E402

SHOWN = ("total_impulse[3]", "velocity[3]")  # outputs of a body


def federate(unit, step):
    """Return a federate that may be granted multiples of the communication step only."""
    info = helics.helicsCreateFederateInfo()
    helics.helicsFederateInfoSetCoreTypeFromString(info, "zmq")
    helics.helicsFederateInfoSetCoreInitString(info, "--federates=1 --timeout=20s")
    helics.helicsFederateInfoSetTimeProperty(info, helics.HELICS_PROPERTY_TIME_PERIOD, step)
    return helics.helicsCreateValueFederate(unit, info)


def run_unit(ssp, unit, step, count):
    """Run one FMU as a federate and return its shown values."""
    system = System(ssp)
    instance = Instance(extract(str(Path(extract(ssp)) / system.files[unit])), name=unit)
    instance.start()
    kind = helics.HELICS_DATA_TYPE_DOUBLE
    member = federate(unit, step)
    given = sorted({name for (source, name), _ in system.connections if source == unit})
    out = [(name, helics.helicsFederateRegisterGlobalPublication(member, f"{unit}/{name}", kind, "")) for name in given]
    taken = []
    for (source, name), (target, inlet) in system.connections:
        if target == unit:
            port = helics.helicsFederateRegisterInput(member, inlet, kind, "")
            helics.helicsInputAddTarget(port, f"{source}/{name}")
            taken.append((inlet, port))
    helics.helicsFederateEnterInitializingMode(member)
    for name, port in out:
        helics.helicsPublicationPublishDouble(port, instance.get(name, 1)[0])
    helics.helicsFederateEnterExecutingMode(member)
    for k in range(count):
        for name, port in taken:
            instance.set(name, helics.helicsInputGetDouble(port))
        instance.fmu.doStep(k * step, step)
        for name, port in out:
            helics.helicsPublicationPublishDouble(port, instance.get(name, 1)[0])
        helics.helicsFederateRequestTime(member, (k + 1) * step)
    shown = {f"{unit}.{name}": float(instance.get(name, 1)[0]) for name in SHOWN if name in instance.variables}
    helics.helicsFederateDisconnect(member)
    instance.free()
    return shown


if __name__ == "__main__":
    ssp, step, stop = sys.argv[1], float(sys.argv[2]), float(sys.argv[3])
    units = list(System(ssp).files)
    broker = helics.helicsCreateBroker("zmq", "broker", f"--federates={len(units)}")
    with ProcessPoolExecutor(len(units), mp_context=multiprocessing.get_context("spawn")) as pool:
        runs = [pool.submit(run_unit, ssp, unit, step, round(stop / step)) for unit in units]
        for run in runs:
            for name, value in run.result().items():
                print(f"{name} = {value!r}")
    helics.helicsBrokerDisconnect(broker)
