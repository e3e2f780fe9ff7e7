"""Writer of muscles, motors, dampers and limit forces in OpenSim."""

from __future__ import annotations

import math
from xml.etree import ElementTree

from ....model.joint import Coordinate
from ....model.muscle import Muscle
from ....model.robot import Robot
from ....transforms.joint_chains import Names
from ...writing.xml_text import element
from .muscles import force_element
from .points import CoordinatePaths, add_points
from .wraps import WrapNames, add_wraps


def add_muscle(
    forces: ElementTree.Element, muscle: Muscle, names: WrapNames, coordinates: CoordinatePaths
) -> None:
    """Add a muscle in its OpenSim class, or as a PathActuator commanded by tension."""
    path = element(force_element(forces, muscle), "GeometryPath", name="path")
    add_points(path, muscle, coordinates)
    add_wraps(path, muscle, names)


def add_joint_forces(forces: ElementTree.Element, robot: Robot, names: Names) -> None:
    """Add the motors of joints, with controls in [N·m] or [N], and dampers and springs."""
    for c in robot.motors:
        node = element(forces, "CoordinateActuator", name=names.unique(f"{c.name}_motor"))
        for tag, bound in (("min_control", c.tau_min), ("max_control", c.tau_max)):
            if math.isfinite(bound):
                element(node, tag, bound)
        element(node, "coordinate", c.name)
        element(node, "optimal_force", 1.0)
    for c in robot.all_coordinates:
        if c.damping or c.stiffness:
            node = element(forces, "SpringGeneralizedForce", name=names.unique(f"{c.name}_damping"))
            element(node, "coordinate", c.name)
            element(node, "stiffness", c.stiffness)
            element(node, "rest_length", c.rest)
            element(node, "viscosity", c.damping)
    for c in robot.all_coordinates:
        if c.limit_force is not None:
            _add_limit_force(forces, c, names.unique(f"{c.name}_limit"))


def _add_limit_force(forces: ElementTree.Element, c: Coordinate, name: str) -> None:
    """Add a limit force; for rotations OpenSim uses degrees in all units."""
    force, degree = c.limit_force, math.pi / 180.0 if c.unit == "rad" else 1.0
    if force is None:
        return
    node = element(forces, "CoordinateLimitForce", name=name)
    element(node, "coordinate", c.name)
    element(node, "upper_limit", force.high / degree)
    element(node, "upper_stiffness", force.stiffness_high * degree)
    element(node, "lower_limit", force.low / degree)
    element(node, "lower_stiffness", force.stiffness_low * degree)
    element(node, "damping", force.damping * degree)
    element(node, "transition", force.transition / degree)
