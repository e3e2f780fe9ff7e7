"""Stops, held coordinates and Coulomb friction in MJCF: constraints as hard as MuJoCo has them.

MuJoCo's constraints are springs with a damper, whose force it mixes with what would happen without
(https://mujoco.readthedocs.io/en/stable/modeling.html#solver-parameters). With the largest share,
0.9999, the shortest time constant of a step h that it takes, 2 h, and a damping ratio z, a stop
takes all of a velocity in one step, and gives back 1/(4 z²) of it at most.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from xml.etree import ElementTree

from ...finding import Finding, Subject
from ...finding_builders import warning
from ...model.robot import Robot
from ..xml_text import element, numbers

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


def add_constraints(robot: Robot, root: ElementTree.Element) -> None:
    """Add the options of the steps, the defaults of constraints, and what holds coordinates."""
    iterations = NO_SLIP if _rubbing(robot) else {}
    step = {"timestep": numbers([STEP]), "integrator": INTEGRATOR}
    element(root, "option", None, gravity=numbers(robot.gravity), **step, **iterations)
    defaults = element(root, "default")
    stops = {"solreflimit": STOP, "solimplimit": FULL}
    element(defaults, "joint", None, **stops, solreffriction=HARD, solimpfriction=FULL)
    element(defaults, "equality", solref=HARD, solimp=FULL)
    held = element(root, "equality")
    for c in robot.coordinates:
        if c.lower == c.upper:
            element(held, "joint", joint1=c.name, polycoef=numbers((c.lower, 0, 0, 0, 0)))


def constraint_losses(robot: Robot) -> Iterator[Finding]:
    """How far MuJoCo's constraints give way."""
    subject = Subject("robot", robot.name)
    if any(math.isfinite(limit) for c in robot.coordinates for limit in (c.lower, c.upper)):
        problem = (
            "MuJoCo's stops give way: a joint that meets one with v rad/s or m/s passes it by up "
            f"to v · {STEP:g} s, and comes back with up to 3 % of v; at rest it is 1e-7 past it"
        )
        yield warning(subject, "soft-stops", problem)
    if _rubbing(robot):
        problem = (
            "MuJoCo's Coulomb friction gives way: a joint that it holds creeps, by about "
            "1e-8 rad or m in a second"
        )
        yield warning(subject, "soft-friction", problem)


def _rubbing(robot: Robot) -> bool:
    return any(c.friction for c in robot.coordinates)
