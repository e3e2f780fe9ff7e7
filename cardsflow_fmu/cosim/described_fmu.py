"""Inputs and outputs of FMUs from their model descriptions, without loading their code."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from addin_sdfusion.robot import InputError, UnknownNameError
from cardsflow_fmu.cosim.signals.units import Unit

from .fmu_description import STRUCTURAL, read_unpacked_description, set_structure
from .fmu_variables import Row, Signal, read_signals
from .participant import Idle
from .wiring import members


class DescribedFmu(Idle):
    """Inputs and outputs of an FMU. Each element of an array is a separate port.

    Raises:
        InputError: The file is not a valid FMU for co-simulation.
        UnknownNameError: A start value names a variable that does not exist.
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
        self._description = _description(file, folder)
        set_structure(self._description, start_values or {}, file)
        try:
            signals = read_signals(self._description, folder)
        except (TypeError, ValueError, KeyError, RecursionError) as error:
            reason = f"it does not contain {error}" if isinstance(error, KeyError) else error
            raise InputError(f"is not an FMU: {reason}", file=file) from None
        inputs = Row([signal for signal in signals if signal.causality == "input"])
        outputs = Row([signal for signal in signals if signal.causality == "output"])
        self.input_names, self.inputs = inputs.names, inputs.values
        self.output_names, self.outputs = outputs.names, outputs.values
        self.units: Mapping[str, Unit] = {n: u for s in signals for n, u in s.units.items()}
        self._input_row, self._output_row = inputs, outputs
        self._start_rows = self._create_start_rows(signals, start_values or {})

    def _create_start_rows(
        self, signals: list[Signal], values: Mapping[str, float]
    ) -> dict[bool, list[Row]]:
        """Return the rows to set before initialization: complete variables with new values.

        Returns:
            The rows of structural parameters (True), which are set first, and of others (False).
        """
        by_element = {name: signal for signal in signals for name in signal.names}
        groups = {name: members(name, by_element) for name in values}
        for name, elements in groups.items():
            if not elements:
                raise UnknownNameError("variable", name, by_element, file=self._file)
        expanded = {m: value for name, value in values.items() for m in groups[name]}
        values = expanded | {name: value for name, value in values.items() if name in by_element}
        changed = {by_element[name].names: by_element[name] for name in values}
        rows: dict[bool, list[Row]] = {True: [], False: []}
        for signal in changed.values():
            pairs = zip(signal.names, signal.start, strict=True)
            start = tuple(float(values.get(name, old)) for name, old in pairs)
            rows[signal.causality == STRUCTURAL].append(Row([replace(signal, start=start)]))
            if signal.causality == "input":
                for name, value in zip(signal.names, start, strict=True):
                    self.inputs[self.input_names.index(name)] = value
        return rows


def _description(file: Path, folder: Path) -> Any:
    """Unpack the FMU if necessary and read its model description."""
    description = read_unpacked_description(file, folder)
    version = str(description.fmiVersion)
    if not version.startswith(("2.", "3.")):
        raise InputError(f"is an FMU of FMI {version}; FMI 2.0 or 3.0 is required", file=file)
    if description.coSimulation is None:
        kinds = [
            name
            for name, kind in (
                ("model exchange", description.modelExchange),
                ("scheduled execution", getattr(description, "scheduledExecution", None)),
            )
            if kind is not None
        ]
        raise InputError(
            f"is for {' and '.join(kinds) or 'nothing'} only, not for co-simulation: "
            "export it for co-simulation",
            file=file,
        )
    return description
