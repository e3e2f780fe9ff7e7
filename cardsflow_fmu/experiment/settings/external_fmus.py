"""Settings of [fmus]: external FMUs, and the names of their variables."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Self

from pydantic import AfterValidator, model_validator

from addin_sdfusion.robot import UnknownNameError
from cardsflow_fmu.cosim.external_fmu import ExternalFmu
from cardsflow_fmu.cosim.signals.units import KNOWN_UNITS
from cardsflow_fmu.experiment.config.messages import SettingError
from cardsflow_fmu.experiment.config.table import File, ShortForm, Table, Text, setting


def _require_existing(file: Path) -> Path:
    try:
        exists = file.is_file()
    except OSError:  # such as a name that is too long
        exists = False
    if not exists:
        raise SettingError(f"{file} does not exist")
    return file


class ExternalFmuSettings(Table):
    """External FMU."""

    path: Annotated[File, AfterValidator(_require_existing)] = setting(
        "FMU file, relative to this file"
    )
    inputs: dict[str, Text] = setting("variable of the FMU by input port", {})
    outputs: dict[str, Text] = setting("variable of the FMU by output port", {})
    units: dict[str, Text] = setting("units of variables for which the FMU specifies none", {})
    parameters: dict[str, float] = setting("start values by variable of the FMU", {})

    @model_validator(mode="after")
    def _check_units(self) -> Self:
        units = self.units.items()
        wrong = [(name, unit) for name, unit in units if unit not in KNOWN_UNITS]
        if wrong:
            raise SettingError(
                *(UnknownNameError("unit", u, KNOWN_UNITS, key=f"units.{n}") for n, u in wrong)
            )
        return self


def _as_table(fmu: Any) -> Any:
    """Return the table for a path."""
    return {"path": fmu} if isinstance(fmu, str) else fmu


_Fmu = Annotated[ExternalFmuSettings, ShortForm(_as_table, {"type": "string", "minLength": 1})]
_DESCRIPTION = "path of an FMU, or a table with path and name maps"


class FmusSettings(Table):
    """External FMUs instead of plant, controller, reference, estimator or hardware."""

    plant: _Fmu = setting(_DESCRIPTION, None)
    controller: _Fmu = setting(_DESCRIPTION, None)
    reference: _Fmu = setting(_DESCRIPTION, None)
    estimator: _Fmu = setting(_DESCRIPTION, None)
    hardware: _Fmu = setting(_DESCRIPTION, None)

    @property
    def by_role(self) -> dict[str, ExternalFmu]:
        """The external FMUs by role."""
        fmus = {role: getattr(self, role) for role in type(self).model_fields}
        return {
            role: ExternalFmu(
                fmu.path, f"fmus.{role}", fmu.inputs, fmu.outputs, fmu.units, fmu.parameters
            )
            for role, fmu in fmus.items()
            if fmu is not None
        }
