"""What OpenSim's models hold."""

from __future__ import annotations

import math
from collections.abc import Iterator

from ...finding import Finding, Subject
from ...model.joint import Coordinate
from ...model.robot import Robot
from .. import features
from ..capability import Capabilities, Found, changed, kept, left_out, refused
from ..features import (
    of_coordinates,
    of_joints,
    of_muscles,
    of_robot,
    of_wraps,
    points_of_muscles,
)
from ..writing import wrap_ends
from ..writing.plain_paths import with_markers
from .writing.bodies import MIN_MASS, standing_links
from .writing.functions import is_written
from .writing.joints import is_chain, is_one_joint, turns_thrice
from .writing.loops import CONSTRAINTS
from .writing.muscles import CLASSES, changed_parameters, has_other_bounds, passed_over_damping
from .writing.names import renamed
from .writing.points import changed_ranges, is_fixed_there, ranges_without_limits
from .writing.wraps import ENDLESS, approximated, shares_segments

HELD = ("conditions", "moves")
"""What OpenSim's paths can depend on."""


def osim_losses(robot: Robot) -> list[Finding]:
    """What OpenSim cannot hold of a valid robot; errors if it is not written."""
    return OPENSIM.losses(with_markers(robot))


def _light_links(robot: Robot) -> Iterator[Found]:
    standing = standing_links(robot)
    for link in robot.links:
        if link.inertia.mass < MIN_MASS and link.name not in standing:
            yield Found(Subject("link", link.name))


def _other_names(robot: Robot) -> list[str]:
    """Return the names of joints that become others'."""
    return [
        joint.name
        for joint in robot.joints
        if joint.name not in [c.name for c in joint.coordinates] and not is_one_joint(joint)
    ]


def _long_cylinders(robot: Robot) -> Iterator[Found]:
    for surface in robot.wrap_surfaces:
        if surface.shape == "cylinder" and surface.length > ENDLESS:
            yield Found(Subject("robot", robot.name), {"surface": surface.name})


def _starts_outside(c: Coordinate) -> bool:
    return c.lower < c.upper and not c.lower <= c.initial <= c.upper


def _has_equal_limits(c: Coordinate) -> bool:
    return c.lower == c.upper and not c.locked and math.isfinite(c.lower)


def _follows_curves(c: Coordinate) -> bool:
    return bool(c.coupling) and not is_written([term.function for term in c.coupling])


def _follows_one_twice(c: Coordinate) -> bool:
    return len({term.coordinate for term in c.coupling}) < len(c.coupling)


