"""Features that OpenSim models hold."""

from __future__ import annotations

import math
from collections.abc import Iterator

from ...checks.loops import rigid_bodies
from ...finding import Finding, Subject
from ...model.joint import Coordinate
from ...model.robot import WORLD, Robot
from .. import features
from ..capability import Capabilities, FeaturePlace, changed, kept, omitted, rejected
from ..features import (
    of_coordinates,
    of_cylinders,
    of_joints,
    of_muscles,
    of_robot,
    of_wraps,
    points_of_muscles,
)
from ..writing import wrap_ends
from ..writing.plain_paths import with_markers
from .writing.bodies import MIN_MASS
from .writing.functions import can_write_sum
from .writing.joints import has_three_rotations, is_chain, is_one_joint
from .writing.loops import SUPPORTED
from .writing.muscles import CLASSES, changed_parameters, has_other_bounds, ignored_damping
from .writing.names import renamed_objects
from .writing.points import changed_ranges, loses_motion, ranges_without_limits
from .writing.wraps import ENDLESS, approximated_wraps, shares_segments

PATH_FEATURES = ("conditions", "moves")
"""Path features that OpenSim supports."""


def osim_losses(robot: Robot) -> list[Finding]:
    """Return findings on everything that OpenSim cannot hold; errors prevent writing."""
    return OPENSIM.losses(with_markers(robot))


def _massless_links(robot: Robot) -> Iterator[FeaturePlace]:
    rigid = rigid_bodies(robot.joints)
    for link in robot.links:
        if link.inertia.mass < MIN_MASS and rigid[link.name] != WORLD:
            yield FeaturePlace(Subject("link", link.name))


def _other_names(robot: Robot) -> list[str]:
    """Return the names of joints that are not kept, because the joint becomes a chain."""
    return [name for name in features.joint_names(robot) if not is_one_joint(robot.joint(name))]


def _has_initial_outside_limits(c: Coordinate) -> bool:
    return c.lower < c.upper and not c.lower <= c.initial <= c.upper


def _has_equal_limits(c: Coordinate) -> bool:
    return c.lower == c.upper and not c.locked and math.isfinite(c.lower)


