"""An FMI 2.0 co-simulation FMU as a participant, through FMPy with preallocated buffers."""

from __future__ import annotations

import ctypes
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import fmpy
import fmpy.fmi1
import fmpy.fmi2
import numpy as np

from addin_sdfusion.robot import InputError, SimulationError, UnknownNameError

from .participants import FloatArray

_DISCARD = 2  # the first fmi2Status that means failure


class _Reals:
    """Real variables of an FMU with their value references and a buffer, laid out once."""

    def __init__(self, references: list[int]) -> None:
        n = len(references)
        buffer = (ctypes.c_double * n)()
        self.values: FloatArray = np.ctypeslib.as_array(buffer)
        self.arguments = ((ctypes.c_uint * n)(*references), ctypes.c_size_t(n), buffer)


class _Booleans:
    """Boolean variables of an FMU, read into a slice of numbers."""

    def __init__(self, references: list[int]) -> None:
        n = len(references)
        buffer = (ctypes.c_int * n)()
        self.values = np.ctypeslib.as_array(buffer)
        self.arguments = ((ctypes.c_uint * n)(*references), ctypes.c_size_t(n), buffer)


class FmuInstance:
    """A loaded, initialised FMU.

    FMPy loads and instantiates it; the calls of a step go to its library directly, since FMPy
    builds new arrays at every call.

    Args:
        name: Its name in the wiring.
        file: The .fmu.
        folder: An empty folder to unpack it into; it must live as long as the instance.
        start_values: Values for parameters, by name.

    Raises:
        InputError: The file is no FMU that can be used.
        SimulationError: The FMU refuses to start; the message is its own.
    """

    def __init__(
        self,
        name: str,
        file: Path,
        folder: Path,
        start_values: Mapping[str, float] | None = None,
    ) -> None:
        self.name = name
        self._file = file
        self._log: list[str] = []
        description = _description(file, folder)
        variables = {variable.name: variable for variable in description.modelVariables}
        inputs = [v for v in variables.values() if v.causality == "input"]
        reals = [v for v in variables.values() if v.causality == "output" and v.type == "Real"]
        booleans = [
            v for v in variables.values() if v.causality == "output" and v.type == "Boolean"
        ]
        for variable in inputs:
            if variable.type != "Real":
                raise InputError(f"input {variable.name} is no Real", file=file)
        self.input_names = tuple(v.name for v in inputs)
        self.output_names = tuple(v.name for v in (*reals, *booleans))
        self._inputs = _Reals([v.valueReference for v in inputs])
        self._reals = _Reals([v.valueReference for v in reals])
        self._booleans = _Booleans([v.valueReference for v in booleans])
        self.inputs = self._inputs.values
        self.outputs: FloatArray = np.zeros(len(self.output_names))
        self._fmu = self._instantiate(description, folder)
        try:
            self._bind()
            self._initialize(variables, start_values or {})
        except BaseException:
            self.close()
            raise

    def step(self, t: float, h: float) -> None:
        """Set the inputs, advance from t to t + h, get the outputs."""
        if (
            self._set_real(self._component, *self._inputs.arguments) >= _DISCARD
            or self._do_step(self._component, t, h, 1) >= _DISCARD
        ):
            self._fail(f"at t = {t:.6g} s")
        self._read_outputs()

    def close(self) -> None:
        """Free the instance; its library stays loaded, as other instances may use it."""
        if self._fmu is not None:
            self._fmu.fmi2FreeInstance(self._fmu.component)
            self._fmu = None

    def _instantiate(self, description: Any, folder: Path) -> Any:
        callbacks = fmpy.fmi2.fmi2CallbackFunctions()
        callbacks.logger = fmpy.fmi2.fmi2CallbackLoggerTYPE(self._on_log)
        callbacks.allocateMemory = fmpy.fmi2.fmi2CallbackAllocateMemoryTYPE(fmpy.calloc)
        callbacks.freeMemory = fmpy.fmi2.fmi2CallbackFreeMemoryTYPE(fmpy.free)
        try:
            fmu = fmpy.fmi2.FMU2Slave(
                instanceName=self.name,
                guid=description.guid,
                modelIdentifier=description.coSimulation.modelIdentifier,
                unzipDirectory=str(folder),
            )
            fmu.instantiate(callbacks=callbacks)
        except Exception as error:
            raise SimulationError(f"{self._file}: {self._messages() or error}") from None
        return fmu

    def _bind(self) -> None:
        """Functions of their own, without FMPy's conversion of every argument."""
        library = self._fmu.dll
        self._component = ctypes.c_void_p(self._fmu.component)
        self._set_real = library["fmi2SetReal"]
        self._get_real = library["fmi2GetReal"]
        self._get_boolean = library["fmi2GetBoolean"]
        self._do_step = library["fmi2DoStep"]
        self._do_step.argtypes = [
            ctypes.c_void_p,
            ctypes.c_double,
            ctypes.c_double,
            ctypes.c_int,
        ]

    def _initialize(self, variables: Mapping[str, Any], start_values: Mapping[str, float]) -> None:
        fmu = self._fmu
        try:
            # No stop time: the last tick of a slower controller may reach beyond the end.
            fmu.setupExperiment(startTime=0.0)
            for name, value in start_values.items():
                if name not in variables:
                    raise UnknownNameError("variable", name, variables, file=self._file)
                fmu.setReal([variables[name].valueReference], [value])
            fmu.enterInitializationMode()
            fmu.exitInitializationMode()
        except fmpy.fmi1.FMICallException:
            self._fail("at the start")
        self._read_outputs()

    def _read_outputs(self) -> None:
        if self._get_real(self._component, *self._reals.arguments) >= _DISCARD:
            self._fail("while reading its outputs")
        reals = self._reals.values
        self.outputs[: reals.size] = reals
        if self._booleans.values.size:
            if self._get_boolean(self._component, *self._booleans.arguments) >= _DISCARD:
                self._fail("while reading its outputs")
            self.outputs[reals.size :] = self._booleans.values

    def _on_log(
        self, _: int | None, instance: bytes, status: int, category: bytes, message: bytes
    ) -> None:
        """Keep a message, with FMI 2's doubled `%` and `#` undone.

        FMPy's own formatting proxy is left alone: it serves one logger a process.
        """
        if status:
            text = message.decode("utf-8", "replace")
            self._log.append(text.replace("%%", "%").replace("##", "#"))

    def _messages(self) -> str:
        return "\n".join(self._log).strip()

    def _fail(self, when: str) -> None:
        raise SimulationError(
            f"{self._file.name} failed {when}: {self._messages() or 'no message'}"
        )


def _description(file: Path, folder: Path) -> Any:
    """Unpack the FMU and read its description."""
    try:
        fmpy.extract(str(file), str(folder))
        description = fmpy.read_model_description(str(folder), validate=False)
    except Exception as error:
        reason = re.sub(r"\s+", " ", str(error))
        raise InputError(f"is no FMU: {reason}", file=file) from None
    if description.fmiVersion != "2.0" or description.coSimulation is None:
        raise InputError("is no FMI 2.0 co-simulation FMU", file=file)
    return description
