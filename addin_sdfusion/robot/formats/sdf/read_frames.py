"""Poses of links, joints and frames in an SDF model."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ...finding import Subject
from ...model.pose import IDENTITY, Pose, Vector3
from ...model.rotations import compose, inverse, quaternion_rotation, rpy
from ..reading.xml import TRUE, Node, short_repr
from .names import MODEL_FRAME

Key = tuple[str, str]
"""Kind (`link`, `joint`, `frame` or `model`) and name."""

MODEL: Key = ("model", MODEL_FRAME)


@dataclass(frozen=True)
class Placement:
    """Pose and the frame that it is relative to."""

    pose: Pose
    relative_to: Key


class Frames:
    """Placements of all links, joints and frames of a model."""

    def __init__(self, model: Node) -> None:
        self._nodes: dict[Key, Node] = {}
        self._inside: dict[Key, Key] = {}
        for kind in ("frame", "joint", "link"):
            for node in model.all(kind):
                self._add(kind, node)
                for frame in node.all("frame"):  # before SDF 1.7 links and joints can have frames
                    self._inside[self._add("frame", frame)] = (kind, node.attribute("name", ""))
        self._report_shared_names()
        self.placements = {key: self._placement(key, node) for key, node in self._nodes.items()}
        self._in_model: dict[Key, Pose] = {MODEL: IDENTITY}
        self._links: dict[str, str] = {}

    def in_model(self, key: Key) -> Pose:
        """Return the pose T_model_x of a link, joint or frame; the identity if not found."""
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

    def in_link(self, node: Node, link: str) -> Pose:
        """Return the pose of an element of a link, such as its inertial or a visual."""
        pose = node.optional("pose")
        if pose is None:
            return IDENTITY
        frame = self._reference(pose, "relative_to") or self._reference(pose, "frame")
        if frame is None or frame == ("link", link):
            return read_pose(pose)
        T_model_link = self.in_model(("link", link))
        return compose(inverse(T_model_link), compose(self.in_model(frame), read_pose(pose)))

    def named(self, name: str) -> Key | None:
        """Return the object that a `relative_to` name refers to, or None if it does not exist."""
        if name in ("", MODEL_FRAME):
            return MODEL
        keys: list[Key] = [(kind, name) for kind in ("link", "joint", "frame")]
        return next((key for key in keys if key in self._nodes), None)

    def link_of(self, name: str) -> str:
        """Return the link that a joint's parent or child refers to; the name itself if unknown."""
        visited: dict[str, None] = {}
        while name not in visited and name not in self._links and ("link", name) not in self._nodes:
            visited[name] = None
            name = self._parent_of(name)
        name = self._links.get(name, name)
        self._links.update(dict.fromkeys(visited, name))
        return name

    def _parent_of(self, name: str) -> str:
        """Return the parent of a frame, or the child link of a joint; otherwise the name."""
        frame, joint = self._nodes.get(("frame", name)), self._nodes.get(("joint", name))
        if frame is not None:
            inside = self._inside.get(("frame", name), ("", name))
            return frame.attribute("attached_to", inside[1])
        child = None if joint is None else joint.optional("child")
        return name if child is None else child.text

    def _add(self, kind: str, node: Node) -> Key:
        name = node.attribute("name", "")
        self._nodes.setdefault((kind, name), node.with_subject(Subject(kind, name)))
        return kind, name

    def _report_shared_names(self) -> None:
        for (kind, name), node in self._nodes.items():
            if kind == "joint" and name and ("link", name) in self._nodes:
                problem = (
                    f"a link is also called {name!r}, which SDF forbids; references mean the link"
                )
                node.warning("shared-name", problem)

    def _loop(self, key: Key) -> Pose:
        self._nodes[key].error("pose-loop", "its pose is relative to itself, via other frames")
        return IDENTITY

    def _placement(self, key: Key, node: Node) -> Placement:
        pose = node.optional("pose")
        default = self._default(key, node)
        if pose is None:
            return Placement(IDENTITY, default)
        reference = self._reference(pose, "relative_to") or self._reference(pose, "frame")
        return Placement(read_pose(pose), reference or default)

    def _default(self, key: Key, node: Node) -> Key:
        """Return the frame that a pose is relative to if none is specified."""
        if key[0] == "joint":
            child = node.optional("child")
            if child is None:
                return MODEL
            return self.named(child.text) or ("link", child.text)
        return self._reference(node, "attached_to") or self._inside.get(key, MODEL)

    def _reference(self, node: Node, attribute: str) -> Key | None:
        name = node.attribute(attribute, "")
        if not name:
            return None
        key = self.named(name)
        if key is None:
            problem = f"{attribute} {short_repr(name)} does not exist as link, joint or frame"
            node.error("unknown-frame", problem)
        return key


def read_pose(node: Node) -> Pose:
    """Return the pose in an element, with Euler angles or a quaternion; identity if empty."""
    format_ = node.attribute("rotation_format", "euler_rpy")
    if format_ not in ("euler_rpy", "quat_xyzw"):
        problem = f"rotation_format {short_repr(format_)} must be euler_rpy or quat_xyzw"
        node.error("unsupported-pose", problem)
        return IDENTITY
    if not node.text:
        return IDENTITY
    if format_ == "quat_xyzw":
        x, y, z, *quaternion = node.numbers(7)
        return Pose((x, y, z), _rpy_of_quaternion(node, *quaternion))
    x, y, z, roll, pitch, yaw = node.numbers(6)
    if node.attribute("degrees", "false") in TRUE:
        roll, pitch, yaw = map(math.radians, (roll, pitch, yaw))
    return Pose((x, y, z), (roll, pitch, yaw))


def _rpy_of_quaternion(node: Node, x: float, y: float, z: float, w: float) -> Vector3:
    norm = math.hypot(x, y, z, w)
    if norm == 0.0 or not math.isfinite(norm):
        node.error("bad-quaternion", "the quaternion of the pose must be finite and not zero")
        return (0.0, 0.0, 0.0)
    return rpy(quaternion_rotation(w / norm, x / norm, y / norm, z / norm))
