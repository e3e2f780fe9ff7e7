"""Writer of joint limits, locks, friction and loops in MJCF, as stiff as MuJoCo allows.

Constraints in MuJoCo are springs with dampers. Their force is mixed with the unconstrained dynamics
(https://mujoco.readthedocs.io/en/stable/modeling.html#solver-parameters). We use the maximum
impedance 0.9999, the minimum time constant 2 h for a time step h, and a damping ratio z. A joint
limit then absorbs the whole velocity in one step and returns at most 1/(4 z²) of it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from xml.etree import ElementTree

from ...model.function import Function, Polynomial, taylor
from ...model.link_poses import unmoved_poses
from ...model.loop import LoopType
from ...model.pose import Pose
from ...model.robot import Robot
from ...model.rotations import apply
from ...transforms.joint_chains import Names
from ...transforms.loop_points import LoopPoint, loop_points
from ..writing.xml_text import element, numbers
from .write_bodies import coordinate_order, placement

STEP = 1e-3
"""Time step in [s], as in the plants; a joint can exceed a limit by its motion in one step."""
INTEGRATOR = "Euler"
"""Semi-implicit, with implicit joint damping, as in the plants."""
SOLREF_TWO_SIDED = numbers((2.0 * STEP, 1.0))
"""Time constant and damping ratio of two-sided constraints; longer steps increase the constant."""
SOLREF_LIMIT = numbers((2.0 * STEP, 3.0))
"""Time constant and damping ratio of one-sided constraints, which should not rebound."""
SOLIMP_MAX = numbers((0.9999, 0.9999, 1e-3, 0.5, 2.0))
"""Maximum impedance of a constraint in MuJoCo, for all violations."""
NO_SLIP = {"noslip_iterations": "30", "noslip_tolerance": "1e-12"}
"""Options that reduce the creep of friction; a residual of 1e-6 rad/s would remain otherwise."""
LOOPS: tuple[LoopType, ...] = ("fixed", "ball", "revolute", "universal")
"""Types of loop joints that MuJoCo's equalities can represent."""


def add_constraints(robot: Robot, root: ElementTree.Element) -> None:
    """Add the solver options, the defaults of constraints, and the equalities of coordinates."""
    iterations = NO_SLIP if has_friction(robot) else {}
    step = {"timestep": numbers([STEP]), "integrator": INTEGRATOR}
    element(root, "option", None, gravity=numbers(robot.gravity), **step, **iterations)
    defaults = element(root, "default")
    stops = {"solreflimit": SOLREF_LIMIT, "solimplimit": SOLIMP_MAX}
    element(
        defaults, "joint", None, **stops, solreffriction=SOLREF_TWO_SIDED, solimpfriction=SOLIMP_MAX
    )
    element(defaults, "equality", solref=SOLREF_TWO_SIDED, solimp=SOLIMP_MAX)
    equalities = element(root, "equality")
    order = coordinate_order(robot)
    refs = {motion_joint.name: motion_joint.ref for motion_joint in order}
    for motion_joint in order:
        c = motion_joint.coordinate
        if not motion_joint.is_home:
            powers = _coefficients(motion_joint.motion.function)
            _add_coupling(equalities, motion_joint.name, c.name, powers, refs)
        elif c.coupling and not c.locked:
            term = c.coupling[0]
            _add_coupling(equalities, c.name, term.coordinate, _coefficients(term.function), refs)
        elif c.locked or c.lower == c.upper:
            value = (c.initial if c.locked else c.lower) - motion_joint.ref
            element(equalities, "joint", joint1=c.name, polycoef=numbers((value, 0, 0, 0, 0)))


def is_supported(function: Function) -> bool:
    """Return whether MuJoCo can couple joints by this function."""
    return isinstance(function, Polynomial) and len(function.coefficients) <= 5


def _coefficients(function: Function) -> tuple[float, ...]:
    powers = function.coefficients if isinstance(function, Polynomial) else ()
    return (*powers, *(0.0,) * (5 - len(powers)))


def _add_coupling(
    equalities: ElementTree.Element,
    name: str,
    leader: str,
    powers: tuple[float, ...],
    refs: Mapping[str, float],
) -> None:
    """Add the equality q1 - ref1 = p(q2), with p written in powers of q2 - ref2."""
    shifted = taylor(powers, refs[leader]) if refs[leader] else powers
    values = (shifted[0] - refs[name], *shifted[1:])
    element(equalities, "joint", joint1=name, joint2=leader, polycoef=numbers(values))


def has_friction(robot: Robot) -> bool:
    """Return whether a coordinate of q has Coulomb friction."""
    return any(c.friction for c in robot.coordinates)


def add_loops(
    robot: Robot, root: ElementTree.Element, bodies: Mapping[str, ElementTree.Element], sites: Names
) -> None:
    """Add the equalities of all loop joints that MuJoCo supports, between new sites."""
    supported = [loop for loop in robot.loops if loop.type in LOOPS]
    equalities = element(root, "equality") if supported else root
    used = [*(j.name for j in robot.joints), *(loop.name for loop in robot.loops)]
    names = Names([*used, *(muscle.name for muscle in robot.muscles)])

    def add_sites(name: str, *ends: tuple[str, Pose]) -> dict[str, str]:
        words = {}
        for k, (link, T) in enumerate(ends, start=1):
            site = words[f"site{k}"] = sites.unique(f"{name}:{k}")
            element(bodies[link], "site", None, name=site, **placement(T))
        return words

    for loop in supported:
        if loop.type == "fixed":
            ends = (loop.parent, loop.T_parent_joint), (loop.child, loop.T_child_joint)
            element(equalities, "weld", None, name=loop.name, **add_sites(loop.name, *ends))
        for point in loop_points(loop, names):
            ends = (point.parent, Pose(point.in_parent)), (point.child, Pose(point.in_child))
            words = add_sites(point.name, *ends)
            if point.kind == "point":
                element(equalities, "connect", None, name=point.name, **words)
            else:
                _add_distance(robot, root, equalities, point, words)


def _add_distance(
    robot: Robot,
    root: ElementTree.Element,
    equalities: ElementTree.Element,
    point: LoopPoint,
    words: Mapping[str, str],
) -> None:
    """Add a tendon between two sites with a constant length, relative to that at qpos0."""
    name = {"name": point.name}
    tendon = element(element(root, "tendon"), "spatial", None, **name)
    for site in words.values():
        element(tendon, "site", site=site)
    poses = unmoved_poses(robot)
    first, second = (
        apply(poses[point.parent], point.in_parent),
        apply(poses[point.child], point.in_child),
    )
    change = point.distance - math.dist(first, second)
    element(
        equalities,
        "tendon",
        None,
        **name,
        tendon1=point.name,
        polycoef=numbers((change, 0, 0, 0, 0)),
    )
