"""Robot description, readers, writers and checks. Only the readers use third-party packages."""

from __future__ import annotations

from pathlib import Path

from .checks.check import check, require_valid
from .errors import CardsflowError, InputError, RobotError, SimulationError, UnknownNameError
from .finding import Finding, Subject
from .formats.caspr.capabilities import caspr_losses
from .formats.caspr.write import write_caspr
from .formats.sdf.capabilities import sdf_losses
from .formats.sdf.write import write_sdf
from .model.function import PiecewiseLinear, Polynomial, SimmSpline
from .model.joint import (
    Coordinate,
    Joint,
    JointType,
    LimitForce,
    Motion,
    MotionKind,
    Term,
    prismatic,
    revolute,
)
from .model.loop import LoopJoint
from .model.muscle import BasePulley, CableModel, CableSet, Muscle, ViaPoint, Wrap, WrapSurface
from .model.muscle_path import Branch, CoordinateTerm, PointCondition, PointMotion
from .model.pose import IDENTITY, Pose, Vector3
from .model.robot import GRAVITY, WORLD, Axis, Inertia, Link, Mesh, Robot, Shape, TaskFrame, TaskSet
from .model.trajectory import Space, Spline, Trajectory, TrajectoryPoint
from .transforms.simplify import align_frames, merge_fixed_joints

__all__ = [
    "GRAVITY",
    "IDENTITY",
    "WORLD",
    "Axis",
    "BasePulley",
    "Branch",
    "CableModel",
    "CableSet",
    "CardsflowError",
    "Coordinate",
    "CoordinateTerm",
    "Finding",
    "Inertia",
    "InputError",
    "Joint",
    "JointType",
    "LimitForce",
    "Link",
    "LoopJoint",
    "Mesh",
    "Motion",
    "MotionKind",
    "Muscle",
    "PiecewiseLinear",
    "PointCondition",
    "PointMotion",
    "Polynomial",
    "Pose",
    "Robot",
    "RobotError",
    "Shape",
    "SimmSpline",
    "SimulationError",
    "Space",
    "Spline",
    "Subject",
    "TaskFrame",
    "TaskSet",
    "Term",
    "Trajectory",
    "TrajectoryPoint",
    "UnknownNameError",
    "Vector3",
    "ViaPoint",
    "Wrap",
    "WrapSurface",
    "align_frames",
    "caspr_losses",
    "check",
    "merge_fixed_joints",
    "prismatic",
    "read_robot",
    "require_valid",
    "revolute",
    "sdf_losses",
    "write_caspr",
    "write_sdf",
]


def read_robot(path: str | Path, cable_set: str | None = None, *, repair: bool = False) -> Robot:
    """Read a robot from its files.

    Args:
        path: A model.sdf, .urdf, .osim, MJCF .xml, CASPR `<name>_bodies.xml`, or the folder that
            contains one of these files.
        cable_set: The cable set to activate, or None for the one that the file specifies.
        repair: Whether to repair known defects of published files.

    Returns:
        A robot without errors. `addin_sdfusion.robot.formats.read.read` also returns the warnings.

    Raises:
        RobotError: The robot in the files has errors.
        InputError: The files cannot be read.
        UnknownNameError: The cable set does not exist.
    """
    from .formats.read import read_robot as read  # Fusion's Python does not include lxml

    return read(path, cable_set, repair=repair)
