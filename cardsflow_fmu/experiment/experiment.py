"""experiment.toml -> Experiment: what is simulated, how it is controlled, and for how long."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from addin_sdfusion.robot import Robot
from addin_sdfusion.robot.model.trajectory import Space, Trajectory
from cardsflow_fmu.cosim.coupling import Coupling
from cardsflow_fmu.cosim.external_fmu import ExternalFmu

from .controller_types import TYPES
from .hardware_settings import HardwareSettings
from .resources import EXPERIMENT_FILE
from .table_forms import TableForm

if TYPE_CHECKING:
    from sim_dart.scene import Scene

    from .robots import RobotPart

Rule = Literal["euler", "rk4"]
"""The integrators of a plant."""

Engine = Literal["auto", "core", "dart"]
"""What computes a plant, or a controller's dynamics; see `sim_dart.plant.engine`."""

MOST_SUBSTEPS = 1_000_000
"""As `sim_dart.plant.plant` has it."""


@dataclass(frozen=True, slots=True)
class StartSettings:
    """The state at the start.

    Attributes:
        q: Joint positions, in [rad] or [m].
        qd: Joint velocities, in [rad/s] or [m/s].
    """

    q: tuple[float, ...]
    qd: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class PlantSettings:
    """The simulated robot.

    Attributes:
        step: Internal step, in [s].
        mass_scale: Factor on the mass and inertia of every link, beside what the controller knows.
        integrator: `euler`, or `rk4` where there are no contacts; see `sim_dart.Plant`.
        substeps: Steps of the integrator in an internal step, with commands held.
        energy: Whether energies, work and momenta are outputs.
        wrenches: Names of links that take forces and torques from outside.
        engine: `core`, `dart`, or `auto` for the core where there are no contacts.
    """

    step: float
    mass_scale: tuple[float, ...]
    integrator: Rule = "euler"
    substeps: int = 1
    energy: bool = False
    wrenches: tuple[str, ...] = ()
    engine: Engine = "auto"


@dataclass(frozen=True, slots=True)
class FlowerSettings:
    """A rose curve in operational space; see `controllers.Flower`.

    Attributes:
        centre: In [m].
        axes: The two unit vectors that span its plane.
        radius: In [m].
        petals: Number k of r = radius · cos(k phi).
        duration: In [s].
    """

    centre: tuple[float, ...]
    axes: tuple[tuple[float, ...], tuple[float, ...]]
    radius: float
    petals: int
    duration: float


@dataclass(frozen=True, slots=True)
class ApproachSettings:
    """A straight way, from rest to rest, to where the reference begins.

    Attributes:
        duration: In [s].
        start: Where it begins: q or y, in [rad] or [m].
    """

    duration: float
    start: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class ReferenceSettings:
    """What is to be followed: a trajectory or a flower.

    Attributes:
        space: Whether it is made of joint positions q or task coordinates y.
        curve: The way.
        approach: The way to its beginning; None if the robot starts there.
    """

    space: Space
    curve: Trajectory | FlowerSettings
    approach: ApproachSettings | None = None

    @property
    def duration(self) -> float:
        """How long it takes, with its approach, in [s]."""
        curve = self.curve
        own = curve.duration if isinstance(curve, FlowerSettings) else curve.points[-1].time
        return own + (self.approach.duration if self.approach else 0.0)


@dataclass(frozen=True, slots=True)
class DisturbanceSettings:
    """Forces on task points from outside.

    Attributes:
        forces: Force on every task frame that is a point, in world axes, in [N].
        begin, end: When it acts, in [s].
        known: Whether the controller is told.
    """

    forces: tuple[tuple[float, float, float], ...]
    begin: float
    end: float
    known: bool


@dataclass(frozen=True, slots=True)
class PostureSettings:
    """What a redundant robot does beside its tasks; see `controllers.Posture`.

    Attributes:
        kp, kd: Gains of every coordinate, in [1/s²] and [1/s].
        q0: The preferred posture, in [rad] or [m].
    """

    kp: tuple[float, ...]
    kd: tuple[float, ...]
    q0: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class TaskSettings:
    """What the operational-space controller weighs; see `controllers.OperationalSpaceController`.

    Attributes:
        posture: None for the paper's literal eq. (4).
        task_weights: W, one a task coordinate; infinite for tasks that are to be met exactly.
        priorities: Rank of every task coordinate, 1 first.
        acceleration_weights: Diagonal of H_q, one a coordinate.
        force_rate_weights: Diagonal of H_r, one a muscle, in [1/N²].
        pretension: f_p of every muscle, in [N].
        limit_bandwidth: How joint limits are kept, in [rad/s]; None to leave them to the robot.
    """

    posture: PostureSettings | None
    task_weights: tuple[float, ...]
    priorities: tuple[float, ...]
    acceleration_weights: tuple[float, ...]
    force_rate_weights: tuple[float, ...]
    pretension: tuple[float, ...]
    limit_bandwidth: float | None


