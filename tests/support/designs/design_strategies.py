"""Random robots and their designs in a CAD system."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from addin_sdfusion.robot import (
    WORLD,
    CableSet,
    Coordinate,
    Inertia,
    Joint,
    Link,
    Motion,
    Muscle,
    Pose,
    Robot,
    TaskFrame,
    TaskSet,
    ViaPoint,
)
from addin_sdfusion.settings import ExportSettings
from addin_sdfusion.snapshot import (
    BodySnapshot,
    DesignSnapshot,
    GroupSnapshot,
    JointSnapshot,
    MassSnapshot,
    MotionSnapshot,
    MuscleSnapshot,
    OccurrenceSnapshot,
    PointSnapshot,
    PointUse,
)

X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
KINDS: dict[str, tuple[tuple[str, str, Any], ...]] = {
    "rigid": (),
    "revolute": (("", "rotation", Z),),
    "slider": (("", "translation", Z),),
    "cylindrical": (("rotation", "rotation", Z), ("slide", "translation", Z)),
    "pin_slot": (("slide", "translation", X), ("rotation", "rotation", Z)),
    "planar": (
        ("primary_slide", "translation", X),
        ("secondary_slide", "translation", Y),
        ("rotation", "rotation", Z),
    ),
    "ball": (("pitch", "rotation", Z), ("yaw", "rotation", X), ("roll", "rotation", Y)),
}
"""Role, kind and axis in the joint frame of every motion, from `two` to `one`."""


@dataclass(frozen=True)
class Drawn:
    """A robot with its design.

    Attributes:
        robot: Robot written by hand, with arbitrary frames.
        snapshot: Design at the initial pose of the robot.
        T_root_link: 4x4 poses of the links at this pose.
    """

    robot: Robot
    snapshot: DesignSnapshot
    T_root_link: dict[str, Any]


def matrix(pose: Pose) -> Any:
    """Return a pose as 4x4 matrix."""
    T = np.eye(4)
    T[:3, :3] = Rotation.from_euler("xyz", pose.rpy).as_matrix()
    T[:3, 3] = pose.position
    return T


def motion_matrix(kind: str, axis: Sequence[float], value: float) -> Any:
    T = np.eye(4)
    if kind == "rotation":
        T[:3, :3] = Rotation.from_rotvec(value * np.array(axis)).as_matrix()
    else:
        T[:3, 3] = value * np.array(axis)
    return T


def forward(robot: Robot, q: dict[str, float]) -> dict[str, Any]:
    """Return the 4x4 poses of the links in the world frame."""
    poses = {WORLD: np.eye(4)}
    for joint in robot.joints:
        T = poses[joint.parent] @ matrix(joint.T_parent_joint)
        for motion in joint.motions:
            T = T @ motion_matrix(
                motion.kind, motion.axis, q[joint.coordinates[motion.coordinate].name]
            )
        poses[joint.child] = T @ np.linalg.inv(matrix(joint.T_child_joint))
    return poses


def initial(robot: Robot) -> dict[str, float]:
    return {c.name: c.initial for c in robot.coordinates}


def mass_of(parts: Sequence[tuple[float, Any, Any]], sign: int = 1) -> MassSnapshot:
    """Return CAD mass properties of parts (mass, com, inertia), in the root frame."""
    mass = sum(m for m, _, _ in parts)
    com = sum(m * c for m, c, _ in parts) / mass
    about_origin = sum(J + shift(m, c) for m, c, J in parts)
    own = about_origin - shift(mass, com)
    xx, yy, zz = np.diag(about_origin)
    products = [sign * about_origin[i, j] for i, j in ((0, 1), (1, 2), (0, 2))]
    moments = tuple(map(float, (xx, yy, zz, *products)))
    principal = tuple(map(float, np.linalg.eigvalsh(own)))
    return MassSnapshot(float(mass), tuple(map(float, com)), moments, principal)


def shift(mass: float, r: Any) -> Any:
    return mass * (r @ r * np.eye(3) - np.outer(r, r))


def moved(T: Any, p: Sequence[float]) -> tuple[float, float, float]:
    x, y, z = T[:3, :3] @ np.array(p) + T[:3, 3]
    return float(x), float(y), float(z)


def shuffled(snapshot: DesignSnapshot, seed: int) -> DesignSnapshot:
    """Return the same design with another order of creation."""
    order = np.random.default_rng(seed)

    def some(items: Any) -> Any:
        return tuple(items[i] for i in order.permutation(len(items)))

    groups = [replace(g, occurrences=some(g.occurrences)) for g in snapshot.groups]
    return replace(
        snapshot,
        occurrences=some(snapshot.occurrences),
        bodies=some(snapshot.bodies),
        groups=some(groups),
        joints=some(snapshot.joints),
        points=some(snapshot.points),
        surfaces=some(snapshot.surfaces),
    )


@dataclass
class Draughtsman:
    """Generator of random robots and their designs from one seed.

    `links` is the number of links without the base. The design is at a nonzero pose if `displaced`,
    and the frames of the robot are rotated if `rotated`. `sign` is the sign of the products of
    inertia.
    """

    seed: int
    links: int
    kinds: Sequence[str] = tuple(KINDS)
    displaced: bool = True
    rotated: bool = True
    reversed_: bool = True
    groups: bool = True
    sign: int = 1
    nesting: int = 2
    muscles: int = 4

    def __post_init__(self) -> None:
        self.rng = np.random.default_rng(self.seed)

    def draw(self) -> Drawn:
        names = [f"link_{k}" for k in range(self.links + 1)]
        joints = [Joint("world_link_0", WORLD, "link_0", T_parent_joint=self.pose())]
        how = []
        for k, name in enumerate(names[1:], start=1):
            parent = names[int(self.rng.integers(0, k))]
            joint, about = self.joint(f"joint_{k}", parent, name)
            joints.append(joint)
            how.append(about)
        bodies = {name: [self.body() for _ in range(self.rng.integers(1, 4))] for name in names}
        links = tuple(Link(name, _inertia(bodies[name])) for name in names)
        muscles = tuple(self.muscle(k, names) for k in range(self.muscles))
        tasks = tuple(TaskFrame(f"tip_{k}", names[-1 - k], self.vector()) for k in range(1))
        robot = Robot(
            "drawn",
            links,
            tuple(joints),
            (CableSet("muscles", muscles),) if muscles else (),
            "muscles" if muscles else "",
            (TaskSet("task", tasks),),
            "task",
        )
        poses = forward(robot, initial(robot))
        return Drawn(robot, self.snapshot(robot, poses, bodies, how), poses)

    # The robot ----------------------------------------------------------------------------------

    def vector(self, size: float = 0.5) -> tuple[float, float, float]:
        x, y, z = self.rng.uniform(-size, size, 3)
        return float(x), float(y), float(z)

    def pose(self) -> Pose:
        return Pose(self.vector(), self.vector(3.0) if self.rotated else (0.0, 0.0, 0.0))

    def joint(self, name: str, parent: str, child: str) -> tuple[Joint, dict[str, Any]]:
        kind = str(self.rng.choice(self.kinds))
        flipped = bool(self.reversed_ and self.rng.random() < 0.5)
        coordinates, motions = [], []
        for role, what, axis in KINDS[kind]:
            value = float(self.rng.uniform(-1.0, 1.0)) if self.displaced else 0.0
            limits = (-2.0, 2.5) if self.rng.random() < 0.5 else (-np.inf, np.inf)
            called = f"{name}_{role}" if role else name
            unit = "rad" if what == "rotation" else "m"
            coordinates.append(Coordinate(called, *limits, value, unit=unit))
            sense = -1.0 if flipped else 1.0
            motions.append((what, tuple(sense * a for a in axis)))
        if flipped:
            coordinates.reverse()
            motions.reverse()
        drawn = Joint(
            name,
            parent,
            child,
            tuple(Motion(what, axis, k) for k, (what, axis) in enumerate(motions)),
            tuple(coordinates),
            self.pose(),
            self.pose(),
        )
        return drawn, {"kind": kind, "flipped": flipped, "as_built": self.rng.random() < 0.3}

    def body(self) -> tuple[float, Any, Any]:
        """Return mass, centre of mass and inertia in the link frame."""
        a = self.rng.uniform(0.01, 0.1, 3)
        R = Rotation.random(random_state=int(self.rng.integers(1 << 31))).as_matrix()
        J = R @ np.diag([a[1] + a[2], a[0] + a[2], a[0] + a[1]]) @ R.T
        return float(self.rng.uniform(0.2, 2.0)), self.rng.uniform(-0.3, 0.3, 3), J

    def muscle(self, k: int, names: Sequence[str]) -> Muscle:
        points = [
            ViaPoint(str(self.rng.choice([WORLD, *names])), self.vector())
            for _ in range(self.rng.integers(2, 5))
        ]
        return Muscle(f"muscle_{k}", tuple(points), 1.0 + k, 50.0 + k)

    # The design ---------------------------------------------------------------------------------

    def snapshot(
        self, robot: Robot, poses: dict[str, Any], bodies: dict[str, Any], how: Any
    ) -> DesignSnapshot:
        occurrences: list[OccurrenceSnapshot] = []
        drawn: list[BodySnapshot] = []
        paths = {}
        for link in robot.links:
            path = ""
            grounded = link.name == "link_0"
            for k in range(int(self.rng.integers(0, self.nesting + 1))):
                at = f"{link.name} holder {k}:1"
                new = f"{path}+{at}" if path else at
                occurrences.append(OccurrenceSnapshot(new, path, at[:-2], grounded))
                path = new
            leaf = f"{link.name}:1"
            new = f"{path}+{leaf}" if path else leaf
            paths[link.name] = new
            parts = [_placed(part, poses[link.name]) for part in bodies[link.name]]
            first = OccurrenceSnapshot(
                new, path, link.name, grounded, mass=mass_of(parts, self.sign)
            )
            occurrences.append(first)
            for i, part in enumerate(parts):
                at = new
                if i:  # other bodies in child components
                    at = f"{new}+part:{i}"
                    inner = mass_of([part], self.sign) if self.rng.random() < 0.5 else None
                    occurrences.append(OccurrenceSnapshot(at, new, "part", mass=inner))
                drawn.append(BodySnapshot(f"Body{i + 1}", at, mass=mass_of([part], self.sign)))
        groups = [GroupSnapshot(f"EXPORT_{n}", (p,)) for n, p in paths.items()]
        settings = ExportSettings(components=() if self.groups else tuple(paths.values()))
        return DesignSnapshot(
            "drawn",
            settings,
            tuple(occurrences),
            tuple(drawn),
            tuple(groups) if self.groups else (),
            tuple(
                _joint(j, about, poses, paths)
                for j, about in zip(robot.joints[1:], how, strict=True)
            ),
            tuple(self.points(robot, poses, paths)),
            muscles=tuple(
                MuscleSnapshot(m.name, f_min=m.f_min, f_max=m.f_max) for m in robot.muscles
            ),
        )

    def points(self, robot: Robot, poses: dict[str, Any], paths: dict[str, str]) -> Any:
        for i, muscle in enumerate(robot.muscles):
            for k, via in enumerate(muscle.via_points):
                yield PointSnapshot(
                    f"VP_motor{i}_EXPORT_{via.link}_{k}",
                    paths.get(via.link, ""),
                    moved(poses[via.link], via.position),
                    f"p{i}.{k}",
                    PointUse("via", via.link, muscle.name, k),
                )
        for task in robot.task_frames:
            use = PointUse("task", task.link, name=task.name)
            at = moved(poses[task.link], task.position)
            yield PointSnapshot(f"EE_{task.name}", paths[task.link], at, task.name, use)


def _inertia(parts: Any) -> Inertia:
    mass = sum(m for m, _, _ in parts)
    com = sum(m * c for m, c, _ in parts) / mass
    J = sum(J + shift(m, c - com) for m, c, J in parts)
    entries = (J[0, 0], J[1, 1], J[2, 2], J[0, 1], J[0, 2], J[1, 2])
    return Inertia(mass, tuple(map(float, com)), *map(float, entries))


def _placed(part: Any, T: Any) -> Any:
    mass, com, J = part
    R = T[:3, :3]
    return mass, R @ com + T[:3, 3], R @ J @ R.T


def _joint(joint: Joint, how: Any, poses: Any, paths: Any) -> JointSnapshot:
    """Return the joint in the CAD system: `one` moves relative to `two`."""
    parent = poses[joint.parent] @ matrix(joint.T_parent_joint)
    child = poses[joint.child] @ matrix(joint.T_child_joint)
    names = (joint.child, joint.parent)
    T_one, T_two = child, parent
    coordinates = joint.coordinates
    if how["flipped"]:
        T_one, T_two = T_two, T_one
        names = names[::-1]
        coordinates = coordinates[::-1]
    motions = []
    for (role, what, axis), c in zip(KINDS[how["kind"]], coordinates, strict=True):
        a = tuple(map(float, T_two[:3, :3] @ np.array(axis)))
        lower = None if c.lower == -np.inf else c.lower
        upper = None if c.upper == np.inf else c.upper
        motions.append(MotionSnapshot(what, a, c.initial, lower, upper, role))
    one, two = (paths[name] for name in names)
    origin_one, origin_two = moved(T_one, (0, 0, 0)), moved(T_two, (0, 0, 0))
    return JointSnapshot(
        joint.name,
        how["kind"],
        one,
        two,
        None if how["as_built"] else origin_one,
        origin_two,
        tuple(motions),
        how["as_built"],
    )


@st.composite
def drawn_designs(draw: st.DrawFn) -> Drawn:
    """Draw a robot with a random pose, nesting and position."""
    man = Draughtsman(
        draw(st.integers(0, 1 << 30)),
        draw(st.integers(1, 6)),
        displaced=draw(st.booleans()),
        rotated=draw(st.booleans()),
        reversed_=draw(st.booleans()),
        groups=draw(st.booleans()),
        sign=draw(st.sampled_from([1, -1])),
        nesting=draw(st.integers(0, 3)),
    )
    return man.draw()
