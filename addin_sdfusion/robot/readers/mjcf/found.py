"""Numbers that MuJoCo finds when it reads a file: ranges of lengths, forces, rest lengths.

MuJoCo finds ranges of lengths by a simulation, to some percent; here they are the least and the
largest length that a search over the joints' ranges finds. A negative force means
F = scale / acc0, with acc0 the length of M^-1 moment at the reference pose, as there.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

from ...checks.check import check
from ...formats.reading.xml import ZERO, Node
from ...limits import MUSCLES_WITHOUT_FORCE, MUSCLES_WITHOUT_RANGE
from ...model.coupling import all_values
from ...model.function import derivatives
from ...model.joint import Coordinate
from ...model.muscle import Muscle, WrapSurface
from ...model.pose import Pose, Vector3
from ...model.robot import WORLD, Robot
from ...model.rotations import (
    add,
    axis_rotation,
    cross,
    dot,
    normalized,
    rotate,
    rotate_inertia,
    rotation,
)
from ...model.transform import IDENTITY, Transform
from .path import direction, path_of

GRID, SWEEPS = 6, 2
DEFAULT_SCALE = 200.0

Screw = tuple[Vector3, Vector3]
"""Angular velocity, and the velocity of what is at the world's origin, a unit of speed."""


class Pose0:
    """A robot at values of its coordinates: where its links are, and how they move.

    Attributes:
        poses: The place of each link in the world.
        screws: How each link moves with each coordinate.
    """

    def __init__(self, robot: Robot, q: Mapping[str, float]) -> None:
        self.q = dict(q)
        self.poses = {WORLD: IDENTITY}
        self.screws: dict[str, dict[str, Screw]] = {WORLD: {}}
        for joint in robot.joints:
            T = self.poses[joint.parent].compose(_transform(joint.T_parent_joint))
            screws = dict(self.screws[joint.parent])
            for motion in joint.motions:
                name = "" if motion.is_fixed else joint.coordinates[motion.coordinate].name
                way, slope, _ = derivatives(motion.function, self.q.get(name, 0.0))
                axis = normalized(motion.axis)
                turned = T.rotate(axis)
                if motion.kind == "rotation":
                    step = Transform(axis_rotation(axis, way), ZERO)
                    screw = (turned, cross(T.p, turned))
                else:
                    step = Transform(IDENTITY.R, (way * axis[0], way * axis[1], way * axis[2]))
                    screw = (ZERO, turned)
                if name:
                    w, v = screws.get(name, (ZERO, ZERO))
                    screws[name] = _plus(w, slope, screw[0]), _plus(v, slope, screw[1])
                T = T.compose(step)
            self.poses[joint.child] = T.compose(_transform(joint.T_child_joint).inverse())
            self.screws[joint.child] = screws

    def moment(self, muscle: Muscle, surfaces: Mapping[str, WrapSurface]) -> dict[str, float]:
        """dl/dq by coordinate."""
        found = {term.coordinate: term.factor for term in muscle.terms}
        for piece in path_of(muscle, surfaces, self.poses, self.q).pieces:
            u = direction(piece)
            for sign, link, point in (
                (1.0, piece.end_link, piece.end),
                (-1.0, piece.start_link, piece.start),
            ):
                for name, (w, v) in self.screws[link].items():
                    speed = dot(u, add(v, cross(w, point)))
                    found[name] = found.get(name, 0.0) + sign * piece.share * speed
        return found


