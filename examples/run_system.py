"""Run a system of FMUs (SSP) in an importer: fmpy, libcosim, Ecos, an FMU container, or a loop of our own.

    pip install fmpy libcosimpy ecospy tbb fmu-manipulation-toolbox
    cargo run --release --manifest-path partners/Cargo.toml -- gelfmu-out/systems
    python examples/run_system.py gelfmu-out/systems/gel-and-body.ssp libcosim 1e-5 1e-2

Every importer is a function of the SSP, the communication step and the end of the run (both in s), and the outputs to
return: those that the system shows, if none are named. They differ in *when* a unit sees what another one gave. All
step from the same time and exchange afterwards (Jacobi), or one after the other, each with what those before it just
gave (Gauss-Seidel).
"""

import contextlib
import ctypes
import io
import logging
import shutil
import sys
import tempfile
import zipfile
from pathlib import Path
from xml.etree import ElementTree

SHOWN = ("total_impulse[3]", "velocity[3]", "projectile.depth")
SPACE = "{http://ssp-standard.org/SSP1/SystemStructure%s}"


class System:
    """The content of the SSP: units in order, their files, and connections. Each FMU has its own start values."""

    def __init__(self, ssp):
        with zipfile.ZipFile(ssp) as archive:
            root = ElementTree.fromstring(archive.read("SystemStructure.ssd"))
        description = SPACE % "Description"
        components = list(root.iter(description + "Component"))
        self.files = {each.get("name"): each.get("source") for each in components}
        self.connections = [
            ((c.get("startElement"), c.get("startConnector")), (c.get("endElement"), c.get("endConnector")))
            for c in root.iter(description + "Connection")
        ]
        self.outputs = [
            (each.get("name"), connector.get("name"))
            for each in components
            for connector in each.iter(description + "Connector")
            if connector.get("kind") == "output"
        ]

    def shown(self):
        """Impulse and velocity of each body along z, and the depth of the projectile in the gel."""
        return [(unit, name) for unit, name in self.outputs if name in SHOWN]


def count(step, stop):
    return round(stop / step)


def with_fmpy(ssp, step, stop, watched=None):
    """fmpy's own SSP master: Jacobi. It starts with 0 at every input, whatever the FMUs give or want; they take that as
    not set."""
    from fmpy.ssp.simulation import simulate_ssp

    # Its loop adds up steps until it is at the end: aim at the middle of the last one.
    watched = watched or System(ssp).shown()
    rows = simulate_ssp(str(ssp), stop_time=(count(step, stop) - 0.5) * step, step_size=step)
    return [float(rows[".".join(at)][-1]) for at in watched]


def with_libcosim(ssp, step, stop, watched=None):
    """libcosim's fixed-step algorithm: Jacobi. Outputs are handed over before the first step."""
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
    from libcosimpy.CosimObserver import CosimObserver

    log_output_level(CosimLogLevel.FATAL)
    watched = watched or System(ssp).shown()
    execution = CosimExecution.from_ssp_file(str(ssp), step_size=round(step * 1e9))
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer)
    places = []
    for unit, name in watched:
        index = execution.slave_index_from_instance_name(unit)
        found = (v.reference for v in execution.slave_variables(index) if v.name.decode() == name)
        places.append((index, next(found)))
    if not execution.step(count(step, stop)):
        raise RuntimeError(f"libcosim could not run {ssp}")
    return [observer.last_real_values(index, [reference])[0] for index, reference in places]


def with_ecos(ssp, step, stop, watched=None):
    """Ecos' fixed-step algorithm: Jacobi. Outputs are handed over before the first step."""
    if sys.platform == "linux":
        # Its library wants that of the package tbb, which lies where the loader does not look.
        tbb = Path(sys.prefix) / "lib" / "libtbb.so.12"
        if not tbb.exists():
            raise RuntimeError(f"Ecos needs {tbb}, which is not there: pip install tbb")
        ctypes.CDLL(str(tbb), mode=ctypes.RTLD_GLOBAL)
    from ecospy import EcosSimulation
    from ecospy.lib import EcosLib

    EcosLib.set_log_level("off")
    watched = watched or System(ssp).shown()
    with EcosSimulation(ssp_path=str(ssp), step_size=step) as simulation:
        simulation.init()
        simulation.step(count(step, stop))
        values = [simulation.get_real("::".join(at)) for at in watched]
        simulation.terminate()
    return values


def with_container(ssp, step, stop, watched=None, sequential=False):
    """One FMU around all of them (fmu-manipulation-toolbox), run by fmpy: Jacobi, or `sequential` Gauss-Seidel in the
    order of the SSP."""
    from fmpy import simulate_fmu
    from fmu_manipulation_toolbox.assembly import Assembly

    logging.disable(logging.ERROR)  # it reports every variable that is wired to nothing
    system = System(ssp)
    watched = watched or system.shown()
    with tempfile.TemporaryDirectory() as folder:
        shutil.copy(ssp, Path(folder) / "system.ssp")
        assembly = Assembly("system.ssp", default_step_size=step, fmu_directory=Path(folder))
        assembly.root.sequential = sequential
        inside = {unit: f"system.dir/{Path(file).name}" for unit, file in system.files.items()}
        for unit, name in watched:
            assembly.root.add_output(inside[unit], name, f"{unit}.{name}")
        assembly.make_fmu()
        # It says how it schedules as a warning and an error.
        with contextlib.redirect_stdout(io.StringIO()):
            rows = simulate_fmu(f"{folder}/system.fmu", stop_time=stop, step_size=step, output_interval=stop)
    logging.disable(logging.NOTSET)
    return [float(rows[".".join(at)][-1]) for at in watched]


