"""Merging of joint chains into joints with several motions, from an SDF plugin or cardsflow.xml."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields, replace
from itertools import pairwise
from typing import Any

from ...finding import Subject
from ...finding_builders import unknown
from ...model.joint import Coordinate, Joint, LimitForce, Motion, Term
from ...model.pose import IDENTITY
from ...model.rotations import compose, inverse
from .functions import read_function
from .xml import TRUE, Node, short_repr


@dataclass(frozen=True)
class _PluginCoordinate:
    """Coordinate as the plugin defines it.

    Attributes:
        joint: Joint element of the motion.
        motion: Index of the motion in the merged joint.
        actuated: Whether the coordinate has a motor.
        torques: Force limits of the motor; None to use the limits of the joint element.
        initial: Initial value; None to use the value of the joint element.
        others: Fields that a joint element cannot hold.
    """

    name: str
    joint: str
    motion: int
    actuated: bool
    torques: tuple[float, ...] | None
    initial: float | None
    others: dict[str, Any]

    def apply_to(self, coordinate: Coordinate) -> Coordinate:
        """Return the coordinate of the joint element, updated with the data of the plugin."""
        initial = coordinate.initial if self.initial is None else self.initial
        named = replace(
            coordinate, name=self.name, actuated=self.actuated, initial=initial, **self.others
        )
        if self.torques is None:
            return named
        return replace(named, tau_min=self.torques[0], tau_max=self.torques[1])


def join_chains(joints: Sequence[Joint], plugins: Sequence[Node]) -> tuple[list[Joint], set[str]]:
    """Return the joints, with chains merged as the plugin defines them.

    Returns:
        The joints, each at the position of its first part, and the names of the links that are
        inside merged joints.
    """
    by_name = {joint.name: joint for joint in joints}
    places: dict[str, Joint] = {}
    used: set[str] = set()
    inner: set[str] = set()
    for node in [child for plugin in plugins for child in plugin.all("joint")]:
        node = replace(node, subject=Subject("joint", node.attribute("name")))
        chain = _chain_joints(node, by_name, used)
        if chain:
            used.update(joint.name for joint in chain)
            places[chain[0].name] = _merge_joints(node, chain)
            inner.update(joint.child for joint in chain[:-1])
    remaining = [joint for joint in joints if joint.name not in used or joint.name in places]
    return [places.get(joint.name, joint) for joint in remaining], inner


def _plugin_coordinates(node: Node) -> list[_PluginCoordinate]:
    words = []
    for child in node.all("coordinate"):
        name = child.attribute("name")
        motion = int(child.number_attribute("motion"))
        actuated = child.attribute("actuated", "false") in TRUE
        torques = None
        if child.has("torques"):
            torques = child.numbers_attribute("torques", 2, infinite=True)
        initial = child.number_attribute("initial") if child.has("initial") else None
        others = _others(child.with_subject(Subject("coordinate", name)))
        joint = child.attribute("joint")
        words.append(_PluginCoordinate(name, joint, motion, actuated, torques, initial, others))
    return words


def _others(node: Node) -> dict[str, Any]:
    """Return the fields of a coordinate that have no SDF element."""
    words: dict[str, Any] = {"armature": node.number_attribute("armature", 0.0)}
    if node.has("spring"):
        words["stiffness"], words["rest"] = node.numbers_attribute("spring", 2)
    words["locked"] = node.attribute("locked", "false") in TRUE
    unit = node.attribute("unit", "")
    if unit in ("rad", "m"):
        words["unit"] = unit
    elif unit:
        node.error("bad-unit", f"unit {short_repr(unit)} must be rad or m")
    terms = (Term(term.attribute("coordinate"), read_function(term)) for term in node.all("term"))
    words["coupling"] = tuple(terms)
    force = node.optional("limit_force")
    if force is not None:
        names, defaults = (field.name for field in fields(LimitForce)), {"inertia": 0.0}
        given = {name: force.number_attribute(name, defaults.get(name)) for name in names}
        words["limit_force"] = LimitForce(**given)
    return words


def _chain_joints(node: Node, by_name: dict[str, Joint], used: set[str]) -> list[Joint]:
    """Return the joints of a chain, from parent to child, or an empty list on errors."""
    words, driven = (
        sorted(_plugin_coordinates(node), key=lambda word: word.motion),
        node.all("motion"),
    )
    movers = [child.attribute("joint") for child in driven] or [word.joint for word in words]
    names = list(dict.fromkeys(movers))
    for name in names:
        if name not in by_name:
            node.error("unknown-joint", unknown("joint", name, list(by_name)))
            return []
    chain = [by_name[name] for name in names]
    moved_by = [joint.name for joint in chain for _ in joint.motions]
    actual = list(enumerate(moved_by))
    named = [(word.motion, word.joint) for word in words]
    if (
        movers != moved_by
        or not movers
        or not (set(named) <= set(actual) if driven else named == actual)
    ):
        node.error(
            "bad-chain", f"<joint> must name each motion of {short_repr(str(names))} exactly once"
        )
        return []
    for first, second in pairwise(chain):
        between = compose(inverse(first.T_child_joint), second.T_parent_joint)
        if first.child != second.parent or between != IDENTITY:
            problem = f"joint {second.name!r} does not start where joint {first.name!r} ends"
            node.error("bad-chain", problem)
            return []
    if used.intersection(names):
        node.error("bad-chain", f"{short_repr(str(names))} already belong to another <joint>")
        return []
    return chain


def _merge_joints(node: Node, chain: Sequence[Joint]) -> Joint:
    words = _plugin_coordinates(node)
    motions = [motion for joint in chain for motion in joint.motions]
    driven = [joint.coordinates[motion.coordinate] for joint in chain for motion in joint.motions]
    locations = node.notes.locations
    for word in words:
        axis = locations.get(
            Subject("coordinate", driven[word.motion].name), (node.file, node.line)
        )
        locations[Subject("coordinate", word.name)] = axis
    return Joint(
        node.subject.name,
        chain[0].parent,
        chain[-1].child,
        tuple(_drive_motions(node, motions, words)),
        tuple(word.apply_to(driven[word.motion]) for word in words),
        chain[0].T_parent_joint,
        chain[-1].T_child_joint,
    )


def _drive_motions(
    node: Node, motions: Sequence[Motion], words: Sequence[_PluginCoordinate]
) -> Iterator[Motion]:
    """Yield the motions with the coordinates and functions that drive them."""
    nodes = node.all("motion")
    indices = {word.motion: index for index, word in enumerate(words)}
    named = {word.name: index for index, word in enumerate(words)}
    for k, motion in enumerate(motions):
        if not nodes:
            yield replace(motion, coordinate=indices[k])
            continue
        function, name = read_function(nodes[k]), nodes[k].attribute("coordinate", "")
        if nodes[k].has("coordinate") and name not in named:
            nodes[k].error("unknown-coordinate", unknown("coordinate", name, list(named)))
        yield replace(motion, coordinate=named.get(name, 0), function=function)
