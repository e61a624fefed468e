"""The FMU of a scene: packed, and stepped by fmpy."""

from __future__ import annotations

import hashlib
import numbers
import shutil
import tempfile
from collections.abc import Callable, Iterable, Mapping
from ctypes import byref
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np

from .binary import CommandResult, call_json
from .errors import GelfmuError, unknown_name
from .running import shot_of
from .scene import Scene, as_scene
from .shot import Shot
from .values import Value


def pack(
    scene: Scene | str | Path,
    path: str | Path = "BallisticGel.fmu",
    *,
    outputs: str | None = None,
    platforms: str | None = None,
    fragments: int | None = None,
    sensors: int | None = None,
    terminals: bool = False,
) -> Path:
    """Write the FMU of a scene and return its path.

    Parameters
    ----------
    scene : Scene, str or Path
        Scene, the name of a built-in one, or the path of a file that ends with ``.toml``.
    path : str or Path
        File to write.
    outputs : str, optional
        Set of variables that are outputs: ``"integrated"``, ``"corrected"`` or ``"full"``.
    platforms : str, optional
        Platforms whose libraries are packed, such as ``"linux64,win64"``.
    fragments, sensors : int, optional
        Number of fragments and sensors with variables.
    terminals : bool
        Describe each body and sensor as a terminal, too; FMI Library 3 and the tools around it report an error there.
    """
    scene = as_scene(scene)
    options = {"outputs": outputs, "platforms": platforms, "fragments": fragments, "sensors": sensors}
    given = [f"--{name}={value}" for name, value in options.items() if value is not None]
    given += ["--terminals"] if terminals else []
    with scene.source() as name:
        call_json(["pack", name, *scene.arguments(), *given, f"--out={path}"])
    return Path(path)


def simulate(
    fmu: str | Path,
    *,
    values: Mapping[str, Value] | None = None,
    out: str | Path | None = None,
    step: float | None = None,
    on_step: Callable[[float, FmuInstance], None] | None = None,
) -> Shot:
    """Run an FMU to its end and return its results.

    Parameters
    ----------
    fmu : str or Path
        FMU of this project; it may be of another version.
    values : mapping, optional
        Parameters of the FMU, such as ``{"projectile.initial_velocity[3]": -150.0, "threads": 2}``.
    out : str or Path, optional
        Folder for the results, which replaces an earlier run; without it one in ``gelfmu-out`` that is named after
        the FMU and a hash of its values.
    step : float, optional
        Communication step, s; that of the scene if absent.
    on_step : callable, optional
        Called with the time, s, and the instance before each step: it may read and set variables.

    Raises
    ------
    GelfmuError
        If a parameter is unknown or refused.
    ShotError
        If the run stopped before its end; `shot` has what was computed.
    """
    fmu, values = Path(fmu), dict(values or {})
    if out is None:
        key = hashlib.blake2b(fmu.read_bytes() + repr(sorted(values.items())).encode(), digest_size=8).hexdigest()
        out = Path("gelfmu-out") / f"{fmu.stem}-{key}"
    folder = Path(out).resolve()
    with FmuInstance(fmu, folder.name) as instance:
        instance.set({**values, "output_directory": str(folder.parent)})
        instance.run(step, on_step)
    stopped = Shot.load(folder).summary["failure"]
    return shot_of(CommandResult(1 if stopped else 0, "", f"error: {stopped}" if stopped else ""), folder)


