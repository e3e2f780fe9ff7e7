"""All tables of experiment.toml."""

from __future__ import annotations

from typing import Annotated, Self

from pydantic import ConfigDict, Field, model_validator

from cardsflow_fmu.experiment.config.messages import SettingError
from cardsflow_fmu.experiment.config.table import Listed, Table, setting
from cardsflow_fmu.experiment.motion.settings import MotionTable

from .controller import ControllerSettings
from .estimator import EstimatorTable
from .external_fmus import FmusSettings
from .faults import FaultsTable
from .hardware import HardwareSettings
from .loads import DisturbanceSettings, WiringSettings
from .muscles import MuscleSettings
from .plant import PlantSettings, StartSettings
from .reference import ReferenceTable
from .robots import PartSettings, RobotSettings
from .run import RunSettings
from .world import WorldSettings


class AboutSettings(Table):
    """Author, copyright and licence in the FMUs that are built."""

    author: str = setting("author of the FMUs", "")
    copyright: str = setting("copyright notice of the FMUs", "")
    license: str = setting("licence of the FMUs, by name or link", "BSD-3-Clause")


class ExperimentTables(Table):
    """Experiment of CARDSFlow: robot, reference, controller, and run."""

    model_config = ConfigDict(
        json_schema_extra={
            "oneOf": [{"required": ["robot"]}, {"required": ["robots"]}],
            "allOf": [{"anyOf": [{"required": ["controller"]}, {"required": ["motion"]}]}],
        }
    )

    robot: RobotSettings = setting("The robot.", None)
    robots: Annotated[
        tuple[PartSettings, ...], Listed, Field(json_schema_extra={"minItems": 1})
    ] = setting("Several robots in one plant, instead of [robot].", None)
    muscles: dict[str, MuscleSettings] = setting(
        "Force limits and laws of single muscles, by muscle name.", {}
    )
    start: StartSettings = setting("Initial state (default: the first point of the reference).", {})
    reference: ReferenceTable = setting(
        "Reference: points, a recorded motion, a named trajectory, or a flower (default with "
        "[motion] and without [controller]: the optimal motion).",
        None,
    )
    motion: MotionTable = setting(
        "Optimal motion from the start to goals, for `cardsflow optimise`.", None
    )
    controller: ControllerSettings = setting(
        "The controller (default with [motion]: trajectory_feedback).", None
    )
    disturbance: DisturbanceSettings = setting("External forces on end-effector points.", {})
    world: WorldSettings = setting("Ground, objects and contacts.", None)
    plant: PlantSettings = setting("The simulated robot.", {})
    estimator: EstimatorTable = setting(
        "State estimator between plant or hardware and controller.", None
    )
    faults: FaultsTable = setting("Detection of faults of cables, motors and sensors.", None)
    run: RunSettings = setting("The co-simulation.", {})
    wiring: WiringSettings = setting(
        "Connections of inputs to outputs with other names, or to numbers.", {}
    )
    fmus: FmusSettings = setting(
        "External FMUs instead of plant, controller, reference, estimator or hardware.", {}
    )
    hardware: HardwareSettings = setting("Hardware that runs instead of the plant.", {})
    about: AboutSettings = setting("Author, copyright and licence of the FMUs.", {})

    @model_validator(mode="after")
    def _check_controller(self) -> Self:
        if self.controller is None:
            raise SettingError("missing", key="controller")
        return self

    @model_validator(mode="after")
    def _check_robots(self) -> Self:
        if self.robots is not None and self.robot is not None:
            raise SettingError(
                "cannot be used together with [robot]; remove one of them", key="robots"
            )
        if self.robots is None and self.robot is None:
            raise SettingError("missing", key="robot")
        if self.robots == ():
            raise SettingError("must be a list of tables: [[robots]]", key="robots")
        return self
