"""Settings of [disturbance] and [wiring]: external forces and connections of inputs."""

from __future__ import annotations

import math
from typing import Annotated, Any

from pydantic import ValidatorFunctionWrapHandler, WithJsonSchema, WrapValidator

from addin_sdfusion.robot import Robot
from cardsflow_fmu.cosim.signals.ports import load_signals
from cardsflow_fmu.cosim.signals.world import wrench_signals
from cardsflow_fmu.experiment.config.messages import SettingError
from cardsflow_fmu.experiment.config.names import named_setting
from cardsflow_fmu.experiment.config.table import Context, Table, Vector3, setting

from .plant import PlantSettings


class DisturbanceSettings(Table):
    """External forces on end-effector points."""

    forces: tuple[Vector3, ...] = named_setting(
        "point",
        "external force in N, by end-effector point",
        None,
        others=(0.0, 0.0, 0.0),
        alias="force",
    )
    begin: float = setting("begin of the forces, in s", 0.0)
    end: float = setting("end of the forces, in s (default: end of the run)", math.inf)
    known: bool = setting("the controller compensates for the forces", False)


def _source(value: Any, handler: ValidatorFunctionWrapHandler) -> str | float:
    if isinstance(value, str) and not value:
        raise SettingError("must be a text, not ''")
    source: str | float = value if isinstance(value, str) else handler(value)
    return source


Source = Annotated[
    float,
    WrapValidator(_source),
    WithJsonSchema({"anyOf": [{"type": "string", "minLength": 1}, {"type": "number"}]}),
]
_DESCRIPTION = "output of another participant, or a number, by input"


class WiringSettings(Table):
    """Connections of inputs to outputs with other names, or to numbers."""

    plant: dict[str, Source] = setting(_DESCRIPTION, {})
    controller: dict[str, Source] = setting(_DESCRIPTION, {})


def read_disturbance(data: dict[str, Any], context: Context) -> DisturbanceSettings | None:
    """Read the external forces; None if the table is absent or empty."""
    if not data:
        return None
    settings = DisturbanceSettings.read(data, context, "disturbance")
    if settings.end <= settings.begin:
        problem = f"must be after begin, {settings.begin!r} s"
        raise context.error("disturbance.end", problem)
    if not settings.forces:
        points = ", ".join(context.names["point"].names) if context.names else ""
        problem = f"missing; set forces on {points or 'end-effector points'}"
        raise context.error("disturbance.force", problem)
    return settings


def complete_wiring(
    settings: WiringSettings,
    robot: Robot,
    disturbance: DisturbanceSettings | None,
    plant: PlantSettings,
) -> dict[str, str | float]:
    """Return connections by full port name; external loads without a source are 0."""
    wiring: dict[str, str | float] = dict.fromkeys(
        (f"plant.{name}" for name in wrench_signals(plant.wrenches)), 0.0
    )
    for model in ("plant", "controller"):
        if disturbance is None or (model == "controller" and not disturbance.known):
            wiring |= {f"{model}.{name}": 0.0 for name in load_signals(robot)}
        wiring |= {f"{model}.{name}": source for name, source in getattr(settings, model).items()}
    return wiring