def with_sequential_container(ssp, step, stop, watched=None):
    """The container, one unit after the other."""
    return with_container(ssp, step, stop, watched, sequential=True)


class FmuUnit:
    """A unit of the loop that is an FMU. A unit in Python has the same methods: see templates/partner.py."""

    def __init__(self, name, file):
        from fmpy import extract, read_model_description
        from fmpy.fmi2 import FMU2Slave

        self.folder = extract(str(file))
        self.description = read_model_description(self.folder)
        self.variables = {v.name: v for v in self.description.modelVariables}
        self.fmu = FMU2Slave(
            guid=self.description.guid,
            unzipDirectory=self.folder,
            modelIdentifier=self.description.coSimulation.modelIdentifier,
            instanceName=name,
        )

    def instantiate(self):
        self.fmu.instantiate()
        self.fmu.setupExperiment(startTime=0.0)

    def initialise(self):
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()

    def get(self, name):
        return self.fmu.getReal([self.variables[name].valueReference])[0]

    def set(self, name, value):
        variable = self.variables[name]
        if variable.type == "Real":
            self.fmu.setReal([variable.valueReference], [float(value)])
        else:
            self.fmu.setInteger([variable.valueReference], [int(value)])

    def step(self, time, step):
        self.fmu.doStep(time, step)

    def free(self):
        from fmpy.fmi1 import FMICallException

        if self.fmu.component is not None:
            with contextlib.suppress(FMICallException):  # after an error there is nothing to terminate
                self.fmu.terminate()
            self.fmu.freeInstance()
        shutil.rmtree(self.folder, ignore_errors=True)


class Loop:
    """A master in a few lines, for any order of the units. `partners` are units in Python in place of FMUs."""

    def __init__(self, ssp, partners=None):
        from fmpy import extract

        self.system, self.folder, self.units = System(ssp), extract(str(ssp)), {}
        for unit, file in self.system.files.items():
            own = (partners or {}).get(unit)
            self.units[unit] = own or FmuUnit(unit, Path(self.folder) / file)

    def stop_time(self, unit):
        """End of the run that the FMU of a unit suggests, s."""
        return float(self.units[unit].description.defaultExperiment.stopTime)

    def start(self, parameters=()):
        """Initialise all units; `parameters` are pairs of a variable of a unit and its value."""
        for unit in self.units.values():
            unit.instantiate()
        for at, value in parameters:
            self.set(at, value)
        for unit in self.units.values():
            unit.initialise()

    def get(self, at):
        unit, name = at
        return self.units[unit].get(name)

    def set(self, at, value):
        unit, name = at
        self.units[unit].set(name, value)

    def exchange(self, units):
        """Hand over what these units take."""
        values = [(to, self.get(at)) for at, to in self.system.connections if to[0] in units]
        for to, value in values:
            self.set(to, value)

    def step(self, time, step, order):
        """Groups of units one after the other: those in one group exchange before it steps."""
        for group in order:
            self.exchange(group)
            for unit in group:
                self.units[unit].step(time, step)

    def free(self):
        for unit in self.units.values():
            unit.free()
        shutil.rmtree(self.folder, ignore_errors=True)


def with_loop(ssp, step, stop, watched=None, order=None, partners=None):
    """A loop of our own: by default Jacobi; `order` = [["gel"], ["body"]] is Gauss-Seidel with the gel first. Outputs
    are handed over before the first step. `partners` are units in Python in place of FMUs."""
    loop = Loop(ssp, partners)
    try:
        loop.start()
        for k in range(count(step, stop)):
            loop.step(k * step, step, order or [list(loop.units)])
        return [loop.get(at) for at in watched or loop.system.shown()]
    finally:
        loop.free()


def with_sequential_loop(ssp, step, stop, watched=None, partners=None):
    """The loop, one unit after the other in the order of the SSP."""
    return with_loop(ssp, step, stop, watched, [[unit] for unit in System(ssp).files], partners)


def with_reversed_loop(ssp, step, stop, watched=None):
    """The loop, one unit after the other against the order of the SSP."""
    return with_loop(ssp, step, stop, watched, order=[[unit] for unit in reversed(System(ssp).files)])


IMPORTERS = {
    "fmpy": with_fmpy,
    "libcosim": with_libcosim,
    "ecos": with_ecos,
    "container": with_container,
    "sequential-container": with_sequential_container,
    "loop": with_loop,
    "sequential-loop": with_sequential_loop,
    "reversed-loop": with_reversed_loop,
}

USAGE = f"""usage: run_system.py SSP IMPORTER STEP STOP
  IMPORTER    {", ".join(IMPORTERS)}
  STEP, STOP  communication step and end of the run, s"""


def main(arguments):
    """The exit status of the command; what went wrong is said."""
    if len(arguments) != 4 or arguments[1] not in IMPORTERS:
        print(USAGE, file=sys.stderr)
        return 2
    ssp, importer, step, stop = arguments
    try:
        values = IMPORTERS[importer](ssp, float(step), float(stop))
    except Exception as error:  # whatever an importer raises
        print(f"error: {importer}: {error}", file=sys.stderr)
        return 1
    for at, value in zip(System(ssp).shown(), values, strict=True):
        print(f"{'.'.join(at)} = {value!r}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
