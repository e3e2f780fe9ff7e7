"""Write roboy_left_arm.json, the snapshot of a CAD design of Roboy's left arm.

python examples/from_cad/make_roboy_left_arm.py

Links, joints, masses and the eleven muscles are those of examples/roboy_left_arm; the bodies are
bars from joint to joint.
"""

from __future__ import annotations

from array import array
from pathlib import Path

import numpy as np

from addin_sdfusion.robot import WORLD, Inertia, Joint, Link, Pose, Robot, read_robot
from addin_sdfusion.robot.model.rotations import axis_rotation, rotation
from addin_sdfusion.robot.model.transform import IDENTITY, Transform
from addin_sdfusion.settings import ExportSettings
from addin_sdfusion.snapshot import (
    ROOT,
    BodySnapshot,
    DesignSnapshot,
    JointSnapshot,
    MassSnapshot,
    MeshSnapshot,
    MotionSnapshot,
    MuscleSnapshot,
    OccurrenceSnapshot,
    PointSnapshot,
    PointUse,
    SourceSnapshot,
)
from addin_sdfusion.snapshot_file import write_snapshot

EXAMPLES = Path(__file__).parents[1]
FILE = Path(__file__).with_name("roboy_left_arm.json")
COLORS = ("#4477aa", "#66ccee", "#228833", "#ccbb44", "#ee6677")
WIDTH = 0.03  # of the bars, in [m]
NO_LIMIT = 1e6  # in published files, for a joint without limit


def place(pose: Pose) -> Transform:
    """Return a pose as a transform."""
    return Transform(rotation(pose.rpy), pose.position)


def poses(robot: Robot) -> dict[str, Transform]:
    """Return T_world_link of every link at the initial pose; all joints must be revolute."""
    T_world = {WORLD: IDENTITY}
    for joint in robot.joints:
        T = T_world[joint.parent].compose(place(joint.T_parent_joint))
        for motion in joint.motions:
            turn = axis_rotation(motion.axis, joint.coordinates[motion.coordinate].initial)
            T = T.compose(Transform(turn, IDENTITY.p))
        T_world[joint.child] = T.compose(place(joint.T_child_joint).inverse())
    return T_world


def mass(inertia: Inertia, T: Transform) -> MassSnapshot:
    """Return the mass properties about the origin of the root."""
    R, com = np.array(T.R), np.array(T.apply(inertia.com))
    J = R @ np.array(inertia.matrix) @ R.T
    J_root = J + inertia.mass * (com @ com * np.eye(3) - np.outer(com, com))
    at = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))
    moments = tuple(float(J_root[i, j]) for i, j in at)
    principal = tuple(map(float, np.linalg.eigvalsh(J)))
    return MassSnapshot(inertia.mass, tuple(map(float, com)), moments, principal)


def bar(start: np.ndarray, end: np.ndarray) -> MeshSnapshot:
    """Return a square bar between two points."""
    along = end - start
    length = np.linalg.norm(along)
    along = along / length if length > WIDTH else np.array([0.0, 0.0, 1.0])
    if length <= WIDTH:
        start, end = start - WIDTH / 2 * along, start + WIDTH / 2 * along
    side = np.cross(along, np.eye(3)[np.argmin(np.abs(along))])
    side *= WIDTH / 2 / np.linalg.norm(side)
    up = np.cross(along, side)
    corners = [p + a * side + b * up for p in (start, end)
               for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))]  # fmt: skip
    sides = [[k, (k + 1) % 4, k + 4, (k + 1) % 4, (k + 1) % 4 + 4, k + 4] for k in range(4)]
    caps = [[0, 2, 1, 0, 3, 2], [4, 5, 6, 4, 6, 7]]
    nodes = [round(float(x), 6) for corner in corners for x in corner]
    return MeshSnapshot(array("d", nodes), array("i", [i for side in sides + caps for i in side]))


def body(link: Link, T: Transform, end: tuple[float, float, float], color: str) -> BodySnapshot:
    """Return the bar of a link, with the mass of the link."""
    mesh = bar(np.array(T.p), np.array(T.apply(end)))
    return BodySnapshot("bar", f"{link.name}:1", mass=mass(link.inertia, T), mesh=mesh, color=color)


def hinge(joint: Joint, T: dict[str, Transform]) -> JointSnapshot:
    """Return a revolute joint."""
    (motion,), (c,) = joint.motions, joint.coordinates
    at = T[joint.parent].compose(place(joint.T_parent_joint))
    limits = (value if abs(value) < NO_LIMIT else None for value in (c.lower, c.upper))
    turn = MotionSnapshot("rotation", at.rotate(motion.axis), c.initial, *limits)
    paths = f"{joint.child}:1", "torso:1" if joint.parent == WORLD else f"{joint.parent}:1"
    return JointSnapshot(joint.name, "revolute", *paths, at.p, at.p, (turn,))


def points(robot: Robot, T: dict[str, Transform]):
    """Yield the via points of the muscles and the end-effector point."""
    for muscle in robot.muscles:
        for number, via in enumerate(muscle.via_points, start=1):
            path = "torso:1" if via.link == WORLD else f"{via.link}:1"
            name, use = f"{muscle.name}_{number}", PointUse("via", "", muscle.name, number)
            yield PointSnapshot(name, path, T[via.link].apply(via.position), name, use)
    for frame in robot.task_frames:
        use = PointUse("task", name=frame.name, axes=frame.axes)
        at = T[frame.link].apply(frame.position)
        yield PointSnapshot(frame.name, f"{frame.link}:1", at, frame.name, use)


def design() -> DesignSnapshot:
    """Return the design."""
    robot = read_robot(EXAMPLES / "roboy_left_arm/robot")
    T = poses(robot)
    distal = {joint.parent: joint.T_parent_joint.position for joint in robot.joints}
    ends = {link.name: distal.get(link.name, link.end or link.inertia.com) for link in robot.links}
    torso = bar(np.array([0.0, 0.0, 0.0]), np.array([0.0, 0.0, 0.6]))
    steel = MassSnapshot(4.0, (0.0, 0.0, 0.3), (0.48, 0.48, 0.0006, 0, 0, 0), (0.12, 0.12, 0.0006))
    return DesignSnapshot(
        "roboy_left_arm",
        ExportSettings(components=("torso:1", *(f"{link.name}:1" for link in robot.links))),
        (
            OccurrenceSnapshot("torso:1", ROOT, "torso", grounded=True),
            *(OccurrenceSnapshot(f"{link.name}:1", ROOT, link.name) for link in robot.links),
        ),
        (
            BodySnapshot("bar", "torso:1", mass=steel, mesh=torso, color=COLORS[0]),
            *(
                body(link, T[link.name], ends[link.name], color)
                for link, color in zip(robot.links, COLORS[1:], strict=True)
            ),
        ),
        joints=tuple(hinge(joint, T) for joint in robot.joints),
        points=tuple(points(robot, T)),
        muscles=tuple(MuscleSnapshot(m.name, f_min=m.f_min, f_max=m.f_max) for m in robot.muscles),
        source=SourceSnapshot("make_roboy_left_arm.py"),
    )


if __name__ == "__main__":
    print(write_snapshot(design(), FILE))
