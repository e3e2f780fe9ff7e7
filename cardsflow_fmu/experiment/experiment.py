"""Experiment: robot, reference, controller and run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from addin_sdfusion.robot import Finding, InputError, Robot, check
from addin_sdfusion.robot.checks.not_simulated import not_simulated
from cardsflow_fmu.cosim.coupling import Coupling
from cardsflow_fmu.cosim.external_fmu import ExternalFmu
from cardsflow_fmu.cosim.signals.roles import ESTIMATOR, HARDWARE, ROLES, SENSORS
from cardsflow_fmu.utils.key_file import key_warning
from sim_dart.muscles.friction import has_cable_friction

from .motion.feedback import MotionFeedback
from .motion.look_ahead import LookAhead
from .motion.settings import MotionTable
from .packed_files import mesh_roots, omitted_meshes
from .reader import read_experiment, read_packed_experiment
from .settings.controller import ControllerSettings
from .settings.controller_types import DEFAULT_GAINS, FEEDBACK
from .settings.estimator import EstimatorTable
from .settings.faults import FaultsTable
from .settings.file import AboutSettings
from .settings.hardware import HardwareSettings
from .settings.loads import DisturbanceSettings
from .settings.plant import PlantSettings, StartSettings
from .settings.reference import ReferenceSettings
from .settings.robots import RobotPart, robot_names
from .settings.run import RunSettings
from .settings.world import WorldSettings

if TYPE_CHECKING:
    from sim_dart.scene import Scene

EXPERIMENT_FILE = "experiment.json"
"""Name of the experiment file in the resources of an FMU."""


@dataclass(frozen=True)
class Experiment:
    """Complete and checked experiment.

    Attributes:
        robot: The robot, with the cable set and the changes of the experiment.
        robot_path: Main file of the robot.
        disturbance: External forces; None without external forces.
        start: The initial state.
        run: Settings of the co-simulation.
        wiring: Output or constant number by input, for inputs that are not connected to the output
            with the same name: `controller.q.elbow` -> `plant.q.elbow`.
        fmus: External FMUs that replace plant, controller or reference, by role.
        robot_overrides: Changes of the robot; see `robot_overrides`.
        scene: Ground and objects around the robot; None without any.
        world: The settings of the scene.
        world_findings: Warnings about content of the SDF world that is not read.
        parts: The robots that `robot` consists of; empty for a single robot.
        hardware: Hardware that can run instead of the plant.
        estimator: The state estimator; None if it is not used.
        faults: Detection of faults; None if it is not used.
        look_ahead: Speeds of the reference after the loss of muscles; None if not computed.
        about: Author, copyright and licence of the FMUs.
        named: Files that the user has named explicitly; they may be packed from any folder.
        motion: Optimal motion for `cardsflow optimise`; None without it. FMUs do not contain it.
        feedback: Forces and gains of an optimal motion; None if the controller does not use them.
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
    world_findings: tuple[Finding, ...] = ()
    parts: tuple[RobotPart, ...] = ()
    hardware: HardwareSettings = field(default_factory=HardwareSettings)
    about: AboutSettings = field(default_factory=AboutSettings)
    named: tuple[Path, ...] = ()
    estimator: EstimatorTable | None = None
    faults: FaultsTable | None = None
    look_ahead: LookAhead | None = None
    motion: MotionTable | None = None
    feedback: MotionFeedback | None = None

    def show(self) -> Any:
        """Return a page of the robot that a notebook displays; else, open the browser."""
        # The viewer is in a higher layer than experiments.
        return import_module("cardsflow_fmu.results.viewer.inline").show(self)

    @property
    def name(self) -> str:
        """Name of the folder of the experiment."""
        return self.file.resolve().parent.name

    @property
    def roles(self) -> tuple[str, ...]:
        """Participants of a run, with sensors and estimator if used."""
        if self.estimator is None:
            return ROLES
        return (*ROLES, ESTIMATOR) if self.hardware.use else (*ROLES, SENSORS, ESTIMATOR)

    def model_of(self, role: str) -> str:
        """Return the name of the model in a role; the hardware can replace the plant."""
        return HARDWARE if role == "plant" and self.hardware.use else role

    @property
    def columns(self) -> tuple[str, ...]:
        """Participants in the order of the columns of a run."""
        return ("plant", "reference", *self.roles[len(ROLES) :], "controller")

    @property
    def stepping(self) -> Coupling:
        """Coupling of the participants; sensors and estimator run before the controller."""
        coupling = self.run.stepping
        if coupling.scheme == "jacobi" or len(self.roles) == len(ROLES):
            return coupling
        order = coupling.order
        at = order.index("controller")
        return replace(coupling, order=(*order[:at], *self.roles[len(ROLES) :], *order[at:]))

    @property
    def feedback_estimator(self) -> EstimatorTable | None:
        """Estimator that provides the state to the controller; None: the ground truth."""
        return self.estimator if self.estimator is not None and self.estimator.feedback else None

    @property
    def reacts_to_faults(self) -> bool:
        """Whether the controller reacts to lost muscles."""
        return self.faults is not None and self.faults.react

    @property
    def roots(self) -> tuple[Path, ...]:
        """Folders and files that may be packed; see `packed_files`."""
        return mesh_roots(
            self.file, [self.robot_path, *(p.files[0] for p in self.parts)], self.named
        )

    @staticmethod
    def load(
        path: str | Path, settings: Mapping[str, Any] | None = None, *, names_files: bool = True
    ) -> Experiment:
        """Read an experiment.

        Args:
            path: An experiment.toml or its folder.
            settings: Changes by full key, such as `{"controller.period": 0.01}`.
            names_files: Whether files that the settings name may be packed from any folder. Use
                false for settings from an untrusted file.

        Raises:
            InputError: The experiment is invalid; the message names file and key.
        """
        return Experiment(**read_experiment(Path(path), settings or {}, names_files=names_files))

    @staticmethod
    def from_resources(folder: Path) -> Experiment:
        """Read the experiment in an unpacked FMU or in results.

        Raises:
            InputError: The experiment is invalid, or names files outside of the folder.
        """
        return Experiment(**read_packed_experiment(folder / EXPERIMENT_FILE))

    @cached_property
    def plant_robot(self) -> Robot:
        """Robot of the plant, with scaled masses and friction.

        Raises:
            InputError: The robot with scaled masses or friction is invalid.
        """
        robot, masses, frictions = self.robot, self.plant.mass_scale, self.plant.friction_scale
        if any(scale != 1.0 for scale in frictions):
            pairs = zip(robot.muscles, frictions, strict=True)
            robot = robot.with_muscles([muscle.with_friction_scaled(k) for muscle, k in pairs])
            self._check_robot(robot, "plant.friction_scale")
        if any(scale != 1.0 for scale in masses):
            links = tuple(
                replace(link, inertia=link.inertia.scaled(scale))
                for link, scale in zip(robot.links, masses, strict=True)
            )
            robot = replace(robot, links=links)
            self._check_robot(robot, "plant.mass_scale")
        return robot

    def _check_robot(self, robot: Robot, key: str) -> None:
        """Check a robot that a setting has changed."""
        wrong = next((finding for finding in check(robot) if finding.is_error), None)
        if wrong is not None:
            raise InputError(str(wrong).removeprefix("error: "), file=self.file, key=key)

    def warnings(self) -> list[str]:
        """Return warnings about gains, key files, cables, meshes and the world, one line each."""
        file = self.hardware.key_file if self.hardware.use else None
        key = None if file is None else key_warning(file, "hardware.key_file")
        robots, roots = self.parts or (self,), self.roots
        meshes = [line for one in robots for line in omitted_meshes(one.robot, one.folder, roots)]
        cables = [] if self.hardware.use else not_simulated(self.robot)
        world = [finding.located for finding in self.world_findings]
        lines = (self._gain_warning(), self._friction_warning(), key, *cables, *meshes, *world)
        return [warning for warning in lines if warning is not None]

    @property
    def folder(self) -> Path:
        """Folder of the main file of the robot."""
        return self.robot_path.parent

    def _friction_warning(self) -> str | None:
        """Return a warning about cable friction that has no effect, or None."""
        is_set = any(muscle.friction for muscle in self.robot.muscles)
        has_friction = has_cable_friction(self.robot)
        if is_set and not has_friction:
            return "cable friction has no effect: no cable with friction is bent between its ends"
        if not has_friction and any(scale != 1.0 for scale in self.plant.friction_scale):
            return "plant.friction_scale has no effect: no muscle has friction"
        return None

    def _gain_warning(self) -> str | None:
        """Return a warning about gains that make the sampled control loop unstable, or None."""
        from controllers.analysis.gains import sampling_warning

        controller = self.controller
        if controller.type == FEEDBACK:
            if (controller.kp[0], controller.kd[0]) == DEFAULT_GAINS:
                return None
            return f"controller.kp and kd have no effect: {FEEDBACK!r} uses the gains of the motion"
        has_law = controller.custom_law is None and controller.policy is None
        if controller.torque_gains or not has_law:
            return None
        names = robot_names(self.robot, controller.space)["followed"].names
        delay = 0 if controller.predict else controller.delay
        return sampling_warning(controller.kp, controller.kd, controller.period, delay, names)
