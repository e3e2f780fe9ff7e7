"""Experiment of a robot without dynamics, for pages in which a user only moves its joints."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from addin_sdfusion.robot import Inertia, Robot
from addin_sdfusion.robot.model.muscle import CableModel
from addin_sdfusion.robot.model.trajectory import Trajectory
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.experiment.settings.controller import ControllerSettings
from cardsflow_fmu.experiment.settings.plant import PlantSettings, StartSettings
from cardsflow_fmu.experiment.settings.reference import ReferenceSettings
from cardsflow_fmu.experiment.settings.run import RunSettings

_STEP = 0.001


def pose_experiment(robot: Robot, q: Sequence[float]) -> Experiment:
    """Return an experiment for the drive mode `pose`, with ideal cables and unit inertias.

    It has the muscle paths of the robot, but neither its muscle laws nor its masses, which a robot
    file may lack.

    Args:
        q: Joint positions, shape (n,), in [rad] or [m].
    """
    unit = Inertia(1.0, ixx=1.0, iyy=1.0, izz=1.0)
    muscles = [
        replace(muscle.with_friction_scaled(0.0), model=CableModel()) for muscle in robot.muscles
    ]
    links = tuple(replace(link, inertia=unit) for link in robot.links)
    return Experiment(
        file=Path(robot.name),
        robot=replace(robot.with_muscles(muscles), links=links),
        robot_path=Path(robot.name),
        robot_files=(),
        reference=ReferenceSettings("joint", Trajectory("", "linear", (), _STEP)),
        disturbance=None,
        start=StartSettings.model_construct(q=tuple(q), qd=(0.0,) * len(q)),
        plant=PlantSettings.model_construct(
            step=_STEP, tension_scale=(1.0,) * len(muscles), mass_scale=(), friction_scale=()
        ),
        controller=ControllerSettings.model_construct(period=_STEP),
        run=RunSettings.model_construct(step=_STEP),
        wiring={},
    )
