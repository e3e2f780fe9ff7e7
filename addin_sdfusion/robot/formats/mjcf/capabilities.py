"""Features that MJCF holds; robots that MuJoCo cannot load are rejected."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

from ...finding import Finding, Subject
from ...formats import features
from ...model.joint import Coordinate
from ...model.muscle import Muscle, Wrap
from ...model.robot import Inertia, Link, Robot
from ..capability import Capabilities, FeaturePlace, Finder, Row, changed, kept, omitted, rejected
from ..features import Words, of_coordinates, of_cylinders, of_links, of_muscles, of_robot
from ..writing import wrap_ends
from ..writing.plain_paths import with_markers
from .write_bodies import MAX_NESTED, MotionJoint, chains_too_deep, coordinate_order, motion_joints
from .write_constraints import LOOPS, STEP, has_friction, is_supported
from .write_inertia import missing_inertia, written_inertias
from .write_muscles import LAWS
from .write_tendons import first_wraps

PATH_FEATURES = ("branches", "terms")
"""Path features that MuJoCo's tendons support."""

MeshFiles = Mapping[str, str | Path]


def mjcf_losses(robot: Robot, meshes: MeshFiles | None = None) -> list[Finding]:
    """Return findings on what MJCF cannot hold; errors if MuJoCo would reject the file."""
    rows = (*MJCF.rows, *mesh_rows(meshes or {}))
    return Capabilities(MJCF.title, rows).losses(with_markers(robot))


def mesh_rows(files: MeshFiles) -> tuple[Row, ...]:
    """Return the rows on meshes, given the files that MuJoCo can open."""

    def meshes(*, opened: bool) -> Finder:
        def find(robot: Robot) -> Iterator[FeaturePlace]:
            for link in robot.links:
                for mesh in link.meshes:
                    if (mesh.uri in files) == opened and (not opened or mesh.role == "collision"):
                        yield FeaturePlace(Subject("link", link.name), {"uri": mesh.uri})

        return find

    return (
        omitted(
            features.MESHES,
            "mesh-left-out",
            "MuJoCo cannot read {uri!r}, or the file does not exist; omitted",
            meshes(opened=False),
            only="except .obj and binary .stl in the robot folder",
        ),
        changed(
            features.COLLISIONS,
            "collisions-off",
            "collisions of mesh {uri!r} are disabled, as in this simulation",
            meshes(opened=True),
        ),
    )


def _coordinates_without_joint(robot: Robot) -> Iterator[FeaturePlace]:
    motions_of = motion_joints(robot)
    for joint in robot.joints:
        homes = {
            motion_joint.coordinate.name
            for motion_joint in motions_of[joint.name]
            if motion_joint.is_home
        }
        for c in joint.coordinates:
            if c.name not in homes:
                yield FeaturePlace(Subject("joint", joint.name), {"coordinate": c.name})


def _unsupported_functions(robot: Robot) -> Iterator[FeaturePlace]:
    """Report couplings and motions whose functions MuJoCo does not support."""
    for c in robot.all_coordinates:
        functions = [term.function for term in c.coupling]
        if len(functions) > 1 or not all(map(is_supported, functions)):
            yield FeaturePlace(Subject("coordinate", c.name))
    for joint, followers in _following_motions(robot):
        if not _are_supported(followers):
            yield FeaturePlace(Subject("joint", joint))


def _motions_as_joints(robot: Robot) -> Iterator[FeaturePlace]:
    for joint, followers in _following_motions(robot):
        if _are_supported(followers):
            names = ", ".join(repr(motion_joint.name) for motion_joint in followers)
            yield FeaturePlace(Subject("joint", joint), {"names": names})


def _following_motions(robot: Robot) -> Iterator[tuple[str, list[MotionJoint]]]:
    """Yield each joint with the motions that follow one of its coordinates, if any."""
    for joint, motions in motion_joints(robot).items():
        followers = [m for m in motions if m.name and not m.is_home]
        if followers:
            yield joint, followers


def _are_supported(followers: list[MotionJoint]) -> bool:
    return all(is_supported(motion_joint.motion.function) for motion_joint in followers)


def _is_soft(robot: Robot) -> bool:
    return any(c.coupling or c.locked for c in robot.all_coordinates)


