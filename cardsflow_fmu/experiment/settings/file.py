"""All tables of experiment.toml."""

from __future__ import annotations

from typing import Annotated, Self

from pydantic import ConfigDict, Field, model_validator

from cardsflow_fmu.experiment.config.messages import SettingError
from cardsflow_fmu.experiment.config.table import Listed, Table, setting

from .controller import ControllerSettings
from .estimator import EstimatorTable
from .external_fmus import FmusSettings
from .hardware import HardwareSettings
from .loads import DisturbanceSettings, WiringSettings
from .muscles import MuscleSettings
from .plant import PlantSettings, StartSettings
from .reference import ReferenceTable
from .robots import PartSettings, RobotSettings
from .run import RunSettings
from .world import WorldSettings


class ExperimentTables(Table):
    """An experiment of CARDSFlow: what is simulated, how it is controlled, and for how long."""

    model_config = ConfigDict(
        json_schema_extra={"oneOf": [{"required": ["robot"]}, {"required": ["robots"]}]}
    )

    robot: RobotSettings = setting("The robot.", None)
    robots: Annotated[
        tuple[PartSettings, ...], Listed, Field(json_schema_extra={"minItems": 1})
    ] = setting("Several robots in one plant, in the place of [robot].", None)
    muscles: dict[str, MuscleSettings] = setting(
        "Force bounds and models of single muscles, by the muscle's name.", {}
    )
    start: StartSettings = setting(
        "The state at the start; where it is silent, that of the reference.", {}
    )
    reference: ReferenceTable = setting(
        "What is to be followed: points, a recorded motion, a trajectory by its name, or a flower.",
        None,
    )
    controller: ControllerSettings = setting("The controller.")
    disturbance: DisturbanceSettings = setting("Forces on task points from outside.", {})
    world: WorldSettings = setting("What is around the robot.", None)
    plant: PlantSettings = setting("The simulated robot.", {})
    estimator: EstimatorTable = setting(
        "The state from the muscles, between plant or hardware and controller.", None
    )
    run: RunSettings = setting("The co-simulation.", {})
    wiring: WiringSettings = setting(
        "Inputs that are not connected to the output of the same name.", {}
    )
    fmus: FmusSettings = setting(
        "External FMUs in the place of plant, controller, reference, estimator or hardware.", {}
    )
    hardware: HardwareSettings = setting("What can be driven instead of the plant.", {})

    @model_validator(mode="after")
    def _check_robots(self) -> Self:
        if self.robots is not None and self.robot is not None:
            raise SettingError("there is a [robot] as well; give one of them", key="robots")
        if self.robots is None and self.robot is None:
            raise SettingError("missing", key="robot")
        if self.robots == ():
            raise SettingError("must be a list of tables: [[robots]]", key="robots")
        return self
