"""World of a robot in DART: ground, objects and contacts.

ODE detects contacts. It is the only collision detector of DART that simulates resting, sliding and
bouncing of all shapes correctly: FCL replaces capsules by spheres, meshes fall through each other
with DART's detector, and sliding cylinders and meshes spin with Bullet.

DART computes contact forces without joint damping. Therefore the contact force of a link that is
pressed by a damped joint is too small by a factor of up to h d / m. After a collision at speed v,
the overlap is up to v h. It decreases by 1 mm/s.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from addin_sdfusion.robot import (
    WORLD,
    InputError,
    Pose,
    Robot,
    SimulationError,
    UnknownNameError,
    limits,
)
from sim_dart.core.arrays import FloatArray
from sim_dart.core.frames import transform
from sim_dart.scene import GROUND, MAX_DISTANCE, Box, Scene, SceneObject, Shape

from .collision_pairs import connected_links
from .contacts import Contact, contact_forces, read_contacts
from .link_shapes import link_shapes
from .shapes import SolidShape, Surface, attach, solid_shape, surface
from .skeleton import Skeleton
from .tunnelling import SpeedWatch, WatchedBody

_GROUND_EDGE, _GROUND_DEPTH = 1000.0, 10.0  # in [m]
_MAX_OVERLAP = 1e-3  # in [m]; bodies with a larger overlap would fly apart at the start
_SWEEPS, _TOLERANCE = 200, 1e-6  # of the solver for friction cones


class World:
    """Robot in a scene, in DART.

    Args:
        skeleton: The robot in DART.
        step: Length of a step, in [s].
        scene: Ground, objects and link shapes, or None for no collisions.

    Raises:
        InputError: The scene does not match the robot, or a mesh cannot be used.
        UnknownNameError: The scene refers to a link or object that does not exist.

    Attributes:
        step: Function that simulates one step. It raises SimulationError if an object leaves the
            simulated space, or is so fast that it could pass through another.
    """

    step: Callable[[], None]

    def __init__(
        self, skeleton: Skeleton, robot: Robot, step: float, scene: Scene | None = None
    ) -> None:
        self._skeleton, self._step = skeleton, step
        self._dart = _empty_world(robot, step)
        self._objects: list[tuple[SceneObject, Any]] = []
        self._bodies: dict[str, WatchedBody] = {}
        self._owners: dict[Any, str] = {}
        self._rows: dict[Any, int] = {}
        self._reported = 0
        self._cones: Any = None
        for dart in skeleton.darts:
            self._dart.addSkeleton(dart)
        self.step = self._dart.step
        if scene is not None:
            self._add_scene(robot, scene)
            self.step = self._watched_step

    @property
    def has_contacts(self) -> bool:
        """Whether contacts are simulated."""
        return bool(self._bodies)

    @property
    def time(self) -> float:
        """Current time for messages, in [s]."""
        return float(self._dart.getTime())

    @time.setter
    def time(self, value: float) -> None:
        self._dart.setTime(value)

    def reset(self) -> None:
        """Reset the objects to their initial states, with the robot at its initial state.

        Raises:
            InputError: Two bodies overlap, or a body is too far away.
        """
        for item, dart in self._objects:
            _place(dart, item)
        if self._cones is not None:
            self._cones.resetStats()
        if self.has_contacts:
            self._reject_far_bodies()
            self._reject_overlap()

    def contacts(self) -> list[Contact]:
        """Return all contacts of the last step with their forces."""
        return read_contacts(self._dart.getLastCollisionResult(), self._owners)

    def contact_forces(self) -> FloatArray:
        """Return the sum of contact forces on each reported body, world axes, shape (k, 3), in [N].

        The forces are constant over the last step.
        """
        return contact_forces(self._dart.getLastCollisionResult(), self._rows, self._reported)

    def take_friction_error(self) -> FloatArray:
        """Return the error of the solver for friction cones since the last call, and reset it.

        Returns:
            Shape (2,): the largest violation of Coulomb's law at a contact as a speed, in [m/s];
            and 1 if the contact forces of any step did not converge to 1e-6 m/s, otherwise 0.
            Shape (0,) with friction pyramids, whose solver does not report errors. If the solver
            for cones fails, DART uses its solver for pyramids, whose error is not included.
        """
        if self._cones is None:
            return np.empty(0)
        stats = self._cones.getStats()
        self._cones.resetStats()
        return np.array([stats.maxViolation, stats.numConverged < stats.numSolves], np.float64)

    def object_poses(self) -> FloatArray:
        """Return position and orientation of the free objects, shape (k, 7).

        Columns are x, y, z in [m], and the unit quaternion w, x, y, z with w >= 0.
        """
        return np.array([_pose(dart) for _, dart in self._objects]).reshape(-1, 7)

    def get_state(self) -> FloatArray:
        """Return positions and velocities of the free objects, shape (12 k,)."""
        return np.array(
            [[*dart.getPositions(), *dart.getVelocities()] for _, dart in self._objects]
        ).reshape(-1)

    def set_state(self, state: FloatArray) -> None:
        """Restore a state from `get_state`."""
        for (_, dart), values in zip(self._objects, state.reshape(-1, 12), strict=True):
            dart.resetAccelerations()
            dart.setPositions(values[:6])
            dart.setVelocities(values[6:])

    def _watched_step(self) -> None:
        fast = self._watch.too_fast()
        if fast is not None:
            raise SimulationError(
                f"at t = {self.time:.6g} s {fast.first!r} could pass through {fast.second!r}: they "
                f"approach at up to {fast.speed:.3g} m/s, and contacts are only detected at "
                f"steps; use a plant step of at most {fast.step:.2g} s"
            )
        self._dart.step()
        for item, dart in self._objects:
            state = np.concatenate([dart.getPositions(), dart.getVelocities()])
            if not np.abs(state).max() < MAX_DISTANCE:
                self._reject_lost(item, state)

    def _reject_lost(self, item: SceneObject, state: FloatArray) -> None:
        where = ", ".join(f"{value:.3g}" for value in state[3:6])
        raise SimulationError(
            f"at t = {self.time:.6g} s object {item.name!r} is at ({where}) m with a velocity of "
            f"{np.linalg.norm(state[9:]):.3g} m/s, outside of the simulated space; use a smaller "
            "step, or place the object so that it does not overlap other bodies"
        )

    def _add_scene(self, robot: Robot, scene: Scene) -> None:
        import dartpy

        _reject_too_many(len(scene.objects))
        solver = self._dart.getConstraintSolver()
        solver.setCollisionDetector(dartpy.collision.OdeCollisionDetector())
        if scene.friction_law == "cone":
            self._cones = _cone_solver()
            solver.setBoxedLcpSolver(self._cones)
        if scene.ground is not None:
            self._add_ground(scene, scene.ground.height)
        for item in scene.objects:
            self._add_object(scene, item)
        self._add_links(robot, scene)
        _reject_too_many(len(self._bodies))
        ignored = connected_links(robot) | {
            frozenset(self._valid_names(pair)) for pair in scene.ignored
        }
        ignored |= {pair - {WORLD} | {GROUND} for pair in ignored if WORLD in pair}
        if not scene.self_collision:
            ignored |= self._within_robots()
        self._ignore_pairs(ignored)
        reported = self._valid_names(scene.reported)
        rows = {name: k for k, name in enumerate(reported)}
        self._reported = len(rows)
        self._rows = {shape: rows.get(name, len(rows)) for shape, name in self._owners.items()}
        self._watch = SpeedWatch(list(self._bodies.values()), ignored, self._step)

    def _add_ground(self, scene: Scene, height: float) -> None:
        import dartpy

        assert scene.ground is not None
        shape = Box((_GROUND_EDGE, _GROUND_EDGE, _GROUND_DEPTH))
        pose = Pose((0.0, 0.0, height - 0.5 * _GROUND_DEPTH))
        rough = surface(scene, scene.ground.friction, scene.ground.restitution)
        self._add(GROUND, dartpy.dynamics.Skeleton(GROUND), shape, pose, rough)

    def _add_object(self, scene: Scene, item: SceneObject) -> None:
        import dartpy

        if item.name in self._bodies or item.name in (WORLD, GROUND):
            raise InputError(
                f"the object name {item.name!r} is already used; give every object a unique name"
            )
        dart = dartpy.dynamics.Skeleton(item.name)
        rough = surface(scene, item.friction, item.restitution)
        solid = self._add(item.name, dart, item.shape, item.pose, rough, moves=item.moves)
        if item.moves:
            body = dart.getBodyNode(0)
            (xx, xy, xz), (_, yy, yz), (_, _, zz) = item.mass * solid.gyration
            body.setMass(item.mass)
            body.setLocalCOM(solid.com)
            body.setMomentOfInertia(xx, yy, zz, xy, xz, yz)
            self._objects.append((item, dart))

    def _add(
        self, name: str, dart: Any, shape: Shape, pose: Pose, rough: Surface, *, moves: bool = False
    ) -> SolidShape:
        """Add a body with one shape that is free or fixed to the world."""
        import dartpy

        if moves:
            _, body = dart.createFreeJointAndBodyNodePair()
        else:
            joint, body = dart.createWeldJointAndBodyNodePair()
            joint.setTransformFromParentBodyNode(dartpy.math.Isometry3(transform(pose)))
        body.setName(name)
        solid = solid_shape(shape)
        self._owners[attach(body, solid, Pose(), rough)] = name
        self._bodies[name] = WatchedBody(name, body, ((solid, Pose()),), moves)
        self._dart.addSkeleton(dart)
        return solid

    def _add_links(self, robot: Robot, scene: Scene) -> None:
        shapes: dict[str, list[tuple[SolidShape, Pose]]] = {}
        for shape in link_shapes(robot, scene):
            if shape.link in self._bodies:
                raise InputError(f"object {shape.link!r} has the name of a link; rename it")
            mine = shapes.setdefault(shape.link, [])
            solid, body = solid_shape(shape.shape), self._skeleton.bodies[shape.link]
            rough = surface(scene, shape.friction, shape.restitution)
            self._owners[attach(body, solid, shape.pose, rough)] = shape.link
            mine.append((solid, shape.pose))
        for link, solids in shapes.items():
            body = self._skeleton.bodies[link]
            moves = body.getNumDependentGenCoords() > 0
            self._bodies[link] = WatchedBody(link, body, tuple(solids), moves)

    def _valid_names(self, names: tuple[str, ...]) -> tuple[str, ...]:
        """Return the names after checking that all are names of bodies that collide."""
        for name in names:
            if name not in self._bodies:
                raise UnknownNameError("link or object that collides", name, self._bodies)
        return names

    def _within_robots(self) -> set[frozenset[str]]:
        """Return all pairs of links of the same kinematic tree."""
        members: dict[str, list[str]] = {}
        for name, watched in self._bodies.items():
            if name in self._skeleton.bodies:
                members.setdefault(watched.body.getSkeleton().getName(), []).append(name)
        return {
            frozenset((a, b)) for tree in members.values() for a in tree for b in tree if a != b
        }

    def _ignore_pairs(self, ignored: set[frozenset[str]]) -> None:
        for dart in self._skeleton.darts:
            dart.enableSelfCollisionCheck()
        passing = self._dart.getConstraintSolver().getCollisionOption().collisionFilter
        for pair in ignored:
            if all(name in self._bodies for name in pair):
                passing.addBodyNodePairToBlackList(*(self._bodies[name].body for name in pair))

    def _reject_far_bodies(self) -> None:
        """Reject bodies that are so far away that ODE would abort the process."""
        for name, watched in self._bodies.items():
            away = float(np.abs(watched.body.getWorldTransform().translation()).max())
            if not away <= MAX_DISTANCE:
                problem = f"{name!r} is {away:.3g} m away at the start; contacts are detected"
                raise InputError(f"{problem} only within {MAX_DISTANCE:g} m")

    def _reject_overlap(self) -> None:
        import dartpy

        result = dartpy.collision.CollisionResult()
        option = self._dart.getConstraintSolver().getCollisionOption()
        self._dart.checkCollision(option, result)
        for contact in read_contacts(result, self._owners):
            if contact.depth > _MAX_OVERLAP:
                raise InputError(
                    f"{contact.first!r} and {contact.second!r} overlap by {contact.depth:.3g} m at "
                    "the start; move one of them, or add both to `ignored`"
                )


def _empty_world(robot: Robot, step: float) -> Any:
    """Create a DART world in which resting bodies are not deactivated."""
    import dartpy

    world = dartpy.simulation.World()
    options = world.getDeactivationOptions()
    options.mEnabled = False
    world.setDeactivationOptions(options)
    world.setTimeStep(step)
    world.setGravity(np.array(robot.gravity))
    return world


def _cone_solver() -> Any:
    """Create the solver for friction cones, nonsmooth Gauss-Seidel.

    The other solver for cones in DART does not converge for a stack in the same time, so that the
    stack creeps.
    """
    import dartpy

    options = dartpy.constraint.NsgsFrictionSolver.Options()
    options.maxSweeps, options.tolerance = _SWEEPS, _TOLERANCE
    return dartpy.constraint.NsgsFrictionSolver(options)


def _place(dart: Any, item: SceneObject) -> None:
    """Set an object to its initial pose and velocity."""
    import dartpy

    T = dartpy.math.Isometry3(transform(item.pose))
    joint = dart.getJoint(0)
    dart.resetAccelerations()
    dart.setPositions(joint.convertToPositions(T))
    joint.setAngularVelocity(np.array(item.angular_velocity))
    joint.setLinearVelocity(np.array(item.velocity))


def _pose(dart: Any) -> FloatArray:
    T = dart.getBodyNode(0).getWorldTransform()
    turn = T.quaternion()
    quaternion = np.array([turn.w(), turn.x(), turn.y(), turn.z()])
    return np.concatenate([T.translation(), quaternion if turn.w() >= 0 else -quaternion])


def _reject_too_many(bodies: int) -> None:
    """Reject a world with too many bodies for checking all pairs."""
    if bodies > limits.BODIES:
        problem = f"{bodies} bodies can collide, more than the maximum of {limits.BODIES}"
        raise InputError(f"{problem}; remove objects or collision shapes of links")