def _different_order(robot: Robot) -> Words:
    order = [
        motion_joint.coordinate for motion_joint in coordinate_order(robot) if motion_joint.is_home
    ]
    names = ", ".join(coordinate.name for coordinate in order)
    return {} if order == list(robot.all_coordinates) else {"order": names}


def _of_inertias(has: Callable[[Inertia, Inertia], Any]) -> Finder:
    """Return a finder of links by their inertia and the inertia in MJCF; see `of_links`."""

    def find(robot: Robot) -> Iterator[FeaturePlace]:
        in_mjcf = {link.name: inertia for link, inertia in written_inertias(robot)}
        find_links = of_links(
            lambda link: link.name in in_mjcf and has(link.inertia, in_mjcf[link.name])
        )
        yield from find_links(robot)

    return find


def _muscle_limits(muscle: Muscle) -> bool:
    return muscle.model.kind in LAWS and (muscle.f_min > 0.0 or muscle.f_max < math.inf)


def _equal_bounds(muscle: Muscle) -> Words:
    are_equal = muscle.model.kind not in LAWS and muscle.f_min == muscle.f_max
    return {"force": muscle.f_min} if are_equal else {}


def _equal_torques(c: Coordinate) -> Words:
    are_equal = c.actuated and c.is_free and c.tau_min == c.tau_max
    return {"torque": c.tau_min} if are_equal else {}


def _wraps(robot: Robot, *, first: bool) -> Iterator[tuple[Muscle, Wrap]]:
    """Yield the first wraps of all segments, or all other wraps."""
    for muscle in robot.muscles:
        firsts = first_wraps(muscle).values()
        yield from ((muscle, wrap) for wrap in muscle.wraps if (wrap in firsts) == first)


def _second_wraps(robot: Robot) -> Iterator[FeaturePlace]:
    for muscle, wrap in _wraps(robot, first=False):
        yield FeaturePlace(Subject("muscle", muscle.name), {"surface": wrap.surface})


def _whole_turns(robot: Robot) -> Iterator[FeaturePlace]:
    for muscle, wrap in _wraps(robot, first=True):
        if wrap.turns:
            words = {"turns": wrap.turns, "surface": wrap.surface}
            yield FeaturePlace(Subject("muscle", muscle.name), words)


def _chosen_sides(robot: Robot) -> Iterator[FeaturePlace]:
    for muscle, wrap in _wraps(robot, first=True):
        if wrap.side and not wrap.turns:  # in MuJoCo a site inside the surface means an inner path
            yield FeaturePlace(Subject("muscle", muscle.name), {"surface": wrap.surface})


def _shapes(link: Link) -> Words:
    return {"count": len(link.shapes)} if link.shapes else {}