OPENSIM = Capabilities(
    "OpenSim",
    (
        kept(features.LINKS, features.FIXED_JOINTS, features.LINK_FRAMES, features.GRAVITIES),
        kept(features.MESHES, features.INITIAL_VALUES, features.DAMPING, features.SPRINGS),
        kept(features.LIMIT_FORCES, features.MOTORS, features.MOTOR_BOUNDS, features.MUSCLES),
        kept(features.CONDITIONS, features.MOVING_POINTS, features.WRAPS, features.WRAP_SURFACES),
        kept(features.ELLIPSOIDS, features.OPENSIM_WRAPS, features.TASK_FRAMES),
        changed(
            "names with spaces, / \\ * +",
            "renamed",
            "OpenSim does not allow the name; written as {given!r}",
            renamed,
        ),
        changed(
            features.CHAINS,
            features.CHAINS.code,
            features.CHAINS.message,
            of_joints(
                lambda joint: not is_one_joint(joint) and is_chain(joint) and features.order(joint)
            ),
            only="in other orders than three translations, then three rotations",
        ),
        refused(
            features.DRIVEN_JOINTS,
            "driven-joint",
            "OpenSim has joints of three translations, then three rotations at most, each by one "
            "function, or linear ones; in a chain of single ones each coordinate has one motion",
            of_joints(lambda joint: not is_chain(joint) and not is_one_joint(joint)),
            only="in chains",
        ),
        changed(
            features.DRIVEN_JOINTS,
            "coriolis-in-opensim",
            "three of its rotations follow one coordinate: a term of their acceleration is missing "
            "in OpenSim 4.6, and so in its Coriolis forces",
            of_joints(turns_thrice),
            only="three rotations by one coordinate",
        ),
        refused(
            features.DRIVEN_JOINTS,
            "driven-joint",
            "OpenSim couples a coordinate to one by a function, or to several linearly",
            of_coordinates(_follows_curves),
            only="several curves",
        ),
        refused(
            features.DRIVEN_JOINTS,
            "driven-joint",
            "it follows one coordinate by several functions; OpenSim has one",
            of_coordinates(_follows_one_twice),
            only="several functions of one coordinate",
        ),
        changed(
            features.LIMITS,
            "limits-not-clamped",
            "it starts outside of its limits, which clamp nothing in OpenSim then",
            of_coordinates(_starts_outside),
            only="with the start outside",
        ),
        changed(
            features.LIMITS,
            "written-locked",
            "its equal limits are written as a lock, which removes it from the robot's q",
            of_coordinates(_has_equal_limits),
            only="equal ones",
        ),
        features.loops_but(CONSTRAINTS),
        left_out(features.ARMATURES),
        changed(
            "links without mass",
            "mass-increased",
            f"OpenSim needs masses; it gets {MIN_MASS!r} kg",
            _light_links,
        ),
        changed(
            features.LIMITS,
            "limits-are-ranges",
            "limits are ranges in OpenSim and stop nothing in a simulation",
            of_robot(features.has_limits),
        ),
        left_out(features.FRICTION),
        left_out(features.BOUNDS_WITHOUT_MOTOR),
        left_out(features.BRANCHES),
        *features.TERMS_LEFT_OUT,
        left_out(features.MUJOCO_WRAPS),
        changed(
            features.MOVING_POINTS,
            "point-range-changed",
            "OpenSim moves its points within the range of {coordinate!r}, {low:g} to {high:g}, not "
            "{own_low:g} to {own_high:g}",
            changed_ranges,
            only="within another range than their coordinate",
        ),
        changed(
            features.MOVING_POINTS,
            "points-beyond-their-range",
            "where {coordinate!r} is beyond {low:g} to {high:g} its points stop, but "
            "OpenSim computes moment arms as if they still moved",
            ranges_without_limits,
            only="by coordinates without limits",
        ),
        left_out(
            features.CONDITIONS,
            "point-smoothing-left-out",
            "OpenSim switches its points without smoothing; smoothing omitted: {places}",
            points_of_muscles(lambda point: point.when is not None and point.when.smoothing),
            only="their smoothing",
        ),
        left_out(
            features.MOVING_POINTS,
            "point-motion-left-out",
            "OpenSim moves a point along x, y and z of its link, by a function each, and at all "
            "times; fixed there: {places}",
            points_of_muscles(is_fixed_there),
            only="along other axes, or in use at times",
        ),
        changed(
            "cylinders without ends",
            "cylinder-has-ends",
            f"cylinder {{surface!r}} ends in OpenSim: it is {ENDLESS!r} m long",
            _long_cylinders,
        ),
        changed(
            features.WRAPS,
            "wrap-approximated",
            "OpenSim approximates paths over cylinders and ellipsoids, mostly to 1e-4 m and their "
            "moment arms to 1e-2 m{tapers}: {names}",
            approximated,
            only="over cylinders and ellipsoids",
        ),
        changed(
            features.WRAPS,
            "wrap-approximated",
            "OpenSim approximates paths over several surfaces in one segment",
            of_muscles(shares_segments),
            only="several in one segment",
        ),
        left_out(
            features.WRAPS,
            "wrap-left-out",
            "OpenSim has no path inside {surface!r}; this wrap is left out",
            of_wraps(lambda wrap: wrap.inside),
            only="inside of their surface",
        ),
        left_out(
            features.WRAPS,
            "turns-left-out",
            "OpenSim has no whole turns; {turns} about {surface!r} left out",
            of_wraps(lambda wrap: wrap.turns and not wrap.inside),
            only="their whole turns",
        ),
        changed(
            features.WRAPS,
            "side-by-place",
            "a half of {surface!r} marks the side on which it passes; it is chosen for the initial "
            "coordinates",
            of_wraps(lambda wrap: wrap.side and not (wrap.inside or wrap.turns)),
            only="with a chosen side",
        ),
        *wrap_ends.rows("OpenSim"),
        left_out(features.MESH_NAMES),
        left_out(
            features.COLLISIONS,
            "collisions-left-out",
            "OpenSim gets the meshes to be seen only; what collides is left out",
        ),
        features.laws_but(CLASSES),
        *features.NOT_IN_OTHER_SIMULATORS,
        left_out(
            "bounds of the force of OpenSim's own muscles",
            "force-limits-left-out",
            "a {class} has no bounds of its force; f_min and f_max are left out",
            of_muscles(has_other_bounds),
        ),
        changed(
            features.MUSCLE_LAWS,
            "tension-law-changed",
            "a {class} is written with {values}: it takes no other",
            of_muscles(changed_parameters),
            only="parameters that OpenSim sets itself",
        ),
        changed(
            features.MUSCLE_LAWS,
            "fibre-damping-passed-over",
            "OpenSim moves the fibre of a {class} with an elastic tendon as if its fibre_damping "
            "{damping:g} were 0; at rest the tension is the same",
            of_muscles(passed_over_damping),
            only="hill_degroote2016 with damping and an elastic tendon",
        ),
        left_out(features.JOINT_NAMES, find=of_robot(_other_names), only="in chains"),
    ),
)
