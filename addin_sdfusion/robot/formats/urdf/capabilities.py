"""Features that URDF holds, together with the cardsflow.xml next to it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

from ...finding import Subject
from ...model.function import ITSELF, Function, Polynomial
from ...model.joint import Coordinate
from ...model.pose import IDENTITY
from ...model.robot import Robot
from ...transforms.joint_chains import SingleJoint, single_joints
from .. import features
from ..capability import (
    Capabilities,
    Feature,
    FeaturePlace,
    Finder,
    changed,
    changed_together,
    kept,
    rejected,
)
from ..features import of_coordinates, of_robot
from ..sdf.write_joints import has_one_effort

NO_LIMIT = 1e16
"""Value that represents no limit, in [rad], [m], [N·m], [N], [rad/s] or [m/s]."""


def leader_of(single: SingleJoint) -> tuple[str, Function | None]:
    """Return the joint that a single joint follows, and the function; empty and None otherwise."""
    c, motion = single.coordinate, single.motion
    if c is None or motion is None:
        return "", None
    if single.name != c.name:
        return c.name, motion.function
    if len(c.coupling) == 1 and not c.locked:
        return c.coupling[0].coordinate, c.coupling[0].function
    return "", None


def _has_one_limit(c: Coordinate) -> bool:
    return c.is_free and math.isfinite(c.lower) != math.isfinite(c.upper)


def _of_single_joints(has: Callable[[SingleJoint, Coordinate], bool]) -> Finder:
    """Return a finder of coordinates of single joints; `{joint}` is the joint."""

    def find(robot: Robot) -> Iterator[FeaturePlace]:
        for single in single_joints(robot, keep_functions=True):
            c = single.coordinate
            if c is not None and single.motion is not None and has(single, c):
                yield FeaturePlace(Subject("coordinate", c.name), {"joint": single.name})

    return find


def _has_other_motion(single: SingleJoint, c: Coordinate) -> bool:
    motion = single.motion
    return single.name == c.name and motion is not None and motion.function != ITSELF


def _follows_several(single: SingleJoint, c: Coordinate) -> bool:
    return single.name == c.name and len(c.coupling) > 1 and not c.locked


def _follows_nonlinear_function(single: SingleJoint, c: Coordinate) -> bool:
    function = leader_of(single)[1]
    is_line = isinstance(function, Polynomial) and len(function.coefficients) <= 2
    return function is not None and not is_line


def _moved_frames(robot: Robot) -> Iterator[FeaturePlace]:
    for joint in robot.joints:
        if joint.T_child_joint != IDENTITY:
            yield FeaturePlace(Subject("link", joint.child), {"joint": joint.name})


def _renamed_joints(robot: Robot) -> Iterator[FeaturePlace]:
    name_of = {single.child: single.name for single in single_joints(robot)}
    for joint in robot.joints:
        if joint.type == "fixed" and name_of[joint.child] != joint.name:
            yield FeaturePlace(Subject("joint", joint.name), {"name": name_of[joint.child]})


IN_CARDSFLOW_XML = (
    features.GRAVITIES,
    features.MUSCLES,
    features.WRAP_SURFACES,
    features.TASK_FRAMES,
    features.LINK_ENDS,
    features.LOOPS,
    features.DRIVEN_JOINTS,
    features.SPRINGS,
    features.ARMATURES,
    features.LIMIT_FORCES,
    features.INITIAL_VALUES,
    Feature("motor limits", of_coordinates(lambda c: c.is_free and not has_one_effort(c))),
)
"""Features stored in the cardsflow.xml, which other programs do not read."""

URDF = Capabilities(
    "URDF",
    (
        kept(features.LINKS, features.MESHES, features.MESH_NAMES, features.COLLISIONS),
        kept(features.FIXED_JOINTS, features.JOINT_NAMES, features.LIMITS, features.DAMPING),
        kept(features.FRICTION, features.MOTORS, features.BOUNDS_WITHOUT_MOTOR),
        kept(features.VELOCITY_LIMITS),
        kept(
            *(
                feature
                for feature in features.MUSCLE_AND_TASK_FEATURES
                if feature not in IN_CARDSFLOW_XML
            )
        ),
        changed(
            features.DRIVEN_JOINTS,
            "motion-for-coordinate",
            "other programs use the motion itself as the coordinate, with a different value",
            _of_single_joints(_has_other_motion),
        ),
        changed(
            features.DRIVEN_JOINTS,
            "coupling-left-out",
            "URDF's mimic supports only one leading joint; in other programs it moves freely",
            _of_single_joints(_follows_several),
        ),
        changed(
            features.DRIVEN_JOINTS,
            "mimic-is-a-line",
            "URDF's mimic is linear: in other programs joint {joint!r} follows the tangent of the "
            "function at the initial values",
            _of_single_joints(_follows_nonlinear_function),
        ),
        changed(
            features.DRIVEN_JOINTS,
            "lock-as-limits",
            "URDF cannot lock joints; in other programs these joints have equal limits: {names}",
            of_robot(lambda robot: [c.name for c in robot.all_coordinates if c.locked]),
        ),
        changed(features.CHAINS, features.CHAINS.code, features.CHAINS.message),
        changed_together(
            IN_CARDSFLOW_XML,
            "held-beside-urdf",
            "URDF has no {feature}; they are written to the cardsflow.xml next to it, which only "
            "CARDSFlow reads",
        ),
        changed(
            features.LINK_FRAMES,
            "link-frame-moved",
            "in URDF the link frame is the frame of joint {joint!r}",
            _moved_frames,
        ),
        changed(
            features.LIMITS,
            "one-sided-limit",
            f"URDF has either both limits or none; the missing limit is written as {NO_LIMIT!r}",
            of_coordinates(_has_one_limit),
            only="on one side",
        ),
        changed(
            "fixed joints with the name of a coordinate",
            "renamed",
            "a coordinate has the same name; written as {name!r}",
            _renamed_joints,
        ),
    ),
)

URDF_WITHOUT_EXTRAS = Capabilities("The description, URDF,", (rejected(features.DRIVEN_JOINTS),))
"""Features that a URDF without a cardsflow.xml must not have, such as a ROS description."""
