"""Catalogue of the features of robots, in the order of the table in the documentation."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Container, Iterable, Iterator
from typing import Any

from ..finding import Subject
from ..finding_builders import listed
from ..model.joint import Coordinate, Joint
from ..model.loop import LOOP_TYPES
from ..model.muscle import Muscle, ViaPoint, Wrap, WrapSurface
from ..model.pose import IDENTITY
from ..model.robot import DEFAULT_SET, GRAVITY, MARKERS, Link, Robot
from .capability import Feature, FeaturePlace, Finder, Row, omitted, rejected

UNNAMED = ("", DEFAULT_SET, MARKERS)
"""Names that readers assign to sets without a name."""


Words = dict[str, object]


def of_links(has: Callable[[Link], Any]) -> Finder:
    """Return a finder of the links that have a feature.

    Args:
        has: Function that returns whether a link has the feature. A returned dictionary defines
            the placeholders of the message. A returned tuple defines `{count}` by its length.
    """
    return lambda robot: _find_places("link", robot.links, has)


def of_joints(has: Callable[[Joint], Any]) -> Finder:
    """Return a finder of the joints that have a feature; see `of_links`."""
    return lambda robot: _find_places("joint", robot.joints, has)


def of_coordinates(has: Callable[[Coordinate], Any]) -> Finder:
    """Return a finder of coordinates, also locked and coupled ones; see `of_links`."""
    return lambda robot: _find_places("coordinate", robot.all_coordinates, has)


def of_muscles(has: Callable[[Muscle], Any]) -> Finder:
    """Return a finder of muscles of the active cable set; see `of_links`."""
    return lambda robot: _find_places("muscle", robot.muscles, has)


def of_robot(has: Callable[[Robot], Any]) -> Finder:
    """Return a finder that tests the whole robot; a returned list defines `{names}`."""
    return lambda robot: _find_places("robot", [robot], has)


def of_surfaces(has: Callable[[WrapSurface], Any]) -> Finder:
    """Return a finder of the wrap surfaces that have a feature; see `of_links`."""
    return lambda robot: _find_places("wrap_surface", robot.wrap_surfaces, has)


def of_cylinders(has: Callable[[float], bool]) -> Finder:
    """Return a finder that reports the robot once per cylinder with such a length."""

    def find(robot: Robot) -> Iterator[FeaturePlace]:
        for surface in robot.wrap_surfaces:
            if surface.shape == "cylinder" and has(surface.length):
                yield FeaturePlace(Subject("robot", robot.name), {"surface": surface.name})

    return find


def _find_places(
    kind: str, items: Iterable[Any], has: Callable[[Any], Any]
) -> Iterator[FeaturePlace]:
    for item in items:
        answer = has(item)
        if answer:
            yield FeaturePlace(Subject(kind, item.name), _words(answer))


def _words(answer: object) -> dict[str, object]:
    if isinstance(answer, dict):
        return answer
    if isinstance(answer, list):
        return {"names": listed(answer, len(answer))}
    return {"count": len(answer)} if isinstance(answer, tuple) else {}


def points_of_muscles(has: Callable[[ViaPoint], Any]) -> Finder:
    """Return a finder of muscles with such via points; `{places}` counts them from 1."""

    def test(muscle: Muscle) -> Words:
        numbers = [str(k) for k, point in enumerate(muscle.via_points, 1) if has(point)]
        return {"places": ", ".join(numbers)} if numbers else {}

    return of_muscles(test)


def of_wraps(has: Callable[[Wrap], Any]) -> Finder:
    """Return a finder of such wraps; it reports the muscle once per wrap."""

    def find(robot: Robot) -> Iterator[FeaturePlace]:
        for muscle in robot.muscles:
            for wrap in muscle.wraps:
                if has(wrap):
                    words = {"surface": wrap.surface, "turns": wrap.turns}
                    yield FeaturePlace(Subject("muscle", muscle.name), words)

    return find


def other_laws(laws: Collection[str]) -> Finder:
    """Return a finder of muscles whose muscle law is neither `ideal` nor one of `laws`."""
    return of_muscles(
        lambda m: m.model.kind != "ideal" and m.model.kind not in laws and {"kind": m.model.kind}
    )


LINKS = Feature("links and their inertias", of_links(lambda link: True))
FIXED_JOINTS = Feature(
    "fixed joints",
    of_joints(lambda j: j.type == "fixed" and {"child": j.child, "parent": j.parent}),
)
CHAINS = Feature(
    "joints with several motions",
    of_joints(lambda joint: order(joint) if len(joint.motions) > 1 else {}),
    "joint-in-a-chain",
    "{format} represents its {count} motions as separate joints, connected by massless links; "
    "their order is {order}",
)
DRIVEN_JOINTS = Feature(
    "functions of coordinates, couplings and locks",
    of_joints(lambda joint: not joint.is_plain),
    "driven-joint",
    "{format} is not written with coupled or locked coordinates, or with motions that follow "
    "functions of coordinates; write sdf, or lock its coordinates at a value",
)
LINK_FRAMES = Feature(
    "link frames that differ from joint frames",
    of_joints(lambda j: j.T_child_joint != IDENTITY and {"child": j.child}),
)
JOINT_NAMES = Feature(
    "joint names that differ from coordinate names",
    of_robot(lambda robot: joint_names(robot)),
    "names-left-out",
    "{format} uses the names of coordinates as names of joints; {names} omitted",
)
LOOPS = Feature(
    "loop joints",
    of_robot(lambda robot: other_loops(robot, ())),
    "loop-left-out",
    "{format} has no such loop joints; omitted, so that these loops are open: {names}",
)
GRAVITIES = Feature(
    "gravity other than standard gravity",
    of_robot(lambda robot: robot.gravity != GRAVITY and {"gravity": robot.gravity}),
)
MESHES = Feature("meshes", of_links(lambda link: link.meshes))
MESH_NAMES = Feature(
    "names of meshes",
    of_links(lambda link: any(mesh.name for mesh in link.meshes)),
    "mesh-names-left-out",
    "{format} numbers its meshes; their names are omitted",
)
COLLISIONS = Feature(
    "collision shapes and meshes",
    of_links(lambda link: link.shapes or any(mesh.role == "collision" for mesh in link.meshes)),
)
LINK_ENDS = Feature(
    "far ends of links",
    of_robot(lambda robot: any(link.end is not None for link in robot.links)),
    "link-ends-left-out",
    "{format} does not hold the far ends of links; they are used for drawing only",
)
INITIAL_VALUES = Feature("initial values", of_coordinates(lambda c: c.initial))
LIMITS = Feature(
    "limits of coordinates",
    of_coordinates(lambda c: c.is_limited),
)
DAMPING = Feature("damping", of_coordinates(lambda c: c.damping))
SPRINGS = Feature("springs", of_coordinates(lambda c: c.stiffness))
FRICTION = Feature(
    "Coulomb friction in joints", of_coordinates(lambda c: c.friction), "friction-left-out"
)
ARMATURES = Feature("armatures", of_coordinates(lambda c: c.armature), "armature-left-out")
LIMIT_FORCES = Feature(
    "limit forces", of_coordinates(lambda c: c.limit_force), "limit-force-left-out"
)
MOTORS = Feature("motors of joints", of_coordinates(lambda c: c.actuated))
MOTOR_BOUNDS = Feature(
    "motor limits",
    of_coordinates(lambda c: (c.tau_min, c.tau_max) != (-math.inf, math.inf)),
    "motor-bounds-left-out",
)
BOUNDS_WITHOUT_MOTOR = Feature(
    "motor limits of joints without motors",
    of_coordinates(
        lambda c: not c.actuated and c.is_free and (c.tau_min, c.tau_max) != (-math.inf, math.inf)
    ),
    "motor-bounds-left-out",
    "{format} requires a motor for motor limits, and the joint has no motor; omitted",
)
VELOCITY_LIMITS = Feature(
    "velocity limits",
    of_coordinates(lambda c: c.max_velocity < math.inf),
    "velocity-limit-left-out",
)
LINK_AND_JOINT_FEATURES = tuple(v for v in list(globals().values()) if isinstance(v, Feature))
"""The features of links and joints."""

MUSCLES = Feature("muscles", of_robot(lambda robot: robot.cable_sets))
MUSCLE_LAWS = Feature(
    "muscle laws",
    other_laws(()),
    "cable-model-left-out",
    "{format} has no muscle law {kind!r}; written as an ideal cable",
)
IDEAL_PARAMETERS = Feature(
    "parameters of ideal cables",
    of_muscles(
        lambda m: (
            m.model.kind == "ideal"
            and m.model.parameters
            and {"given": ", ".join(name for name, _ in m.model.parameters)}
        )
    ),
    "cable-parameters-left-out",
    "{format} has no {given} of a cable; omitted",
)
PULLEYS = Feature(
    "swivelling pulleys",
    of_muscles(lambda m: m.pulley is not None),
    "pulley-left-out",
    "{format} has no swivelling pulley; its fixed location is a via point",
)
CABLE_FRICTION = Feature(
    "cable friction",
    of_muscles(lambda m: m.friction or m.bend_friction),
    "cable-friction-left-out",
)
CONDITIONS = Feature(
    "via points that are active only at times",
    points_of_muscles(lambda point: point.when is not None),
    "point-condition-left-out",
    "{format} has no {feature}; always active: {places}",
)
MOVING_POINTS = Feature(
    "points that move on their links",
    points_of_muscles(lambda point: point.moves),
    "point-motion-left-out",
    "{format} has no {feature}; fixed to their links: {places}",
)
BRANCHES = Feature(
    "branches of tendons",
    of_muscles(lambda m: m.branches),
    "branches-left-out",
    "{format} has no {feature}; the path is written as a single piece",
)
TERMS = Feature(
    "lengths proportional to coordinates", of_muscles(lambda m: m.terms), "terms-left-out"
)
WRAPS = Feature("wraps over surfaces", of_muscles(lambda m: m.wraps))
WRAP_SURFACES = Feature("wrap surfaces", of_surfaces(lambda surface: True))
ELLIPSOIDS = Feature(
    "ellipsoids as wrap surfaces",
    of_surfaces(lambda surface: surface.shape == "ellipsoid"),
    "ellipsoid-left-out",
    "{format} has no ellipsoids as wrap surfaces; omitted with its wraps",
)
_RULES = "{format} has no {feature}; it uses its native wrapping rules over {names}"
OPENSIM_WRAPS = Feature(
    "wraps by OpenSim's rules",
    of_muscles(lambda m: _surfaces_by_rule(m, "opensim")),
    "wrap-rule-left-out",
    _RULES,
)
MUJOCO_WRAPS = Feature(
    "wraps by MuJoCo's rules",
    of_muscles(lambda m: _surfaces_by_rule(m, "mujoco")),
    "wrap-rule-left-out",
    _RULES,
)
CABLE_SETS = Feature(
    "several cable sets",
    of_robot(lambda r: [group.name for group in r.cable_sets if group.name != r.cable_set]),
    "cable-sets-left-out",
    "{format} holds one cable set; omitted: {names}",
)
TASK_SETS = Feature(
    "several operational spaces",
    of_robot(lambda r: [group.name for group in r.task_sets if group.name != r.task_set]),
    "task-sets-left-out",
    "{format} holds one operational space; omitted: {names}",
)
SET_NAMES = Feature(
    "names of sets",
    of_robot(lambda r: [name for name in (r.cable_set, r.task_set) if name not in UNNAMED]),
    "names-left-out",
    "{format} does not name sets; {names} omitted",
)
TASK_FRAMES = Feature("task frames", of_robot(lambda robot: robot.task_sets))
TASK_AXES = Feature(
    "axes of task frames",
    of_robot(lambda robot: robot.task_set != MARKERS and robot.task_frames),
    "task-axes-left-out",
    "{format} holds the points of the task frames, but neither their order nor their active axes",
)

TERMS_OMITTED = (
    omitted(TERMS, find=of_muscles(lambda m: m.terms and m.via_points), only="next to a path"),
    rejected(
        TERMS,
        message="{format} has no {feature}; add via points",
        find=of_muscles(lambda m: m.terms and not m.via_points),
        only="without a path",
    ),
)
"""Rows for formats without such terms; a muscle that has only terms is rejected."""

NOT_IN_OTHER_SIMULATORS = tuple(
    omitted(feature)
    for feature in (
        IDEAL_PARAMETERS,
        PULLEYS,
        CABLE_FRICTION,
        TASK_AXES,
        LINK_ENDS,
        CABLE_SETS,
        TASK_SETS,
        SET_NAMES,
    )
)
"""Rows for features that neither MuJoCo nor OpenSim has."""


def laws_except(laws: Collection[str]) -> Row:
    """Return the row for a format that has only the law `ideal` and the muscle laws `laws`."""
    return omitted(MUSCLE_LAWS, find=other_laws(laws), only="except " + ", ".join(laws))


def loops_except(supported: Container[str]) -> Row:
    """Return the row for a format that closes loops only with the joint types in `supported`."""
    return omitted(
        LOOPS,
        find=of_robot(lambda robot: other_loops(robot, supported)),
        only=", ".join(kind for kind in LOOP_TYPES if kind not in supported),
    )


CATALOGUE = tuple(value for value in list(globals().values()) if isinstance(value, Feature))
"""All features."""
MUSCLE_AND_TASK_FEATURES = CATALOGUE[len(LINK_AND_JOINT_FEATURES) :]
"""The features of muscles, wrap surfaces and operational spaces."""


def has_limits(robot: Robot) -> bool:
    """Return whether any free coordinate of the robot has a limit."""
    return any(c.is_limited for c in robot.coordinates)


def order(joint: Joint) -> Words:
    """Return the number of motions of a joint and their order, as placeholders of messages."""
    moved = (motion for motion in joint.motions if not motion.is_fixed)
    order = ", ".join(joint.coordinates[motion.coordinate].name for motion in moved)
    return {"count": len(joint.motions), "order": order}


def joint_names(robot: Robot) -> list[str]:
    """Return the names of joints that are not the name of one of their coordinates."""
    return [
        joint.name
        for joint in robot.joints
        if joint.name not in [coordinate.name for coordinate in joint.coordinates]
    ]


def _surfaces_by_rule(muscle: Muscle, rule: str) -> list[str]:
    """Return the wrap surfaces of the wraps that follow the rules of a program."""
    return [wrap.surface for wrap in muscle.wraps if wrap.rule == rule]


def other_loops(robot: Robot, supported: Container[str]) -> list[str]:
    """Return the loop joints whose type is not in `supported`."""
    return [f"{loop.name} ({loop.type})" for loop in robot.loops if loop.type not in supported]
