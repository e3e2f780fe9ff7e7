"""Where the links, joints and frames of an SDF model are."""

from __future__ import annotations

from dataclasses import dataclass

from ..finding import Subject
from ..placement import IDENTITY, Pose
from ..pose import compose
from ..sdf import MODEL_FRAME
from .xml import Node

Key = tuple[str, str]
"""Kind (`link`, `joint`, `frame` or `model`) and name."""

MODEL: Key = ("model", MODEL_FRAME)


@dataclass(frozen=True)
class Placement:
    """A pose and the frame that it is relative to."""

    pose: Pose
    relative_to: Key


class Frames:
    """The placements of everything in a model.

    Args:
        model: The `<model>` element; what is wrong with its poses is noted there.
    """

    def __init__(self, model: Node) -> None:
        self._nodes: dict[Key, Node] = {}
        for kind in ("frame", "joint", "link"):
            for node in model.all(kind):
                name = node.attribute("name", "")
                self._nodes.setdefault((kind, name), node.about(Subject(kind, name)))
        self.placements = {key: self._placement(key, node) for key, node in self._nodes.items()}
        self._in_model: dict[Key, Pose] = {MODEL: IDENTITY}

    def in_model(self, key: Key) -> Pose:
        """The pose T_model_x of a link, joint or frame; identity if there is none."""
        path: dict[Key, None] = {}
        start = key
        while key not in self._in_model:
            if key not in self.placements or key in path:
                self._in_model[key] = self._loop(key) if key in path else IDENTITY
                break
            path[key] = None
            key = self.placements[key].relative_to
        for inner in reversed(path):
            placement = self.placements[inner]
            outer = self._in_model[placement.relative_to]
            self._in_model[inner] = compose(outer, placement.pose)
        return self._in_model[start]

    def named(self, name: str) -> Key | None:
        """What a `relative_to` of that name means; None if there is nothing of the name."""
        if name in ("", MODEL_FRAME):
            return MODEL
        keys: list[Key] = [(kind, name) for kind in ("link", "joint", "frame")]
        return next((key for key in keys if key in self._nodes), None)

    def _loop(self, key: Key) -> Pose:
        self._nodes[key].error("pose-loop", "its pose is relative to itself, by way of others")
        return IDENTITY

    def _placement(self, key: Key, node: Node) -> Placement:
        pose = node.optional("pose")
        default = self._default(key[0], node)
        if pose is None:
            return Placement(IDENTITY, default)
        if pose.attribute("frame", "") or pose.attribute("degrees", "false") not in ("false", "0"):
            pose.error("unsupported-pose", "<pose> with frame or degrees is not supported")
        reference = self._reference(pose, "relative_to") or default
        return Placement(read_pose(pose), reference)

    def _default(self, kind: str, node: Node) -> Key:
        """What a pose is relative to unless it says otherwise."""
        if kind == "joint":
            child = node.optional("child")
            return MODEL if child is None else ("link", child.text)
        return self._reference(node, "attached_to") or MODEL

    def _reference(self, node: Node, attribute: str) -> Key | None:
        name = node.attribute(attribute, "")
        if not name:
            return None
        key = self.named(name)
        if key is None:
            node.error(
                "unknown-frame", f"{attribute} {name!r}: no link, joint or frame of the name"
            )
        return key


def read_pose(node: Node) -> Pose:
    """The pose in an element's text; identity if it is empty."""
    if not node.text:
        return IDENTITY
    x, y, z, roll, pitch, yaw = node.numbers(6)
    return Pose((x, y, z), (roll, pitch, yaw))
