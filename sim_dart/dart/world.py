"""The world of a robot in DART: ground, objects, contacts.

Contacts are found by ODE, which alone of DART's engines rests, slides and bounces spheres, boxes,
capsules, cylinders and meshes as they are: FCL makes spheres of capsules, DART's own lets meshes
fall through one another, Bullet makes sliding cylinders and meshes spin. DART computes a contact's
force without the damping of joints, which makes the force of a link pressed by a damped joint too
small by h d / m. A body that hits another at the speed v is up to v h deep in it after that step,
and comes out by 1 mm/s.
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

from .collision_pairs import connected
from .contacts import Contact, contact_forces, read_contacts
from .link_shapes import link_shapes
from .shapes import SolidShape, Surface, attach, solid_shape, surface
from .skeleton import Skeleton
from .tunnelling import SpeedWatch, WatchedBody

_GROUND_EDGE, _GROUND_DEPTH = 1000.0, 10.0  # in [m]
_MAX_OVERLAP = 1e-3  # in [m]: bodies deeper in each other would fly apart at the start
_SWEEPS, _TOLERANCE = 200, 1e-6  # of the solver with friction cones


class World:
    """A scene and a robot in it, in DART.

    Args:
        skeleton: The robot in DART.
        robot: The robot.
        step: Length of a step, in [s].
        scene: Ground, objects and shapes of links; None for no collisions at all.

    Raises:
        InputError: The scene does not fit the robot, or a mesh cannot be used.
        UnknownNameError: The scene names a link or object that does not exist.

    Attributes:
        step: One step. Raises SimulationError when an object is lost, or moves so fast that it
            could pass through another.
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
        """Whether there can be contacts."""
        return bool(self._bodies)

    @property
    def time(self) -> float:
        """Time for messages, in [s]."""
        return float(self._dart.getTime())

    @time.setter
    def time(self, value: float) -> None:
        self._dart.setTime(value)

    def reset(self) -> None:
        """Put the objects at their start, with the robot at its own.

        Raises:
            InputError: Two bodies are deep in each other, or one is far away.
        """
        for item, dart in self._objects:
            _place(dart, item)
        if self._cones is not None:
            self._cones.resetStats()
        if self.has_contacts:
            self._refuse_far()
            self._refuse_overlap()

    def contacts(self) -> list[Contact]:
        """Return every point of contact, with its force, as of the last step."""
        return read_contacts(self._dart.getLastCollisionResult(), self._owners)

    def contact_forces(self) -> FloatArray:
        """The sum of the contacts' forces on each reported body, shape (k, 3), world axes, in [N].

        Forces of the last step: those that act from its beginning to its end.
        """
        return contact_forces(self._dart.getLastCollisionResult(), self._rows, self._reported)

    def take_friction_error(self) -> FloatArray:
        """How well Coulomb's law was solved for since this was last asked, with friction cones.

        Returns:
            The largest speed by which a contact breaks the law, in [m/s]; and 1 where a step's
            contact forces did not converge to 1e-6 m/s, 0 else. Shape (2,); (0,) with pyramids,
            whose solver does not tell. DART's solver of pyramids follows where this one gives no
            answer, and is not in the speed.
        """
        if self._cones is None:
            return np.empty(0)
        stats = self._cones.getStats()
        self._cones.resetStats()
        return np.array([stats.maxViolation, stats.numConverged < stats.numSolves], np.float64)

    def object_poses(self) -> FloatArray:
        """Position and orientation of the objects that move, shape (k, 7).

        x, y, z in [m], and the unit quaternion w, x, y, z of the rotation, w not negative.
        """
        return np.array([_pose(dart) for _, dart in self._objects]).reshape(-1, 7)

    def get_state(self) -> FloatArray:
        """Return positions and velocities of the objects that move, shape (12 k,)."""
        return np.array(
            [[*dart.getPositions(), *dart.getVelocities()] for _, dart in self._objects]
        ).reshape(-1)

    def set_state(self, state: FloatArray) -> None:
        """Go back to a state from `get_state`."""
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
                f"steps; use a plant step of {fast.step:.2g} s or less"
            )
        self._dart.step()
        for item, dart in self._objects:
            state = np.concatenate([dart.getPositions(), dart.getVelocities()])
            if not np.abs(state).max() < MAX_DISTANCE:
                self._refuse_lost(item, state)

    def _refuse_lost(self, item: SceneObject, state: FloatArray) -> None:
        where = ", ".join(f"{value:.3g}" for value in state[3:6])
        raise SimulationError(
            f"at t = {self.time:.6g} s object {item.name!r} is at ({where}) m with a velocity of "
            f"{np.linalg.norm(state[9:]):.3g} m/s: it left the simulated space; use a smaller "
            "step, or place it clear of other bodies"
        )

    def _add_scene(self, robot: Robot, scene: Scene) -> None:
        import dartpy

        _refuse_many(len(scene.objects))
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
        _refuse_many(len(self._bodies))
        ignored = connected(robot) | {frozenset(self._known(pair)) for pair in scene.ignored}
        ignored |= {pair - {WORLD} | {GROUND} for pair in ignored if WORLD in pair}
        if not scene.self_collision:
            ignored |= self._within_robots()
        self._let_pass(ignored)
        reported = self._known(scene.reported)
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
        """Add a body of one shape, free to move or fixed to the world."""
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

    def _known(self, names: tuple[str, ...]) -> tuple[str, ...]:
        """Return the names, if all are of bodies that collide."""
        for name in names:
            if name not in self._bodies:
                raise UnknownNameError("link or object that collides", name, self._bodies)
        return names

    def _within_robots(self) -> set[frozenset[str]]:
        """Return all pairs of links of one tree."""
        members: dict[str, list[str]] = {}
        for name, watched in self._bodies.items():
            if name in self._skeleton.bodies:
                members.setdefault(watched.body.getSkeleton().getName(), []).append(name)
        return {
            frozenset((a, b)) for tree in members.values() for a in tree for b in tree if a != b
        }

    def _let_pass(self, ignored: set[frozenset[str]]) -> None:
        for dart in self._skeleton.darts:
            dart.enableSelfCollisionCheck()
        passing = self._dart.getConstraintSolver().getCollisionOption().collisionFilter
        for pair in ignored:
            if all(name in self._bodies for name in pair):
                passing.addBodyNodePairToBlackList(*(self._bodies[name].body for name in pair))

    def _refuse_far(self) -> None:
        """Reject what the search for contacts ends the process with."""
        for name, watched in self._bodies.items():
            away = float(np.abs(watched.body.getWorldTransform().translation()).max())
            if not away <= MAX_DISTANCE:
                what = f"{name!r} is {away:.3g} m away at the start; contacts are found"
                raise InputError(f"{what} within {MAX_DISTANCE:g} m")

    def _refuse_overlap(self) -> None:
        import dartpy

        result = dartpy.collision.CollisionResult()
        option = self._dart.getConstraintSolver().getCollisionOption()
        self._dart.checkCollision(option, result)
        for contact in read_contacts(result, self._owners):
            if contact.depth > _MAX_OVERLAP:
                raise InputError(
                    f"{contact.first!r} and {contact.second!r} overlap by {contact.depth:.3g} m at "
                    "the start; move one, or ignore contacts between them (ignored)"
                )


def _empty_world(robot: Robot, step: float) -> Any:
    """Return a DART world; resting bodies are never put to sleep."""
    import dartpy

    world = dartpy.simulation.World()
    options = world.getDeactivationOptions()
    options.mEnabled = False
    world.setDeactivationOptions(options)
    world.setTimeStep(step)
    world.setGravity(np.array(robot.gravity))
    return world


def _cone_solver() -> Any:
    """Nonsmooth Gauss-Seidel.

    DART's other solver for cones does not converge for a stack in so much time, and lets it creep.
    """
    import dartpy

    options = dartpy.constraint.NsgsFrictionSolver.Options()
    options.maxSweeps, options.tolerance = _SWEEPS, _TOLERANCE
    return dartpy.constraint.NsgsFrictionSolver(options)


def _place(dart: Any, item: SceneObject) -> None:
    """Put an object where it starts."""
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


def _refuse_many(bodies: int) -> None:
    """Reject a world all pairs of whose bodies could not be looked at."""
    if bodies > limits.BODIES:
        what = f"{bodies} bodies can touch one another, more than {limits.BODIES}"
        raise InputError(f"{what}; remove objects or collision shapes of links")