def with_found(robot: Robot, nodes: Mapping[str, Node]) -> Robot:
    """The robot with numbers for its muscles where its file has none.

    Args:
        robot: The robot as its file says it.
        nodes: The elements of the muscles, for findings.
    """
    surfaces = {surface.name: surface for surface in robot.wrap_surfaces}
    open_ = [m for m in robot.muscles if _lacks(m)]
    if not open_ or not _is_sound(robot):
        return robot
    reference = {c.name: c.initial for c in robot.all_coordinates}
    pose0 = Pose0(robot, reference)
    factor: _Factor | None = None
    left = MUSCLES_WITHOUT_RANGE
    movers = _Movers(robot)
    n = len(reference)
    too_many = n * n * (n + len(open_)) > MUSCLES_WITHOUT_FORCE
    changed: dict[str, Muscle] = {}
    for muscle in open_:
        values = dict(muscle.model.parameters)
        if muscle.model.kind == "tendon_spring":
            rest = path_of(muscle, surfaces, pose0.poses, reference).length
            values |= {"rest_low": rest, "rest_high": rest}
        else:
            if values.get("force", -1.0) < 0.0 and "acc0" not in values:
                if too_many:
                    _note_no_force(nodes.get(muscle.name))
                    continue
                factor = factor or _Factor(robot, pose0)
                acc0 = factor.acceleration(pose0.moment(muscle, surfaces))
                values |= _force(values.pop("scale", DEFAULT_SCALE), acc0)
            if not values.get("length_high", 0.0) > values.get("length_low", 0.0):
                node = nodes.get(muscle.name)
                lengths, left = _range_of(robot, muscle, surfaces, movers, left)
                if lengths is None:
                    _note_no_range(node)
                    continue
                values |= {"length_low": lengths[0], "length_high": lengths[1]}
                _note_range(node, lengths)
        model = replace(muscle.model, parameters=tuple(values.items()))
        changed[muscle.name] = replace(muscle, model=model)
    return robot.with_muscles(changed.get(m.name, m) for m in robot.muscles)


def _force(scale: float, acc0: float) -> dict[str, float]:
    """The force that a scale means; MuJoCo's own words where nothing resists."""
    return {"force": scale / acc0} if acc0 > 0.0 else {"scale": scale, "acc0": acc0}


def _lacks(muscle: Muscle) -> bool:
    values = dict(muscle.model.parameters)
    if muscle.model.kind == "tendon_spring":
        return values.get("rest_low", 0.0) < 0.0
    if muscle.model.kind != "mujoco_muscle":
        return False
    ranged = values.get("length_high", 0.0) > values.get("length_low", 0.0)
    return not ranged or (values.get("force", -1.0) < 0.0 and "acc0" not in values)


def _is_sound(robot: Robot) -> bool:
    """Whether the tree is one that can be walked."""
    broken = ("bad-law-parameter", "missing-law-parameter")
    return not any(f.is_error and f.code not in broken for f in check(robot))


def _note_range(node: Node | None, lengths: tuple[float, float]) -> None:
    if node is not None:
        low, high = lengths
        problem = (
            f"no lengthrange: {low:.6g} to {high:.6g} m is what a search over the joints' ranges "
            "finds; MuJoCo finds its own by a simulation, to some percent; give it if it matters"
        )
        node.warning("length-range-found", problem)


def _note_no_force(node: Node | None) -> None:
    if node is not None:
        problem = "no force, and too many coordinates and muscles to find it: give it"
        node.error("no-force", problem)


def _note_no_range(node: Node | None) -> None:
    if node is not None:
        problem = (
            "no lengthrange, and joints without ranges or too many muscles to find it: give it"
        )
        node.error("no-length-range", problem)


def _range_of(
    robot: Robot,
    muscle: Muscle,
    surfaces: Mapping[str, WrapSurface],
    movers: _Movers,
    left: int,
) -> tuple[tuple[float, float] | None, int]:
    """The least and the largest length over the ranges of the joints that move it."""
    free = movers.of(muscle, surfaces)
    due = 2 * (2 * SWEEPS * max(len(free), 1) * GRID) * len(robot.joints)
    ends_of = {c.name: _ends_of(c, bool(muscle.terms)) for c in free}
    if left < due or not all(math.isfinite(end) for ends in ends_of.values() for end in ends):
        return None, left
    start = {c.name: c.initial for c in robot.coordinates}

    def length(q: Mapping[str, float]) -> float:
        values = all_values(robot, q)
        return path_of(muscle, surfaces, Pose0(robot, values).poses, values).length

    ends = []
    for sign in (1.0, -1.0):
        q = dict(start)
        best = sign * length(q)
        for sweep in range(2 * SWEEPS):
            for c in free:
                lower, upper = ends_of[c.name]
                width = (upper - lower) / (GRID - 1) / (1.0 if sweep < SWEEPS else GRID)
                middle = 0.5 * (lower + upper) if sweep < SWEEPS else q[c.name]
                for k in range(GRID):
                    at = middle + (k - (GRID - 1) / 2.0) * width
                    trial = q | {c.name: min(max(at, lower), upper)}
                    value = sign * length(trial)
                    if value < best:
                        best, q = value, trial
        ends.append(sign * best)
    low, high = ends
    return ((low, high) if low < high else None), left - due


