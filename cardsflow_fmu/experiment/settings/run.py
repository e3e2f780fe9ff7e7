"""Settings of [run]: step, duration and output of a run."""

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
TableFormat = Literal["auto", "csv", "npy"]
RecordingFormat = Literal["none", "mcap"]
Accept = Literal["tracked", "any"]


class RunSettings(Table):
    """Step, duration and output of a run."""

    step: Positive = setting("communication step, in s", 0.001)
    duration: Positive = setting("duration, in s (default: duration of the reference)", None)
    output: File = setting("results folder, relative to this file", "results")
    format: TableFormat = setting(
        "file format of the results table; auto: csv, or npy for more than 32 MiB of numbers",
        "auto",
    )
    figures: bool = setting("draw figures of the run, which takes a second", False)
    recording: RecordingFormat = setting("additional recording with ROS 2 messages", "none")
    compute: Compute = setting("language of the models: C where possible, or Python", "c")
    coupling: ModelCoupling = setting(
        "run the models as FMUs, or couple the models directly", "fmu"
    )
    scheme: Scheme = setting(
        "coupling scheme: order in which participants compute a step", "sampled"
    )
    accept: Accept = setting(
        "runs that succeed: only if the reference is tracked and at most 1 % of the ticks are "
        "infeasible, or any run that reaches its end",
        "tracked",
    )
    order: Annotated[tuple[str, ...], Listed] = setting(
        "order of the participants for gauss_seidel", ()
    )

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
            problem = f"must be a list of {', '.join(ROLES)} in any order"
            raise SettingError(problem if self.order else f"missing: {problem}", key="order")
        return self

    @property
    def stepping(self) -> Coupling:
        """Order in which plant, controller and reference compute a step."""
        return Coupling(self.scheme, self.order) if self.order else Coupling(self.scheme)

    @property
    def steps(self) -> int:
        """Number of communication steps."""
        return round(self.duration / self.step)

    def data(self, leave_out: Collection[str] = ()) -> dict[str, Any]:
        """Return the settings that FMUs contain: those that change the numbers of a run."""
        omitted = ("output", "format", "figures", "recording", "compute", "coupling", "accept")
        return super().data([*omitted, *([] if self.order else ["order"]), *leave_out])