class FmuInstance:
    """Instance of an FMU, which can be reset and run again.

    Parameters
    ----------
    fmu : str or Path
        The archive; it is unpacked into a temporary folder until `close`.
    name : str
        Name of the instance, and of its folder in ``output_directory``.

    Attributes
    ----------
    is_lost : bool
        True after a fatal error: no call will succeed.
    """

    def __init__(self, fmu: str | Path, name: str = "gel") -> None:
        fmpy = _import_fmpy()
        self.is_lost = False
        self._messages: list[str] = []
        self._folder = tempfile.mkdtemp(prefix="ballistic-gel-")
        fmpy.extract(str(fmu), self._folder)
        self.description = fmpy.read_model_description(self._folder)
        self._variables = {variable.name: variable for variable in self.description.modelVariables}
        self._fmu = fmpy.fmi2.FMU2Slave(
            guid=self.description.guid,
            unzipDirectory=self._folder,
            modelIdentifier=self.description.coSimulation.modelIdentifier,
            instanceName=name,
        )
        callbacks = fmpy.fmi2.fmi2CallbackFunctions()
        callbacks.logger = fmpy.fmi2.fmi2CallbackLoggerTYPE(self._hear)
        fmpy.fmi2.addLoggerProxy(byref(callbacks))
        self._fmu.instantiate(callbacks=callbacks)

    def _hear(self, _component: Any, _name: bytes, status: int, _category: bytes, message: bytes) -> None:
        if status > 1:
            self._messages.append(message.decode())

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Free the instance and remove the unpacked archive."""
        if self._fmu is not None:
            self._fmu.freeInstance()
            self._fmu = None
            shutil.rmtree(self._folder, ignore_errors=True)

    def reset(self) -> None:
        """Return to the state after the instantiation; all variables have their start values."""
        self._call(self._fmu.reset)

    def set(self, values: Mapping[str, Value]) -> None:
        """Set variables by name: a number or a switch in the unit of the variable, or a text.

        Raises
        ------
        GelfmuError
            For an unknown name, a value of another type, or one that the FMU refuses.
        """
        for name, value in values.items():
            variable = self._variable(name)
            kind, setter = _SETTERS.get(variable.type, (int, "setInteger"))
            if isinstance(value, str) != (kind is str) or not isinstance(value, (str, numbers.Real, np.bool_)):
                unit = f" in {variable.unit}" if kind is float and variable.unit else ""
                remedy = "a text" if kind is str else f"a number{unit}"
                raise GelfmuError(f"{name}: found {value!r}, expected {remedy}", key=name, remedy=remedy)
            self._call(getattr(self._fmu, setter), [variable.valueReference], [kind(value)])

    def check_names(self, names: Iterable[str]) -> None:
        """Refuse names that are no variables, with the nearest one."""
        for name in names:
            self._variable(name)

    def get(self, name: str) -> float | int | bool:
        """Return the value of a variable that is a number or a switch."""
        variable = self._variable(name)
        getter = {"Real": "getReal", "Boolean": "getBoolean"}.get(variable.type, "getInteger")
        value: float | int = self._call(getattr(self._fmu, getter), [variable.valueReference])[0]
        return bool(value) if variable.type == "Boolean" else value

    def run(self, step: float | None = None, on_step: Callable[[float, FmuInstance], None] | None = None) -> None:
        """Initialize, and step to the end."""
        self.initialize()
        self.step_to_end(step, on_step)

    def initialize(self) -> None:
        """Build the scene with the values that were set, which may be refused."""
        end = float(self.description.defaultExperiment.stopTime)
        self._call(self._fmu.setupExperiment, startTime=0.0, stopTime=end)
        self._call(self._fmu.enterInitializationMode)
        self._call(self._fmu.exitInitializationMode)

    def step_to_end(
        self, step: float | None = None, on_step: Callable[[float, FmuInstance], None] | None = None
    ) -> None:
        """Step to the end of the scene, and terminate, which writes the results.

        A run that stops before its end is terminated, too: its summary tells why.
        """
        experiment = self.description.defaultExperiment
        end, step = float(experiment.stopTime), step or float(experiment.stepSize)
        try:
            now, number = 0.0, 0
            # The last step ends at the end time; a rest below a millionth of a step is round-off.
            while end - now > 1e-6 * step and not self.get("scene.is_over"):
                if on_step is not None:
                    on_step(now, self)
                number += 1
                then = number * step if end - number * step > 1e-6 * step else end
                self._fmu.doStep(now, then - now)
                now = then
        except _import_fmpy().fmi1.FMICallException as error:
            if error.status != _DISCARD:
                raise self._error(error) from error
        self._call(self._fmu.terminate)

    def _variable(self, name: str) -> Any:
        if name not in self._variables:
            raise unknown_name(name, self._variables, "variable")
        return self._variables[name]

    def _call(self, function: Callable[..., Any], *arguments: Any, **options: Any) -> Any:
        self._messages.clear()
        try:
            return function(*arguments, **options)
        except _import_fmpy().fmi1.FMICallException as error:
            raise self._error(error) from error

    def _error(self, error: Any) -> GelfmuError:
        self.is_lost = self.is_lost or error.status == _FATAL
        return GelfmuError("\n".join(self._messages) or str(error))


_DISCARD, _FATAL = 2, 4
# Types of variables and the functions that set them.
_SETTERS = {"Real": (float, "setReal"), "Boolean": (int, "setBoolean"), "String": (str, "setString")}


def _import_fmpy() -> Any:
    try:
        import fmpy
        import fmpy.fmi2
    except ImportError as error:
        remedy = "pip install fmpy"
        raise GelfmuError(f"found no fmpy, which runs FMUs: {remedy}", remedy=remedy) from error
    return fmpy