def _ends_of(c: Coordinate, is_sum: bool) -> tuple[float, float]:
    """The ends of a coordinate's range; a whole turn, which has all lengths, of a hinge without."""
    if c.unit == "rad" and math.isinf(c.lower) and math.isinf(c.upper) and not is_sum:
        return c.initial - math.pi, c.initial + math.pi
    return c.lower, c.upper


class _Movers:
    """The free coordinates that change lengths, found at a pose near the initial one."""

    def __init__(self, robot: Robot) -> None:
        self._above: dict[str, frozenset[str]] = {WORLD: frozenset()}
        for joint in robot.joints:
            own = {c.name for c in joint.coordinates}
            self._above[joint.child] = self._above[joint.parent] | own
        self._all = {c.name: c for c in robot.all_coordinates}
        self._free = {c.name: k for k, c in enumerate(robot.coordinates)}

    def of(self, muscle: Muscle, surfaces: Mapping[str, WrapSurface]) -> list[Coordinate]:
        """Those that change a muscle's length."""
        links = {p.link for p in muscle.via_points}
        links |= {surfaces[w.surface].link for w in muscle.wraps}
        sets = [self._above[link] for link in links]
        names = set().union(*sets) - set(frozenset.intersection(*sets) if sets else ())
        names |= {term.coordinate for term in muscle.terms}
        waiting = list(names)
        while waiting:
            follows = [t.coordinate for t in self._all[waiting.pop()].coupling]
            waiting += [name for name in follows if name not in names]
            names |= set(follows)
        return [
            self._all[name]
            for name in sorted(names & self._free.keys(), key=self._free.__getitem__)
        ]


class _Factor:
    """The Cholesky factor of a robot's mass matrix at a pose, couplings not applied."""

    def __init__(self, robot: Robot, at: Pose0) -> None:
        coordinates = robot.all_coordinates
        self.names = [c.name for c in coordinates]
        n = len(self.names)
        M = [[0.0] * n for _ in range(n)]
        for k, c in enumerate(coordinates):
            M[k][k] = c.armature
        index = {name: k for k, name in enumerate(self.names)}
        for link in robot.links:
            self._add(M, index, link.name, at, robot)
        self.L = _cholesky(M)

    def _add(
        self, M: list[list[float]], index: Mapping[str, int], name: str, at: Pose0, robot: Robot
    ) -> None:
        inertia, T = robot.link(name).inertia, at.poses[name]
        com, matrix = T.apply(inertia.com), rotate_inertia(T.R, inertia.matrix)
        rows = [(index[of], w, add(v, cross(w, com))) for of, (w, v) in at.screws[name].items()]
        for i, wi, vi in rows:
            Iw = rotate(matrix, wi)
            for j, wj, vj in rows:
                M[i][j] += inertia.mass * dot(vi, vj) + dot(Iw, wj)

    def acceleration(self, moment: Mapping[str, float]) -> float:
        """The length of M^-1 moment; 0 where M is singular."""
        if self.L is None:
            return 0.0
        n = len(self.names)
        x = [moment.get(name, 0.0) for name in self.names]
        for i in range(n):
            x[i] = (x[i] - sum(self.L[i][k] * x[k] for k in range(i))) / self.L[i][i]
        for i in reversed(range(n)):
            x[i] = (x[i] - sum(self.L[k][i] * x[k] for k in range(i + 1, n))) / self.L[i][i]
        return math.hypot(*x)


def _cholesky(M: Sequence[Sequence[float]]) -> list[list[float]] | None:
    n = len(M)
    L = [[0.0] * n for _ in range(n)]
    for i in range(n):
        for j in range(i + 1):
            rest = M[i][j] - sum(L[i][k] * L[j][k] for k in range(j))
            if i == j:
                if not rest > 0.0:
                    return None
                L[i][i] = math.sqrt(rest)
            else:
                L[i][j] = rest / L[j][j]
    return L


def _transform(pose: Pose) -> Transform:
    return Transform(rotation(pose.rpy), pose.position)


def _plus(v: Vector3, factor: float, w: Vector3) -> Vector3:
    return v[0] + factor * w[0], v[1] + factor * w[1], v[2] + factor * w[2]
