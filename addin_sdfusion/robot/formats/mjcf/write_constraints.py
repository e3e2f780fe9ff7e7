"""Stops, holds, friction and loops in MJCF: constraints as hard as MuJoCo has them.

MuJoCo's constraints are springs with a damper, whose force it mixes with what would happen without
(https://mujoco.readthedocs.io/en/stable/modeling.html#solver-parameters). With the largest share,
0.9999, the shortest time constant of a step h that it takes, 2 h, and a damping ratio z, a stop
takes all of a velocity in one step, and gives back 1/(4 z²) of it at most.
"""

from __future__ import annotations

from collections.abc import Mapping
from xml.etree import ElementTree

from ...model.function import Function, Polynomial, taylor
from ...model.robot import Robot
from ...transforms.joint_chains import Names
from ..writing.xml_text import element, numbers
from .write_bodies import coordinate_order, placement

STEP = 1e-3
"""In [s]: that of this project's plants. A joint passes a stop by what it moves in one."""
INTEGRATOR = "Euler"
"""Semi-implicit, with implicit joint damping, as this project's plants step."""
HARD = numbers((2.0 * STEP, 1.0))
"""Time constant and damping ratio of what holds from both sides; longer steps make it longer."""
STOP = numbers((2.0 * STEP, 3.0))
"""The same of what pushes from one side and is not to throw back."""
FULL = numbers((0.9999, 0.9999, 1e-3, 0.5, 2.0))
"""The share of a constraint, at the violation 0 and beyond: MuJoCo's largest."""
NO_SLIP = {"noslip_iterations": "30", "noslip_tolerance": "1e-12"}
"""What takes from friction most of its softness: MuJoCo's own rest of it is 1e-6 rad/s."""
EQUALITIES = {"ball": "connect", "fixed": "weld"}
"""MuJoCo's equality of each type of loop joint that it has."""


def add_constraints(robot: Robot, root: ElementTree.Element) -> None:
    """Add the options of the steps, the defaults of constraints, and what holds coordinates."""
    iterations = NO_SLIP if has_friction(robot) else {}
    step = {"timestep": numbers([STEP]), "integrator": INTEGRATOR}
    element(root, "option", None, gravity=numbers(robot.gravity), **step, **iterations)
    defaults = element(root, "default")
    stops = {"solreflimit": STOP, "solimplimit": FULL}
    element(defaults, "joint", None, **stops, solreffriction=HARD, solimpfriction=FULL)
    element(defaults, "equality", solref=HARD, solimp=FULL)
    held = element(root, "equality")
    order = coordinate_order(robot)
    refs = {mover.name: mover.ref for mover in order}
    for mover in order:
        c = mover.coordinate
        if not mover.is_home:
            _follow(held, mover.name, c.name, _coefficients(mover.motion.function), refs)
        elif c.coupling and not c.locked:
            term = c.coupling[0]
            _follow(held, c.name, term.coordinate, _coefficients(term.function), refs)
        elif c.locked or c.lower == c.upper:
            value = (c.initial if c.locked else c.lower) - mover.ref
            element(held, "joint", joint1=c.name, polycoef=numbers((value, 0, 0, 0, 0)))


def is_held(function: Function) -> bool:
    """Return whether MuJoCo couples a joint to another by such a function."""
    return isinstance(function, Polynomial) and len(function.coefficients) <= 5


def _coefficients(function: Function) -> tuple[float, ...]:
    given = function.coefficients if isinstance(function, Polynomial) else ()
    return (*given, *(0.0,) * (5 - len(given)))


def _follow(
    held: ElementTree.Element,
    name: str,
    leader: str,
    powers: tuple[float, ...],
    refs: Mapping[str, float],
) -> None:
    """q1 - ref1 = the polynomial of q2 in powers of q2 - ref2."""
    shifted = taylor(powers, refs[leader]) if refs[leader] else powers
    values = (shifted[0] - refs[name], *shifted[1:])
    element(held, "joint", joint1=name, joint2=leader, polycoef=numbers(values))


def has_friction(robot: Robot) -> bool:
    """Return whether a coordinate of q has Coulomb friction."""
    return any(c.friction for c in robot.coordinates)


def add_loops(
    robot: Robot, root: ElementTree.Element, bodies: Mapping[str, ElementTree.Element], sites: Names
) -> None:
    """Add an equality for each loop joint that MuJoCo has, between two sites of its own.

    Args:
        robot: The robot.
        root: Where to.
        bodies: The body of each link.
        sites: The names of sites.
    """
    held = [loop for loop in robot.loops if loop.type in EQUALITIES]
    equalities = element(root, "equality") if held else root
    for loop in held:
        ends = (loop.parent, loop.T_parent_joint), (loop.child, loop.T_child_joint)
        names = [sites.give(f"{loop.name}:{k}") for k in (1, 2)]
        for name, (link, T) in zip(names, ends, strict=True):
            element(bodies[link], "site", None, name=name, **placement(T))
        words = dict(zip(("site1", "site2"), names, strict=True))
        element(equalities, EQUALITIES[loop.type], None, name=loop.name, **words)
