"""Drives a packed FMU in one Python importer; run.py calls it in the virtual environment.

    python drive.py IMPORTER FMU STEP STEPS FOLDER

Writes the bits of the watched values to FOLDER/values, and the serialised state to FOLDER/state where the importer has
it. Everything that is printed is a message of the importer about the archive. Exit status 1 means a refused archive.
"""

import ctypes
import struct
import sys
from pathlib import Path

WATCHED = ["contact.total_impulse[3]", "projectile.predicted_velocity[3]"]
NANOSECONDS = 1e9


class Slave:
    """FMU in fmpy's thin layer over the C functions: the reference, and the unit inside mosaik and HELICS."""

    def __init__(self, fmu, step):
        from fmpy import extract, read_model_description
        from fmpy.fmi2 import FMU2Slave

        description = read_model_description(fmu)
        references = {variable.name: variable.valueReference for variable in description.modelVariables}
        self.step_size, self.watched = step, [references[name] for name in WATCHED]
        self.fmu = FMU2Slave(guid=description.guid, unzipDirectory=extract(fmu), instanceName="gel",
                             modelIdentifier=description.coSimulation.modelIdentifier)
        self.fmu.instantiate()
        self.fmu.setupExperiment(startTime=0.0)
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()

    def step(self, number):
        """Takes communication step `number`, counted from 0."""
        self.fmu.doStep(number * self.step_size, self.step_size)

    def values(self):
        return self.fmu.getReal(self.watched)

    def state(self):
        return bytes(self.fmu.serializeFMUState(self.fmu.getFMUState()))

    def free(self):
        self.fmu.terminate()
        self.fmu.freeInstance()


def with_slave(fmu, step, steps, folder):
    """A plain loop over FMU2Slave."""
    slave = Slave(fmu, step)
    for number in range(steps):
        slave.step(number)
    values = slave.values()
    (folder / "state").write_bytes(slave.state())
    slave.free()
    return values


def simulated(fmu, step, steps, names):
    """Last values of fmpy's own simulation."""
    from fmpy import simulate_fmu

    rows = simulate_fmu(str(fmu), stop_time=steps * step, step_size=step, output_interval=step, output=names)
    return [float(rows[name][-1]) for name in names]


def with_fmpy(fmu, step, steps, folder):
    """fmpy's validation, then its simulation."""
    from fmpy.validation import validate_fmu

    problems = validate_fmu(fmu)
    if problems:
        raise SystemExit("\n".join(problems))
    return simulated(fmu, step, steps, WATCHED)


def with_toolbox(fmu, step, steps, folder):
    """Checkers of fmu-manipulation-toolbox, then a container around the archive, run by fmpy."""
    import logging

    from fmu_manipulation_toolbox.assembly import AssemblyNode
    from fmu_manipulation_toolbox.checker import get_checkers
    from fmu_manipulation_toolbox.cli.utils import ErrorCounter
    from fmu_manipulation_toolbox.operations import FMU

    errors = ErrorCounter()
    handlers = [logging.StreamHandler(), errors]
    logging.basicConfig(level=logging.WARNING, format="%(levelname)s %(message)s", handlers=handlers)
    with FMU(fmu) as unpacked:
        for checker in get_checkers():
            unpacked.apply_operation(checker())
    if errors.count:
        raise SystemExit(f"{errors.count} errors in {fmu}")
    node = AssemblyNode("container.fmu", step_size=step)
    node.add_fmu(Path(fmu).name)
    for name in WATCHED:
        node.add_output(Path(fmu).name, name, name)
    (folder / Path(fmu).name).write_bytes(Path(fmu).read_bytes())
    node.make_fmu(folder)
    return simulated(folder / "container.fmu", step, steps, WATCHED)


def with_libcosim(fmu, step, steps, folder):
    """libcosim's fixed-step algorithm with one slave."""
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
    from libcosimpy.CosimObserver import CosimObserver
    from libcosimpy.CosimSlave import CosimLocalSlave

    log_output_level(CosimLogLevel.WARNING)
    execution = CosimExecution.from_step_size(round(step * NANOSECONDS))
    index = execution.add_local_slave(CosimLocalSlave(fmu, "gel"))
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer)
    references = {variable.name.decode(): variable.reference for variable in execution.slave_variables(index)}
    if not execution.step(steps):
        raise SystemExit(f"libcosim could not run {fmu}")
    return observer.last_real_values(index, [references[name] for name in WATCHED])