MJCF = Capabilities(
    "MJCF",
    (
        kept(features.LINKS, features.FIXED_JOINTS, features.CHAINS, features.LINK_FRAMES),
        kept(features.GRAVITIES, features.MESHES, features.MESH_NAMES, features.COLLISIONS),
        kept(features.INITIAL_VALUES, features.DAMPING, features.SPRINGS, features.ARMATURES),
        kept(features.MOTORS, features.MOTOR_BOUNDS, features.MUSCLES, features.BRANCHES),
        kept(features.TERMS, features.WRAPS, features.WRAP_SURFACES, features.MUJOCO_WRAPS),
        kept(features.TASK_FRAMES),
        rejected(
            features.DRIVEN_JOINTS,
            "driven-joint",
            "no joint in MuJoCo can represent coordinate {coordinate!r} directly; write sdf",
            _coordinates_without_joint,
            only="without a motion that is the coordinate",
        ),
        rejected(
            features.DRIVEN_JOINTS,
            "driven-joint",
            "MuJoCo couples joints only in pairs, by polynomials of degree 4; write sdf",
            _unsupported_functions,
            only="other than by polynomials of degree 4 of one coordinate",
        ),
        changed(
            features.DRIVEN_JOINTS,
            "motion-as-joint",
            "motions that follow a coordinate become separate joints: {names}",
            _motions_as_joints,
            only="others",
        ),
        changed(
            features.DRIVEN_JOINTS,
            "soft-equalities",
            "equalities in MuJoCo are soft: coupled and locked joints deviate slightly",
            of_robot(_is_soft),
            only="others",
        ),
        features.loops_except(LOOPS),
        changed(
            features.LOOPS,
            "soft-loops",
            "loops in MuJoCo are soft: their equalities act as springs with dampers",
            of_robot(lambda robot: any(loop.type in LOOPS for loop in robot.loops)),
            only=", ".join(LOOPS),
        ),
        omitted(features.LIMIT_FORCES),
        rejected(
            "chains of more than 480 links",
            "too-many-nested",
            f"MuJoCo supports chains of at most {MAX_NESTED} links; this link exceeds the limit",
            chains_too_deep,
        ),
        rejected(
            "physically impossible inertias",
            "inertia-triangle",
            "MuJoCo rejects a principal moment of inertia above the sum of the other two; correct "
            "the inertia",
            _of_inertias(lambda inertia, _: missing_inertia(inertia) is None),
        ),
        changed(
            "moments of inertia that are zero",
            "inertia-increased",
            "MuJoCo requires positive moments of inertia; {by!r} kg·m² is added to each",
            _of_inertias(lambda inertia, _: (by := missing_inertia(inertia)) and {"by": by}),
        ),
        changed(
            "links without mass",
            "mass-increased",
            "MuJoCo requires positive masses; {mass!r} kg is used",
            _of_inertias(
                lambda inertia, in_mjcf: in_mjcf.mass != inertia.mass and {"mass": in_mjcf.mass}
            ),
        ),
        changed(
            features.LIMITS,
            "soft-stops",
            "MuJoCo's joint limits are soft: a joint that reaches one at v rad/s or m/s exceeds it "
            f"by up to v · {STEP:g} s and rebounds with up to 3 % of v; at rest by 1e-7",
            of_robot(features.has_limits),
        ),
        changed(
            features.FRICTION,
            "soft-friction",
            "MuJoCo's Coulomb friction is soft: a joint held by friction creeps by about 1e-8 rad "
            "or m per second",
            of_robot(has_friction),
        ),
        changed(
            "coordinates in a different order than bodies",
            "coordinate-order",
            "the order of the coordinates in MuJoCo differs: {order}",
            of_robot(_different_order),
        ),
        omitted(
            "force limits of MuJoCo muscles",
            "force-limits-left-out",
            "MuJoCo's muscles have no force limits; f_min and f_max omitted",
            of_muscles(_muscle_limits),
        ),
        omitted(
            "equal force limits",
            "force-limits-left-out",
            "MuJoCo does not support equal control limits; command {force!r} N",
            of_muscles(_equal_bounds),
        ),
        omitted(
            "equal motor limits",
            "force-limits-left-out",
            "MuJoCo does not support equal control limits; command {torque!r}",
            of_coordinates(_equal_torques),
        ),
        omitted(features.BOUNDS_WITHOUT_MOTOR),
        omitted(features.VELOCITY_LIMITS),
        omitted(features.CONDITIONS),
        omitted(features.MOVING_POINTS),
        omitted(
            features.TERMS,
            "terms-left-out",
            "MuJoCo's tendons have a path or lengths proportional to joints; the latter omitted",
            of_muscles(lambda muscle: muscle.terms and muscle.via_points),
            only="next to a path",
        ),
        omitted(features.ELLIPSOIDS),
        omitted(features.OPENSIM_WRAPS),
        changed(
            "cylinders with ends",
            "cylinder-ends-left-out",
            "MuJoCo's cylinders for wrapping have no ends; the ends of {surface!r} are ignored",
            of_cylinders(math.isfinite),
        ),
        omitted(
            features.WRAPS,
            "wrap-left-out",
            "MuJoCo supports one wrap per segment; the wrap over {surface!r} is omitted",
            _second_wraps,
            only="the second wrap of a segment",
        ),
        omitted(
            features.WRAPS,
            "turns-left-out",
            "MuJoCo does not support full turns; {turns} around {surface!r} omitted",
            _whole_turns,
            only="full turns",
        ),
        changed(
            features.WRAPS,
            "side-by-place",
            "a site selects the side of {surface!r} on which it passes; the site is placed for the "
            "initial coordinates",
            _chosen_sides,
            only="with a chosen side",
        ),
        *wrap_ends.rows("MuJoCo"),
        changed(
            features.COLLISIONS,
            "collisions-off",
            "collisions of its {count} shapes are disabled, as in this simulation",
            of_links(_shapes),
        ),
        features.laws_except(LAWS),
        *features.NOT_IN_OTHER_SIMULATORS,
        omitted(features.JOINT_NAMES),
    ),
)
