"""[run]: the co-simulation."""

from __future__ import annotations

from collections.abc import Collection
from typing import Annotated, Any, Literal, Self, get_args

from pydantic import field_validator, model_validator

from cardsflow_fmu.cosim.coupling import Coupling, Scheme
from cardsflow_fmu.cosim.signals.roles import ROLES
from cardsflow_fmu.experiment.config.messages import SettingError
from cardsflow_fmu.experiment.config.table import File, Listed, Positive, Table, setting

Compute = Literal["c", "python"]
ModelCoupling = Literal["fmu", "direct"]
TableFormat = Literal["csv", "parquet"]
RecordingFormat = Literal["none", "mcap"]


class RunSettings(Table):
    """The co-simulation."""

    step: Positive = setting("communication step, in s", 0.001)
    duration: Positive = setting("in s; that of the reference when left out", None)
    output: File = setting("folder for the results, relative to this file", "results")
    format: TableFormat = setting("of the table of results", "csv")
    recording: RecordingFormat = setting("beside the table, with messages of ROS 2", "none")
    compute: Compute = setting(
        "who computes: C wherever C can, or models that a Python process hosts", "c"
    )
    coupling: ModelCoupling = setting(
        "FMUs, or the models directly: in one loop in C where all of them compute in C", "fmu"
    )
    scheme: Scheme = setting("in what order participants are stepped", "sampled")
    order: Annotated[tuple[str, ...], Listed] = setting("of the participants, for gauss_seidel", ())

    @field_validator("coupling", mode="before")
    @classmethod
    def _check_coupling(cls, value: Any) -> Any:
        if value in get_args(Scheme):
            raise SettingError(f"{value!r} is a coupling scheme: set run.scheme to it")
        return value

    @model_validator(mode="after")
    def _check_order(self) -> Self:
        if self.scheme != "gauss_seidel":
            self.require_only(key for key in type(self).model_fields if key != "order")
        elif sorted(self.order) != sorted(ROLES):
            what = f"must be a list of {', '.join(ROLES)} in any order"
            raise SettingError(what if self.order else f"missing: {what}", key="order")
        return self

    @property
    def stepping(self) -> Coupling:
        """In what order plant, controller and reference are stepped."""
        return Coupling(self.scheme, self.order) if self.order else Coupling(self.scheme)

    @property
    def steps(self) -> int:
        """Number of communication steps."""
        return round(self.duration / self.step)

    def data(self, leave_out: Collection[str] = ()) -> dict[str, Any]:
        """What FMUs carry of it: not who runs them, where results go and in which formats."""
        of_a_run = ("output", "format", "recording", "compute", "coupling")
        return super().data([*of_a_run, *([] if self.order else ["order"]), *leave_out])