def with_ecos(fmu, step, steps, folder):
    """Ecos' fixed-step algorithm with one model. Its library needs libtbb, which the loader does not find."""
    ctypes.CDLL(str(Path(sys.prefix) / "lib" / "libtbb.so.12"), mode=ctypes.RTLD_GLOBAL)
    from ecospy import EcosSimulation, EcosSimulationStructure
    from ecospy.lib import EcosLib

    EcosLib.set_log_level("warn")
    with EcosSimulationStructure() as structure:
        structure.add_model("gel", fmu)
        with EcosSimulation(structure=structure, step_size=step) as simulation:
            simulation.init()
            simulation.step(steps)
            values = [simulation.get_real(f"gel::{name}") for name in WATCHED]
            simulation.terminate()
    return values


def with_mosaik(fmu, step, steps, folder):
    """mosaik's scheduler with two time-based simulators: the FMU, and a recorder of its values."""
    import mosaik_api_v3
    from loguru import logger
    from mosaik import World
    from mosaik.starters import PythonStarter

    logger.remove()
    logger.add(sys.stderr, level="WARNING", format="{level} {message}")

    def model(attributes):
        return {"type": "time-based", "models": {"Model": {"public": True, "params": [], "attrs": attributes}}}

    class Gel(mosaik_api_v3.Simulator):
        def __init__(self):
            super().__init__(model(WATCHED))
            self.slave = Slave(fmu, step)

        def create(self, num, model):
            return [{"eid": "gel", "type": model}]

        def step(self, time, inputs, max_advance):
            self.slave.step(time)
            return time + 1

        def get_data(self, outputs):
            return {"gel": dict(zip(WATCHED, self.slave.values(), strict=True))}

        def finalize(self):
            self.slave.free()

    class Recorder(mosaik_api_v3.Simulator):
        last = None

        def __init__(self):
            super().__init__(model(WATCHED))

        def create(self, num, model):
            return [{"eid": "recorder", "type": model}]

        def step(self, time, inputs, max_advance):
            Recorder.last = [next(iter(inputs["recorder"][name].values())) for name in WATCHED]
            return time + 1

    with World({}, time_resolution=step, skip_greetings=True) as world:
        gel, recorder = (world.start(PythonStarter(kind), sim_id=kind.__name__).Model() for kind in (Gel, Recorder))
        world.connect(gel, recorder, *WATCHED)
        world.run(until=steps, print_progress=False)
    return Recorder.last


def with_helics(fmu, step, steps, folder):
    """One HELICS federate: its core grants the time of each step, and hands the published values back."""
    import helics

    information = helics.helicsCreateFederateInfo()
    helics.helicsFederateInfoSetCoreType(information, helics.HELICS_CORE_TYPE_INPROC)
    helics.helicsFederateInfoSetCoreInitString(information, "--federates=1 --autobroker")
    helics.helicsFederateInfoSetTimeProperty(information, helics.HELICS_PROPERTY_TIME_DELTA, step)
    federate = helics.helicsCreateValueFederate("gel", information)
    sinks = [helics.helicsFederateRegisterGlobalPublication(federate, name, helics.HELICS_DATA_TYPE_DOUBLE, "")
             for name in WATCHED]
    sources = [helics.helicsFederateRegisterSubscription(federate, name, "") for name in WATCHED]
    slave = Slave(fmu, step)
    helics.helicsFederateEnterExecutingMode(federate)
    for number in range(steps + 1):
        granted = helics.helicsFederateRequestTime(federate, (number + 1) * step)
        if round(granted / step) != number + 1:
            raise SystemExit(f"HELICS granted {granted} s, expected step {number + 1} of {step} s")
        if number < steps:
            slave.step(number)
            for sink, value in zip(sinks, slave.values(), strict=True):
                helics.helicsPublicationPublishDouble(sink, value)
    values = [helics.helicsInputGetDouble(source) for source in sources]
    slave.free()
    helics.helicsFederateDestroy(federate)
    helics.helicsCloseLibrary()
    return values


IMPORTERS = {
    "reference": with_slave,
    "fmpy": with_fmpy,
    "fmu-manipulation-toolbox": with_toolbox,
    "libcosim": with_libcosim,
    "ecos": with_ecos,
    "mosaik": with_mosaik,
    "helics": with_helics,
}


def main():
    importer, fmu, step, steps, folder = sys.argv[1:]
    values = IMPORTERS[importer](fmu, float(step), int(steps), Path(folder))
    (Path(folder) / "values").write_text(" ".join(struct.pack(">d", value).hex() for value in values))


if __name__ == "__main__":
    main()
