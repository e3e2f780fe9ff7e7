"""Plant as an FMU model.

Inputs are commands and loads; outputs are positions, velocities, lengths and task coordinates.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from addin_sdfusion.robot import Robot
from cardsflow_fmu.cosim.signals.continuous import (
    continuous_groups,
    limited_sides,
    state_ports_of,
)
from cardsflow_fmu.cosim.signals.dependencies import Dependencies, plant_dependencies
from cardsflow_fmu.cosim.signals.groups import Groups
from cardsflow_fmu.cosim.signals.muscles import (
    commanded_muscles,
    friction_muscles,
    modelled_muscles,
    muscles_with_tension,
    state_order,
)
from cardsflow_fmu.cosim.signals.ports import plant_groups
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.experiment.settings.plant import PlantSettings
from sim_dart import CoreDynamics, compile_blob
from sim_dart.core.blob import fixed_energy
from sim_dart.core.tasks import point_rows, task_rows
from sim_dart.core.wrench_points import wrench_points
from sim_dart.plant.settings import unsupported_by_core, unsupported_by_rk4

from .c_model import CModel
from .dart_plant import DartPlant
from .native.fields import Counts, Fields, encode
from .native.opened_model import OpenedModel
from .start_commands import start

_INTEGRATORS = ("euler", "rk4")


class PlantModel(CModel):
    """Simulated robot. A step consists of one or more internal steps.

    The plant computes in C. It uses DART for contacts and muscle laws in Python, or if the
    experiment selects this engine.
    """

    description = "Simulated robot with muscles"

    opened: OpenedModel | DartPlant

    def _open(self, experiment: Experiment) -> OpenedModel | DartPlant:
        if self.missing(experiment) is None:
            return self._opened_in_c(experiment)
        return DartPlant(experiment, self.views)

    @staticmethod
    def groups(experiment: Experiment) -> Groups:
        """Return the variables for an experiment in named groups."""
        begin, plant = experiment.start, experiment.plant
        initial = start(experiment.robot, begin.q, experiment.feedback)
        return plant_groups(
            experiment.robot,
            begin.q,
            begin.qd,
            plant.step,
            forces=initial.forces.tolist(),
            commands=initial.commands,
            energy=plant.energy,
            wrenches=plant.wrenches,
            scene=experiment.scene,
            has_tensions=experiment.faults is not None,
        )

    @classmethod
    def dependencies(cls, experiment: Experiment) -> Dependencies:
        """Return the dependencies of the outputs without creating the model."""
        return plant_dependencies(experiment.plant_robot, cls.groups(experiment))

    @classmethod
    def missing(cls, experiment: Experiment) -> str | None:
        """Return a requirement of the experiment that C does not support, or None."""
        if experiment.plant.engine == "dart":
            return 'the engine "dart"'
        return unsupported_by_core(experiment.scene, experiment.plant_robot)

    @classmethod
    def file(cls, experiment: Experiment) -> bytes:
        """Return the contents of the file `native.bin` of the model."""
        robot, plant = experiment.plant_robot, experiment.plant
        CoreDynamics(robot)  # raises an error if the mass matrix is singular
        groups, scales = cls.groups(experiment), plant.tension_scale
        counts, fields = plant_fields(
            robot, plant.substeps, plant.integrator, plant.wrenches, scales, groups
        )
        fields["break_time"] = break_times(plant) or fields["break_time"]
        return encode("plant", compile_blob(robot), groups, counts, fields)


class ContinuousPlantModel(PlantModel):
    """Plant in continuous time, for model exchange, in C only."""

    description = "Simulated robot with muscles, in continuous time"

    @staticmethod
    def groups(experiment: Experiment) -> Groups:
        """Return the variables for an experiment in named groups."""
        return continuous_groups(experiment.robot, PlantModel.groups(experiment))

    @classmethod
    def missing(cls, experiment: Experiment) -> str | None:
        """Return a requirement that model exchange does not support, or None."""
        plant = experiment.plant
        if any(plant.break_time):
            return "breaking cables (plant.break_time)"
        return unsupported_by_rk4(plant.engine, experiment.scene, experiment.plant_robot)

    @classmethod
    def file(cls, experiment: Experiment) -> bytes:
        """Return the contents of the file `native.bin` of the model."""
        robot, plant = experiment.plant_robot, experiment.plant
        CoreDynamics(robot)  # raises an error if the mass matrix is singular
        groups = cls.groups(experiment)
        return continuous_file(robot, groups, plant.wrenches, plant.tension_scale)


def continuous_file(
    robot: Robot,
    groups: Groups,
    wrenches: Sequence[str] = (),
    tension_scale: Sequence[float] = (),
) -> bytes:
    """Return the file `native.bin` of a plant in continuous time."""
    counts, fields = plant_fields(robot, 1, "rk4", wrenches, tension_scale, groups)
    fields["nominals"] = [port.nominal for port in state_ports_of(groups)]
    fields["limited"] = [2 * j + side for j, side in limited_sides(robot)]
    return encode("plant", compile_blob(robot), groups, counts, fields)


def plant_fields(
    robot: Robot,
    substeps: int,
    integrator: str = "euler",
    wrenches: Sequence[str] = (),
    tension_scale: Sequence[float] = (),
    groups: Groups | None = None,
) -> tuple[Counts, Fields]:
    """Return counts and fields of a plant; see `encode`.

    Args:
        substeps: Integrator steps per internal step.
        integrator: Integration method.
        wrenches: Names of links with external wrenches.
        tension_scale: Factor on the tension of each muscle; 1 if empty.
        groups: Variables of the plant; by default, tensions of muscles with laws are outputs.
    """
    frames, points = wrench_points(robot, wrenches)
    fields: Fields = {
        "load_rows": point_rows(robot),
        "task_rows": task_rows(robot),
        "commanded": commanded_muscles(robot),
        "motors": motors(robot),
        "modelled": modelled_muscles(robot)
        if groups is None
        else muscles_with_tension(robot, groups),
        "rubbing": friction_muscles(robot),
        "state_order": state_order(robot),
        "external_frame": frames,
        "external_point": points,
        "substeps": substeps,
        "integrator": _INTEGRATORS.index(integrator),
        "tension_scale": tension_scale or [1.0] * len(robot.muscles),
        "break_time": [math.inf] * len(robot.muscles),
        "fixed_energy": fixed_energy(robot),
        "nominals": [],
        "limited": [],
    }
    return {"external_points": len(frames)}, fields


def break_times(settings: PlantSettings) -> list[float]:
    """Return the time at which each cable breaks, in [s], or infinity."""
    return [time or math.inf for time in settings.break_time]


def motors(robot: Robot) -> list[int]:
    """Return the index of the coordinate of each motor."""
    return [j for j, coordinate in enumerate(robot.coordinates) if coordinate.actuated]
