"""Experiment: what is simulated, how it is controlled, and for how long."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from addin_sdfusion.robot import InputError, Robot, check
from addin_sdfusion.robot.checks.not_simulated import not_simulated
from cardsflow_fmu.cosim.coupling import Coupling
from cardsflow_fmu.cosim.external_fmu import ExternalFmu
from cardsflow_fmu.cosim.signals.roles import ESTIMATOR, HARDWARE, ROLES, SENSORS
from cardsflow_fmu.utils.key_file import key_warning
from sim_dart.muscles.friction import rubs

from .carried_files import left_out, mesh_roots
from .reader import read_carried_experiment, read_experiment
from .settings.controller import ControllerSettings
from .settings.estimator import EstimatorTable
from .settings.hardware import HardwareSettings
from .settings.loads import DisturbanceSettings
from .settings.names import robot_names
from .settings.plant import PlantSettings, StartSettings
from .settings.reference import ReferenceSettings
from .settings.robots import RobotPart
from .settings.run import RunSettings
from .settings.world import WorldSettings

if TYPE_CHECKING:
    from sim_dart.scene import Scene

EXPERIMENT_FILE = "experiment.json"
"""The experiment among the resources of an FMU."""


@dataclass(frozen=True)
class Experiment:
    """An experiment, complete and checked.

    Attributes:
        file: Where it comes from.
        robot: The robot, with the cable set and the bounds that the experiment asks for.
        robot_path: The robot's main file.
        robot_files: Every file that makes up the robot.
        reference: What is to be followed.
        disturbance: Forces from outside; None where there are none.
        start: The state at the start.
        plant: Settings of the plant.
        controller: Settings of the controller.
        run: Settings of the co-simulation.
        wiring: Inputs that are not connected to the output of the same name: `controller.q.elbow`
            -> `plant.q.elbow`, or the number that it is held at.
        fmus: External FMUs that take the place of plant, controller or reference, by that name.
        robot_overrides: What the experiment changes of the robot's files; see `robot_overrides`.
        scene: What is around the robot; None for nothing.
        world: The settings of the scene.
        parts: The robots that `robot` is made of; none where it is one by itself.
        hardware: What can be driven instead of the plant.
        estimator: What makes the state of readings; None where there is none in use.
        named: Files that whoever loaded it named besides: they may travel from anywhere.
    """

    file: Path
    robot: Robot
    robot_path: Path
    robot_files: tuple[Path, ...]
    reference: ReferenceSettings
    disturbance: DisturbanceSettings | None
    start: StartSettings
    plant: PlantSettings
    controller: ControllerSettings
    run: RunSettings
    wiring: Mapping[str, str | float]
    fmus: Mapping[str, ExternalFmu] = field(default_factory=dict)
    robot_overrides: Mapping[str, Any] = field(default_factory=dict)
    scene: Scene | None = None
    world: WorldSettings | None = None
    parts: tuple[RobotPart, ...] = ()
    hardware: HardwareSettings = field(default_factory=HardwareSettings)
    named: tuple[Path, ...] = ()
    estimator: EstimatorTable | None = None

    @property
    def name(self) -> str:
        """Name of the experiment's folder."""
        return self.file.resolve().parent.name

    @property
    def roles(self) -> tuple[str, ...]:
        """The participants of a run: those of every run, sensors and estimator."""
        if self.estimator is None:
            return ROLES
        return (*ROLES, ESTIMATOR) if self.hardware.use else (*ROLES, SENSORS, ESTIMATOR)

    def model_of(self, role: str) -> str:
        """Name of the model in a role: the hardware's in that of the plant, where it is used."""
        return HARDWARE if role == "plant" and self.hardware.use else role

    @property
    def columns(self) -> tuple[str, ...]:
        """The participants in the order of the columns of a run."""
        return ("plant", "reference", *self.roles[len(ROLES) :], "controller")

    @property
    def stepping(self) -> Coupling:
        """In what order these are stepped: sensors and estimator right before the controller."""
        own = self.run.stepping
        if own.scheme == "jacobi" or len(self.roles) == len(ROLES):
            return own
        at = own.order.index("controller")
        return replace(own, order=(*own.order[:at], *self.roles[len(ROLES) :], *own.order[at:]))

    @property
    def feeding(self) -> EstimatorTable | None:
        """The estimator that the controller gets its state from; None where it gets the truth."""
        return self.estimator if self.estimator is not None and self.estimator.feedback else None

    @property
    def roots(self) -> tuple[Path, ...]:
        """Folders whose files may travel, and single files; see `carried_files`."""
        return mesh_roots(
            self.file, [self.robot_path, *(p.files[0] for p in self.parts)], self.named
        )

    @staticmethod
    def load(
        path: str | Path, settings: Mapping[str, Any] | None = None, *, names_files: bool = True
    ) -> Experiment:
        """Read an experiment.

        Args:
            path: An experiment.toml, or the folder that holds one.
            settings: Changes by full key, such as `{"controller.period": 0.01}`.
            names_files: Whether the files that the settings name may be packed from anywhere; not
                where the settings come from a file.

        Raises:
            InputError: Something in it is wrong; the message names file and key.
        """
        return Experiment(**read_experiment(Path(path), settings or {}, names_files=names_files))

    @staticmethod
    def from_resources(folder: Path) -> Experiment:
        """Read the experiment among the files of an FMU or of results.

        Args:
            folder: The FMU's resources.

        Raises:
            InputError: Something in it is wrong, or it leads out of the folder.
        """
        return Experiment(**read_carried_experiment(folder / EXPERIMENT_FILE))

    @cached_property
    def plant_robot(self) -> Robot:
        """The robot as it is simulated.

        Raises:
            InputError: With its masses or friction scaled it is none that can be simulated.
        """
        robot, masses, frictions = self.robot, self.plant.mass_scale, self.plant.friction_scale
        if any(scale != 1.0 for scale in frictions):
            pairs = zip(robot.muscles, frictions, strict=True)
            robot = robot.with_muscles([muscle.with_friction_scaled(k) for muscle, k in pairs])
            self._require(robot, "plant.friction_scale")
        if any(scale != 1.0 for scale in masses):
            links = tuple(
                replace(link, inertia=link.inertia.scaled(scale))
                for link, scale in zip(robot.links, masses, strict=True)
            )
            robot = replace(robot, links=links)
            self._require(robot, "plant.mass_scale")
        return robot

    def _require(self, robot: Robot, key: str) -> None:
        """Refuse a robot that a setting has made wrong with an InputError."""
        wrong = next((finding for finding in check(robot) if finding.is_error), None)
        if wrong is not None:
            raise InputError(str(wrong).removeprefix("error: "), file=self.file, key=key)

    def warnings(self) -> list[str]:
        """What will probably go wrong or is left out, a line each: gains, keys, cables, meshes."""
        file = self.hardware.key_file if self.hardware.use else None
        key = None if file is None else key_warning(file, "hardware.key_file")
        robots = self.parts or (self,)
        meshes = [line for it in robots for line in left_out(it.robot, it.folder, self.roots)]
        cables = [] if self.hardware.use else not_simulated(self.robot)
        found = (self._gain_warning(), self._idle_friction(), key, *cables, *meshes)
        return [warning for warning in found if warning is not None]

    @property
    def folder(self) -> Path:
        """The folder of the robot's main file."""
        return self.robot_path.parent

    def _idle_friction(self) -> str | None:
        """Friction of cables that none has, or none that bends."""
        rough = any(muscle.friction for muscle in self.robot.muscles)
        if rough and not rubs(self.robot):
            return "friction of cables is without effect: none that has one bends between its ends"
        if not rubs(self.robot) and any(scale != 1.0 for scale in self.plant.friction_scale):
            return "plant.friction_scale is without effect: no muscle has a friction"
        return None

    def _gain_warning(self) -> str | None:
        """A sampled loop that its gains make unstable."""
        from controllers.analysis.gains import sampling_warning

        controller = self.controller
        if controller.torque_gains or controller.custom_law is not None:
            return None
        names = robot_names(self.robot, controller.space)["followed"].names
        delay = 0 if controller.predict else controller.delay
        return sampling_warning(controller.kp, controller.kd, controller.period, delay, names)
