"""Frames of an OpenSim model: bodies, the ground, and frames with an offset from them."""

from __future__ import annotations

import math

from ....finding_builders import unknown
from ....model.pose import Pose, Vector3
from ....model.robot import WORLD
from ....model.rotations import Matrix3, multiply, rotation
from ....model.transform import IDENTITY, Transform
from ...reading.xml import ZERO, Node
from .document import OFFSET_FRAME, SETS, last_part, objects

GROUND = "/ground"
MAX_OFFSETS = 50
"""Maximum number of offset frames in a chain."""


class Frames:
    """Poses of all frames, by their path in the model."""

    def __init__(self, model: Node) -> None:
        self.bodies = {"ground": WORLD}
        self._offsets: dict[str, tuple[Node, str]] = {}
        self._by_name: dict[str, list[str]] = {}
        self._places: dict[str, tuple[str, Transform] | None] = {}
        for ground in model.all("Ground"):
            self._add_offsets(ground, GROUND, "components")
        for body in objects(model, "BodySet"):
            name = body.attribute("name", "")
            self.bodies.setdefault(name, name)
            self._add_offsets(body, f"/bodyset/{name}", "components")
        for joint in objects(model, "JointSet"):
            self._add_offsets(joint, f"/jointset/{joint.attribute('name', '')}", "frames")
        for constraint in objects(model, "ConstraintSet"):
            self._add_offsets(
                constraint, f"/constraintset/{constraint.attribute('name', '')}", "frames"
            )
        for frame in objects(model, "ComponentSet"):
            if frame.tag == OFFSET_FRAME:
                self._add(frame, f"/componentset/{frame.attribute('name', '')}")

    def offsets(self, link: str) -> list[tuple[str, Node]]:
        """Return the paths and elements of all frames fixed to a link, also through others."""
        return [
            (path, node)
            for path, (node, _) in self._offsets.items()
            if (place := self._place(path)) is not None and place[0] == link
        ]

    def place(self, node: Node, tag: str, owner: str) -> tuple[str, Transform]:
        """Return the link of a socket, and the pose of its frame in the link.

        Args:
            node: The element that contains the socket.
            tag: The tag of the socket, such as `socket_parent_frame`.
            owner: Path of the element that contains the socket.
        """
        socket = node.optional(tag) or node.optional(f"{tag}_connectee_name")
        if socket is None:
            node.error("missing-element", f"<{node.tag}> has no <{tag}>")
            return WORLD, IDENTITY
        place = self._place(self._path(socket.text, owner))
        if place is None:
            names = [*self.bodies, *self._by_name]
            socket.error("unknown-frame", f"<{tag}>: {unknown('frame', socket.text, names)}")
            return WORLD, IDENTITY
        return place

    def _add_offsets(self, owner: Node, path: str, tag: str) -> None:
        for group in owner.all(tag):
            for frame in group.all(OFFSET_FRAME):
                self._add(frame, f"{path}/{frame.attribute('name', '')}")

    def _add(self, frame: Node, path: str) -> None:
        if path in self._offsets:
            frame.warning(
                "duplicate-frame",
                f"another frame is already called {path!r}; references use the earlier one",
            )
            return
        self._offsets[path] = (frame, path)
        self._by_name.setdefault(last_part(path), []).append(path)
        for group in frame.all("components"):
            for inner_element in group.all(OFFSET_FRAME):
                self._add(inner_element, f"{path}/{inner_element.attribute('name', '')}")

    def _path(self, words: str, owner: str) -> str:
        """Return the absolute path of a socket; a name without a path may be anywhere."""
        if words.startswith("/"):
            return self._in_set(words)
        path = _absolute_path(words, owner)
        if self._place(path) is not None:
            return path
        name = last_part(words)
        if name in self.bodies:
            return f"/bodyset/{name}"
        paths = self._by_name.get(name, [])
        return paths[0] if len(paths) == 1 else path

    def _in_set(self, path: str) -> str:
        """Return a path with the set that contains a component of the model."""
        for owner in ("", *(f"/{name.lower()}" for name in SETS)):
            kind, _, name = f"{owner}{path}".rpartition("/")
            if owner + path in self._offsets or (kind == "/bodyset" and name in self.bodies):
                return owner + path
        return path

    def _place(self, path: str) -> tuple[str, Transform] | None:
        """Return the link of a frame and its pose in the link, or None if it does not exist."""
        if path not in self._places:
            self._places[path] = self._find_place(path, 0)
        return self._places[path]

    def _find_place(self, path: str, depth: int) -> tuple[str, Transform] | None:
        """Find the link of a frame and its pose; `depth` is the number of frames traversed."""
        kind, _, name = path.rpartition("/")
        if path == GROUND or (kind == "/bodyset" and name in self.bodies):
            return self.bodies[name], IDENTITY
        if path not in self._offsets or depth > MAX_OFFSETS:
            return None
        node, frame_path = self._offsets[path]
        socket = node.optional("socket_parent") or node.optional("socket_parent_connectee_name")
        parent = None
        if socket is not None:
            parent = self._find_place(self._parent_path(socket.text, frame_path), depth + 1)
        if parent is None:
            return None
        link, T_link_parent = parent
        return link, T_link_parent.compose(offset(node, "orientation"))

    def _parent_path(self, words: str, frame_path: str) -> str:
        """Return the absolute path of a parent socket; a frame is never its own parent."""
        if words.startswith("/"):
            return self._in_set(words)
        path = _absolute_path(words, frame_path)
        if path in self._offsets or path == GROUND or path.startswith("/bodyset/"):
            return path
        name = last_part(words)
        return f"/bodyset/{name}" if name != "ground" else GROUND


def offset(node: Node, angles: str) -> Transform:
    """Return the pose of a frame or a wrap object in its parent.

    Args:
        angles: Tag of its body-fixed angles about x, y and z.
    """
    p = node.vector("translation") if node.all("translation") else ZERO
    xyz = node.vector(angles) if node.all(angles) else ZERO
    return Transform(rotation_xyz(xyz), p)


def rotation_xyz(angles: Vector3) -> Matrix3:
    """Return R = Rx(a) Ry(b) Rz(c) for angles in [rad]; single rotations equal `rotation`."""
    a, b, c = angles
    if not all(map(math.isfinite, angles)):
        return IDENTITY.R
    first = multiply(rotation((a, 0.0, 0.0)), rotation((0.0, b, 0.0)))
    return multiply(first, rotation((0.0, 0.0, c)))


def pose_of(T: Transform, node: Node | None = None, angles: str = "orientation") -> Pose:
    """Return a transform as a pose; the angle of a rotation about one axis stays exact.

    Args:
        node: Element that completely defines the transform, or None.
        angles: Tag of its angles.
    """
    if node is not None and node.all(angles):
        xyz = node.vector(angles)
        if sum(1 for angle in xyz if angle) <= 1 and all(abs(angle) < 1.5 for angle in xyz):
            return Pose(T.p, xyz)
    return T.pose()


def _absolute_path(words: str, owner: str) -> str:
    """Return the absolute path of a path relative to an owner."""
    parts = owner.split("/")
    for word in words.split("/"):
        if word == "..":
            parts = parts[:-1]
        elif word != ".":
            parts.append(word)
    return "/".join(parts)
