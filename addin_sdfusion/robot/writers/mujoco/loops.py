"""Loop joints in MJCF: equalities of two sites, as hard as MuJoCo has them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from xml.etree import ElementTree

from ...finding import Finding, Subject
from ...finding_builders import warning
from ...formats.writing.xml_text import element
from ...model.robot import Robot
from ...transforms.joint_chains import Names
from .bodies import placement

EQUALITIES = {"ball": "connect", "fixed": "weld"}
"""MuJoCo's equality of each type of loop joint that it has."""


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


def loop_losses(robot: Robot) -> Iterator[Finding]:
    """How far MuJoCo's loops give way."""
    if any(loop.type in EQUALITIES for loop in robot.loops):
        problem = "MuJoCo's loops give way: its equalities of bodies are springs with a damper"
        yield warning(Subject("robot", robot.name), "soft-loops", problem)