def _has_nonlinear_coupling(c: Coordinate) -> bool:
    return bool(c.coupling) and not can_write_sum([term.function for term in c.coupling])


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
            "OpenSim does not allow this name; written as {given!r}",
            renamed_objects,
        ),
        changed(
            features.CHAINS,
            features.CHAINS.code,
            features.CHAINS.message,
            of_joints(
                lambda joint: not is_one_joint(joint) and is_chain(joint) and features.order(joint)
            ),
            only="in orders other than three translations, then three rotations",
        ),
        rejected(
            features.DRIVEN_JOINTS,
            "driven-joint",
            "a joint in OpenSim has up to three translations, then up to three rotations, each "
            "with one function or a linear sum; in a chain of single joints each coordinate has "
            "one motion",
            of_joints(lambda joint: not is_chain(joint) and not is_one_joint(joint)),
            only="in chains",
        ),
        changed(
            features.DRIVEN_JOINTS,
            "coriolis-in-opensim",
            "three of its rotations follow one coordinate: OpenSim 4.6 omits a term of their "
            "acceleration, and so of the Coriolis forces",
            of_joints(has_three_rotations),
            only="three rotations by one coordinate",
        ),
        rejected(
            features.DRIVEN_JOINTS,
            "driven-joint",
            "OpenSim couples a coordinate by one function of one coordinate, or linearly to "
            "several",
            of_coordinates(_has_nonlinear_coupling),
            only="several functions that are not linear",
        ),
        rejected(
            features.DRIVEN_JOINTS,
            "driven-joint",
            "it depends on one coordinate by several functions; OpenSim supports only one",
            of_coordinates(_follows_one_twice),
            only="several functions of one coordinate",
        ),
        changed(
            features.LIMITS,
            "limits-not-clamped",
            "its initial value is outside its limits, which OpenSim then does not enforce",
            of_coordinates(_has_initial_outside_limits),
            only="with an initial value outside",
        ),
        changed(
            features.LIMITS,
            "written-locked",
            "its equal limits are written as a lock, which removes it from the robot's q",
            of_coordinates(_has_equal_limits),
            only="equal limits",
        ),
        changed(
            features.LIMIT_FORCES,
            "limit-inertia-left-out",
            "OpenSim has no soft limits; the inertia of its limit force is omitted",
            of_coordinates(lambda c: c.limit_force and c.limit_force.inertia),
            only="with an inertia",
        ),
        features.loops_except(SUPPORTED),
        omitted(features.ARMATURES),
        changed(
            "links without mass",
            "mass-increased",
            f"OpenSim requires positive masses; {MIN_MASS!r} kg is used",
            _massless_links,
        ),
        changed(
            features.LIMITS,
            "limits-are-ranges",
            "limits are only ranges in OpenSim and are not enforced in simulations",
            of_robot(features.has_limits),
        ),
        omitted(features.FRICTION),
        omitted(features.BOUNDS_WITHOUT_MOTOR),
        omitted(features.VELOCITY_LIMITS),
        omitted(features.BRANCHES),
        *features.TERMS_OMITTED,
        omitted(features.MUJOCO_WRAPS),
        changed(
            features.MOVING_POINTS,
            "point-range-changed",
            "OpenSim moves the points within the range {low:g} to {high:g} of {coordinate!r}, "
            "instead of {own_low:g} to {own_high:g}",
            changed_ranges,
            only="within a range that differs from the range of their coordinate",
        ),
        changed(
            features.MOVING_POINTS,
            "points-beyond-their-range",
            "beyond {low:g} to {high:g} of {coordinate!r} its points are fixed, but OpenSim "
            "computes moment arms as if they still moved",
            ranges_without_limits,
            only="by coordinates without limits",
        ),
        omitted(
            features.CONDITIONS,
            "point-smoothing-left-out",
            "OpenSim activates and deactivates points without smoothing; omitted at points "
            "{places}",
            points_of_muscles(lambda point: point.when is not None and point.when.smoothing),
            only="their smoothing",
        ),
        omitted(
            features.MOVING_POINTS,
            "point-motion-left-out",
            "OpenSim moves a point along x, y and z of its link, with one function each and "
            "without a condition; fixed there: {places}",
            points_of_muscles(loses_motion),
            only="along other axes, or active only at times",
        ),
        changed(
            "cylinders without ends",
            "cylinder-has-ends",
            f"cylinder {{surface!r}} ends in OpenSim: it is {ENDLESS!r} m long",
            of_cylinders(lambda length: length > ENDLESS),
        ),
        changed(
            features.WRAPS,
            "wrap-approximated",
            "OpenSim approximates paths over cylinders and ellipsoids, mostly to 1e-4 m and their "
            "moment arms to 1e-2 m{tapers}: {names}",
            approximated_wraps,
            only="over cylinders and ellipsoids",
        ),
        changed(
            features.WRAPS,
            "wrap-approximated",
            "OpenSim approximates paths over several surfaces in one segment",
            of_muscles(shares_segments),
            only="several in one segment",
        ),
        omitted(
            features.WRAPS,
            "wrap-left-out",
            "OpenSim does not support wrapping inside {surface!r}; this wrap is omitted",
            of_wraps(lambda wrap: wrap.inside),
            only="inside their surface",
        ),
        omitted(
            features.WRAPS,
            "turns-left-out",
            "OpenSim does not support full turns; {turns} around {surface!r} omitted",
            of_wraps(lambda wrap: wrap.turns and not wrap.inside),
            only="full turns",
        ),
        changed(
            features.WRAPS,
            "side-by-place",
            "in OpenSim a half-space of {surface!r} selects the side on which it passes; the "
            "half-space is chosen for the initial coordinates",
            of_wraps(lambda wrap: wrap.side and not (wrap.inside or wrap.turns)),
            only="with a chosen side",
        ),
        *wrap_ends.rows("OpenSim"),
        omitted(features.MESH_NAMES),
        omitted(
            features.COLLISIONS,
            "collisions-left-out",
            "OpenSim gets visual meshes only; collision meshes and shapes are omitted",
        ),
        features.laws_except(CLASSES),
        *features.NOT_IN_OTHER_SIMULATORS,
        omitted(
            "force limits of OpenSim muscles",
            "force-limits-left-out",
            "a {class} has no force limits; f_min and f_max are omitted",
            of_muscles(has_other_bounds),
        ),
        changed(
            features.MUSCLE_LAWS,
            "tension-law-changed",
            "a {class} is written with {values}, because OpenSim supports no other value",
            of_muscles(changed_parameters),
            only="parameters that OpenSim sets itself",
        ),
        changed(
            features.MUSCLE_LAWS,
            "fibre-damping-passed-over",
            "OpenSim moves the fibre of a {class} with an elastic tendon as if its fibre "
            "damping {damping:g} were 0; at rest the tension is the same",
            of_muscles(ignored_damping),
            only="hill_degroote2016 with damping and an elastic tendon",
        ),
        omitted(features.JOINT_NAMES, find=of_robot(_other_names), only="in chains"),
    ),
)
