"""Chains of joints made one joint again, as an SDF's plugin or a cardsflow.xml says."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

from ..finding import Subject
from ..finding_builders import unknown
from ..model.joint import Coordinate, Joint
from ..model.pose import IDENTITY
from ..model.rotations import compose, inverse
from .xml import TRUE, Node, shortened


@dataclass(frozen=True)
class _Word:
    """What the plugin says about a coordinate: its name, its mover, its place, its motor.

    Attributes:
        torques: Bounds of its motor; those of the joint element when None.
        initial: Its initial value; that of the joint element when None.
        spring: Its spring's stiffness and rest; those of the joint element when None.
    """

    name: str
    joint: str
    motion: int
    actuated: bool
    torques: tuple[float, ...] | None
    initial: float | None
    spring: tuple[float, ...] | None

    def applied(self, coordinate: Coordinate) -> Coordinate:
        """The coordinate of the joint element, as the plugin says it is."""
        initial = coordinate.initial if self.initial is None else self.initial
        named = replace(coordinate, name=self.name, actuated=self.actuated, initial=initial)
        if self.spring is not None:
            named = replace(named, stiffness=self.spring[0], rest=self.spring[1])
        if self.torques is None:
            return named
        return replace(named, tau_min=self.torques[0], tau_max=self.torques[1])


def join_chains(joints: Sequence[Joint], plugins: Sequence[Node]) -> tuple[list[Joint], set[str]]:
    """The joints with the coordinates that the plugin gives them.

    Returns:
        The joints, each in the place of its first part, and the links that are in none of them.
    """
    by_name = {joint.name: joint for joint in joints}
    places: dict[str, Joint] = {}
    used: set[str] = set()
    inner: set[str] = set()
    for node in [child for plugin in plugins for child in plugin.all("joint")]:
        node = replace(node, subject=Subject("joint", node.attribute("name")))
        parts = _parts(node, by_name, used)
        if parts:
            used.update(part.name for part in parts)
            places[parts[0].name] = _joined(node, parts)
            inner.update(part.child for part in parts[:-1])
    kept = [joint for joint in joints if joint.name not in used or joint.name in places]
    return [places.get(joint.name, joint) for joint in kept], inner


def _words(node: Node) -> list[_Word]:
    words = []
    for child in node.all("coordinate"):
        name = child.attribute("name")
        motion = int(child.number_attribute("motion"))
        actuated = child.attribute("actuated", "false") in TRUE
        torques = None
        if child.has("torques"):
            torques = child.numbers_attribute("torques", 2, infinite=True)
        initial = child.number_attribute("initial") if child.has("initial") else None
        spring = child.numbers_attribute("spring", 2) if child.has("spring") else None
        joint = child.attribute("joint")
        words.append(_Word(name, joint, motion, actuated, torques, initial, spring))
    return words


def _parts(node: Node, by_name: dict[str, Joint], used: set[str]) -> list[Joint]:
    """The joints that make up one, from the parent to the child; none if they do not."""
    words = sorted(_words(node), key=lambda word: word.motion)
    names = list(dict.fromkeys(word.joint for word in words))
    for name in names:
        if name not in by_name:
            node.error("unknown-joint", unknown("joint", name, list(by_name)))
            return []
    parts = [by_name[name] for name in names]
    moved_by = [part.name for part in parts for _ in part.motions]
    if not words or [(w.motion, w.joint) for w in words] != list(enumerate(moved_by)):
        node.error(
            "bad-chain", f"<joint> does not name each motion of {shortened(str(names))} once"
        )
        return []
    for first, second in pairwise(parts):
        between = compose(inverse(first.T_child_joint), second.T_parent_joint)
        if first.child != second.parent or between != IDENTITY:
            problem = f"joint {second.name!r} does not go on where joint {first.name!r} ends"
            node.error("bad-chain", problem)
            return []
    if used.intersection(names):
        node.error("bad-chain", f"{shortened(str(names))} are in another <joint> already")
        return []
    return parts


def _joined(node: Node, parts: Sequence[Joint]) -> Joint:
    words = _words(node)
    indices = {word.motion: index for index, word in enumerate(words)}
    motions = [motion for part in parts for motion in part.motions]
    driven = [part.coordinates[motion.coordinate] for part in parts for motion in part.motions]
    locations = node.notes.locations
    for word in words:
        axis = locations.get(
            Subject("coordinate", driven[word.motion].name), (node.file, node.line)
        )
        locations[Subject("coordinate", word.name)] = axis
    return Joint(
        node.subject.name,
        parts[0].parent,
        parts[-1].child,
        tuple(replace(motion, coordinate=indices[k]) for k, motion in enumerate(motions)),
        tuple(word.applied(driven[word.motion]) for word in words),
        parts[0].T_parent_joint,
        parts[-1].T_child_joint,
    )