@dataclass(frozen=True, slots=True)
class ControllerSettings:
    """The controller.

    Attributes:
        type: Kind of controller.
        kp, kd: Gains of every coordinate, or task coordinate, in [1/s²] and [1/s]; where they make
            torques, in [N·m/rad] and [N·m·s/rad], or [N/m] and [N·s/m].
        period: Time between two ticks, in [s].
        solver: Name of a QP back end.
        weights: Diagonal of H or H_f, one a muscle, in [1/N²].
        ki: Integral gain of every coordinate, or task coordinate, in [1/s³], or that of kp by [s].
        observer: Bandwidth of the disturbance observer, in [rad/s]; 0 for none.
        delay: Ticks until a tick's forces take effect, 0 or 1.
        predict: Whether the controller makes up for the delay.
        tasks: Of a controller in operational space; else None.
        muscle_horizon: How far ahead the commands of muscles with laws aim, in [s]; 0 for the next
            tick, or a few where muscles answer late.
        engine: What computes the dynamics that it knows: `core`, which is `auto` as well; or
            `dart`.
    """

    type: str
    kp: tuple[float, ...]
    kd: tuple[float, ...]
    period: float
    solver: str
    weights: tuple[float, ...]
    ki: tuple[float, ...]
    observer: float
    delay: int
    predict: bool
    tasks: TaskSettings | None
    muscle_horizon: float = 0.0
    engine: Engine = "auto"

    @property
    def space(self) -> Space:
        """What it follows: joint positions, or task coordinates."""
        return "joint" if self.tasks is None else "operational"

    @property
    def torque_gains(self) -> bool:
        """Whether the gains make torques of errors, instead of accelerations."""
        return TYPES[self.type].torque_gains


@dataclass(frozen=True, slots=True)
class RunSettings:
    """The co-simulation.

    Attributes:
        duration: In [s].
        step: Communication step, in [s].
        output: Folder for the results.
        coupling: In what order plant, controller and reference are stepped.
        format: Of the table of results: `csv` or `parquet`.
    """

    duration: float
    step: float
    output: Path
    coupling: Coupling = field(default_factory=Coupling)
    format: TableForm = "csv"

    @property
    def steps(self) -> int:
        """Number of communication steps."""
        return round(self.duration / self.step)


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
        robot_changes: What the experiment changes of the robot's files; see `robot_changes`.
        scene: What stands around the robot; None for nothing.
        parts: The robots that `robot` is made of; none where it is one by itself.
        hardware: What can be driven instead of the plant.
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
    robot_changes: Mapping[str, Any] = field(default_factory=dict)
    scene: Scene | None = None
    parts: tuple[RobotPart, ...] = ()
    hardware: HardwareSettings = field(default_factory=HardwareSettings)

    @property
    def name(self) -> str:
        """Name of the folder that the experiment stands in."""
        return self.file.resolve().parent.name

    @staticmethod
    def load(path: str | Path, settings: Mapping[str, Any] | None = None) -> Experiment:
        """Read an experiment.

        Args:
            path: An experiment.toml, or the folder that holds one.
            settings: Changes by full key, such as `{"controller.period": 0.01}`.

        Raises:
            InputError: Something in it is wrong; the message names file and key.
        """
        from .reader import read_experiment

        return read_experiment(Path(path), settings or {})

    @staticmethod
    def from_resources(folder: Path) -> Experiment:
        """Read the experiment that travels in an FMU.

        Args:
            folder: The FMU's resources.

        Raises:
            InputError: Something in it is wrong.
        """
        return Experiment.load(folder / EXPERIMENT_FILE)

    def resources(self, *, with_hardware: bool = False) -> dict[str, bytes | Path]:
        """The files that an FMU carries: the experiment, complete, its robots, and their meshes.

        Args:
            with_hardware: Whether to tell of the hardware, which is nothing to the other FMUs: they
                are the same files whatever is driven.

        Returns:
            Content, or a file to copy, by its path below the FMU's resources.

        Raises:
            InputError: A mesh stands where it cannot be taken along from.
        """
        from .resources import experiment_resources

        return experiment_resources(self, with_hardware=with_hardware)

    @cached_property
    def plant_robot(self) -> Robot:
        """The robot as it is simulated."""
        scales = self.plant.mass_scale
        if all(scale == 1.0 for scale in scales):
            return self.robot
        links = tuple(
            replace(link, inertia=link.inertia.scaled(scale))
            for link, scale in zip(self.robot.links, scales, strict=True)
        )
        return replace(self.robot, links=links)

    def warnings(self) -> list[str]:
        """What will probably go wrong, a line each: gains for a slower loop, a key that is none."""
        return [*self._gain_warnings(), *self._key_warnings()]

    def _key_warnings(self) -> list[str]:
        from cardsflow_fmu.utils.key_file import key_warning

        file = self.hardware.key_file if self.hardware.use else None
        warning = None if file is None else key_warning(file)
        return [] if warning is None else [warning]

    def _gain_warnings(self) -> list[str]:
        """A sampled loop that its gains make unstable."""
        from controllers.analysis.gains import sampling_warning

        controller = self.controller
        if controller.torque_gains:
            return []
        names = (
            [c.name for c in self.robot.coordinates]
            if controller.space == "joint"
            else [f"{f.name}.{axis}" for f in self.robot.task_frames for axis in f.axes]
        )
        delay = 0 if controller.predict else controller.delay
        warning = sampling_warning(controller.kp, controller.kd, controller.period, delay, names)
        return [] if warning is None else [warning]

    @cached_property
    def data(self) -> dict[str, Any]:
        """Everything but the robot's files as plain data, which reads back as this experiment."""
        from .writer import experiment_data

        return experiment_data(self)
