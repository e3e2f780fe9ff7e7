"""FMI 2.0 and FMI 3.0 co-simulation FMUs as participants."""

from __future__ import annotations

import contextlib
import os
import re
from collections.abc import Mapping
from pathlib import Path

from addin_sdfusion.robot import InputError, SimulationError
from cardsflow_fmu.utils.compiled.library import address, run_library
from cardsflow_fmu.utils.interrupts import collect_interrupts

from .described_fmu import DescribedFmu
from .fmi_calls import DISCARD, Fmi2Calls, Fmi3Calls, FmuCalls
from .fmu_variables import Row
from .participant import CStep

_OWN_ERROR = re.compile(r"\b(?:addin_sdfusion|cardsflow_fmu)[\w.]*Error: ")
"""Pattern for error classes of this package, whose messages are for users."""
_TERMINATED, _GET_FAILED = 2, 3
"""Results of `fmu_step`; see csrc/fmu_step.h."""
_READING = "while reading its outputs"


class FmuInstance(DescribedFmu):
    """Loaded and initialised FMU. Each element of an array is a separate port.

    Args:
        name: Name of the FMU in the wiring.
        folder: An empty folder, or a folder with the unpacked FMU. It must exist as long as the
            instance exists.
        start_values: Start values for parameters and other variables, by name.

    Raises:
        InputError: The file is not a valid FMU for co-simulation.
        SimulationError: The FMU cannot be initialised; the error contains its message.
        UnknownNameError: A start value names a variable that does not exist.
        KeyboardInterrupt: Ctrl-C or SIGTERM during initialisation.
    """

    def __init__(
        self,
        name: str,
        file: Path,
        folder: Path,
        start_values: Mapping[str, float] | None = None,
    ) -> None:
        super().__init__(name, file, folder, start_values)
        self._log: list[str] = []
        self._calls: FmuCalls | None = None
        self._is_stepping = False
        description = self._description
        calls = Fmi2Calls if description.fmiVersion.startswith("2") else Fmi3Calls
        try:
            # If a library cannot be loaded, FMPy does not restore the current folder.
            with contextlib.chdir("."):
                self._calls = calls(name, description, folder, self._on_log)
        except Exception as error:
            if self._messages():
                raise SimulationError(f"{file}: {self._messages()}") from None
            reason = " ".join(str(error).split())
            problem = f"cannot be loaded: {reason}{_mount_hint(folder)}"
            raise InputError(problem, file=file) from None
        try:
            self._bind(self._calls)
            self._start(self._calls, self._start_rows)
        except BaseException:
            self.close()
            raise

    def step(self, t: float, h: float) -> None:
        """Set the inputs, advance from t to t + h, and get the outputs."""
        if code := run_library().fmu_step(self.c_step.instance, t, h):
            raise self._failure(code, t)

    def close(self) -> None:
        """Terminate the simulation unless it has failed, and free the instance."""
        calls, self._calls = self._calls, None
        if calls is None:
            return
        try:
            if self._is_stepping:
                calls.terminate()
        finally:
            calls.free()

    def _bind(self, calls: FmuCalls) -> None:
        """Create the rows and the participant in C."""
        library = run_library()
        self._outputs = calls.row(self._output_row)
        handle = calls.stepper(calls.row(self._input_row), self._outputs).value
        assert handle is not None
        self.c_step = CStep(address(library.fmu_step), handle, self._failure)

    def _start(self, calls: FmuCalls, rows: dict[bool, list[Row]]) -> None:
        """Initialize the instance.

        Ctrl-C is handled after the initialization, since hardware may answer slowly.
        """
        with collect_interrupts() as interrupted:
            try:
                self._initialize(calls, rows)
            except SimulationError:
                if not interrupted:
                    raise
        if interrupted:
            raise KeyboardInterrupt

    def _initialize(self, calls: FmuCalls, rows: dict[bool, list[Row]]) -> None:
        if structure := rows[True]:
            self._require(calls.enter_configuration())
            self._set_rows(calls, structure)
            self._require(calls.exit_configuration())
        self._set_rows(calls, rows[False])
        self._require(calls.enter_initialization())
        self._require(calls.exit_initialization())
        self._is_stepping = True
        if run_library().fmu_row_get(self._outputs) >= DISCARD:
            raise self._error(_READING)

    def _set_rows(self, calls: FmuCalls, rows: list[Row]) -> None:
        for row in rows:
            self._require(run_library().fmu_row_set(calls.row(row)))

    def _require(self, status: int) -> None:
        """Raise the error of a call before the first step."""
        if status >= DISCARD:
            raise self._error("at the start")

    def _on_log(self, status: int, text: str) -> None:
        if status:
            self._log.append(text)

    def _messages(self) -> str:
        """Return all messages as one text, since FMI 2.0 splits long messages."""
        return _user_text("\n".join(self._log)).strip()

    def _failure(self, code: int, t: float) -> SimulationError:
        """Return the error for a result of `fmu_step`, at t in [s]."""
        if code == _TERMINATED:
            self._log.append("the FMU requested to terminate the simulation")
        return self._error(_READING if code == _GET_FAILED else f"at t = {t:.6g} s")

    def _error(self, when: str) -> SimulationError:
        self._is_stepping = False
        return SimulationError(
            f"{self._file.name} failed {when}: {self._messages() or 'no message'}"
        )


def _user_text(text: str) -> str:
    """Return the message without trace if this package has raised it, otherwise the full text."""
    summary, trace, _ = text.partition("\nTraceback (most recent call last):")
    return _OWN_ERROR.sub("", summary, count=1) if trace and _OWN_ERROR.search(summary) else text


def _mount_hint(folder: Path) -> str:
    """Return advice if the folder's file system does not permit the execution of files."""
    forbids = getattr(os, "ST_NOEXEC", 0)  # not on Windows and macOS
    if not forbids or not os.statvfs(folder).f_flag & forbids:
        return ""
    return f"; {folder} is mounted with noexec: set TMPDIR to another folder"
