"""[fmus]: external FMUs in the place of the experiment's own, and the names of their variables."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Self

from pydantic import AfterValidator, model_validator

from addin_sdfusion.robot import UnknownNameError
from cardsflow_fmu.cosim.external_fmu import ExternalFmu
from cardsflow_fmu.cosim.signals.units import KNOWN_UNITS
from cardsflow_fmu.experiment.config.messages import SettingError
from cardsflow_fmu.experiment.config.table import File, Short, Table, Text, setting


def _existing(file: Path) -> Path:
    try:
        is_there = file.is_file()
    except OSError:  # such as a name that is too long
        is_there = False
    if not is_there:
        raise SettingError(f"there is no file {file}")
    return file


class ExternalFmuSettings(Table):
    """An external FMU."""

    path: Annotated[File, AfterValidator(_existing)] = setting("the .fmu, relative to this file")
    inputs: dict[str, Text] = setting("the FMU's variable for each port that it takes", {})
    outputs: dict[str, Text] = setting("the FMU's variable for each port that it gives", {})
    units: dict[str, Text] = setting("of variables, where the FMU does not state them", {})
    parameters: dict[str, float] = setting("start values, by the FMU's own names", {})

    @model_validator(mode="after")
    def _check_units(self) -> Self:
        given = self.units.items()
        wrong = [(name, unit) for name, unit in given if unit not in KNOWN_UNITS]
        if wrong:
            raise SettingError(
                *(UnknownNameError("unit", u, KNOWN_UNITS, key=f"units.{n}") for n, u in wrong)
            )
        return self


def _written_out(fmu: Any) -> Any:
    """A path alone."""
    return {"path": fmu} if isinstance(fmu, str) else fmu


_Fmu = Annotated[ExternalFmuSettings, Short(_written_out, {"type": "string", "minLength": 1})]
_WORDS = "an .fmu, or a table with its path and a name map"


class FmusSettings(Table):
    """External FMUs in the place of plant, controller, reference, estimator or hardware."""

    plant: _Fmu = setting(_WORDS, None)
    controller: _Fmu = setting(_WORDS, None)
    reference: _Fmu = setting(_WORDS, None)
    estimator: _Fmu = setting(_WORDS, None)
    hardware: _Fmu = setting(_WORDS, None)

    @property
    def by_role(self) -> dict[str, ExternalFmu]:
        """Those that are given, by the role that they take."""
        given = {role: getattr(self, role) for role in type(self).model_fields}
        return {
            role: ExternalFmu(
                own.path, f"fmus.{role}", own.inputs, own.outputs, own.units, own.parameters
            )
            for role, own in given.items()
            if own is not None
        }
