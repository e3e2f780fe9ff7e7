"""What MJCF holds: rejected is what MuJoCo does not load."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from pathlib import Path

from ...finding import Finding, Subject
from ...formats import features
from ...model.joint import Coordinate
from ...model.muscle import Muscle, Wrap
from ...model.robot import Link, Robot
from ..capability import Capabilities, Finder, Found, Row, changed, kept, left_out, refused
from ..features import Words, of_coordinates, of_links, of_muscles, of_robot
from ..writing import wrap_ends
from ..writing.plain_paths import with_markers
from .write_bodies import MAX_NESTED, Mover, coordinate_order, movers, too_deep
from .write_constraints import EQUALITIES, STEP, has_friction, is_held
from .write_inertia import missing, written_inertias
from .write_muscles import LAWS
from .write_tendons import first_wraps

HELD = ("branches", "terms")
"""What MuJoCo's tendons can depend on."""

MeshFiles = Mapping[str, str | Path]


def mjcf_losses(robot: Robot, meshes: MeshFiles | None = None) -> list[Finding]:
    """What MJCF cannot hold of a valid robot; errors where MuJoCo rejects it.

    Args:
        robot: A valid robot.
        meshes: As for `write_mjcf`.
    """
    rows = (*MJCF.rows, *mesh_rows(meshes or {}))
    return Capabilities(MJCF.title, rows).losses(with_markers(robot))


def mesh_rows(files: MeshFiles) -> tuple[Row, ...]:
    """What becomes of meshes, where some have files that MuJoCo opens."""

    def among(*, there: bool) -> Finder:
        def find(robot: Robot) -> Iterator[Found]:
            for link in robot.links:
                for mesh in link.meshes:
                    if (mesh.uri in files) == there and (not there or mesh.role == "collision"):
                        yield Found(Subject("link", link.name), {"uri": mesh.uri})

        return find

    return (
        left_out(
            features.MESHES,
            "mesh-left-out",
            "MuJoCo cannot read {uri!r}, or it does not exist; left out",
            among(there=False),
            only="but .obj and binary .stl in the robot's folder",
        ),
        changed(
            features.COLLISIONS,
            "collisions-off",
            "the collisions of mesh {uri!r} are off, as in this simulation",
            among(there=True),
        ),
    )


def _without_home(robot: Robot) -> Iterator[Found]:
    made = movers(robot)
    for joint in robot.joints:
        homes = {mover.coordinate.name for mover in made[joint.name] if mover.is_home}
        for c in joint.coordinates:
            if c.name not in homes:
                yield Found(Subject("joint", joint.name), {"coordinate": c.name})


def _beyond_quartics(robot: Robot) -> Iterator[Found]:
    """Couplings, and motions that follow, by functions that MuJoCo does not have."""
    for c in robot.all_coordinates:
        functions = [term.function for term in c.coupling]
        if len(functions) > 1 or not all(map(is_held, functions)):
            yield Found(Subject("coordinate", c.name))
    for joint, followers in _followers(robot):
        if not _are_held(followers):
            yield Found(Subject("joint", joint))


def _as_joints(robot: Robot) -> Iterator[Found]:
    for joint, followers in _followers(robot):
        if _are_held(followers):
            names = ", ".join(repr(mover.name) for mover in followers)
            yield Found(Subject("joint", joint), {"names": names})


def _followers(robot: Robot) -> Iterator[tuple[str, list[Mover]]]:
    """The motions of each joint that follow one of its coordinates, if there are any."""
    for joint, made in movers(robot).items():
        followers = [mover for mover in made if mover.name and not mover.is_home]
        if followers:
            yield joint, followers


def _are_held(followers: list[Mover]) -> bool:
    return all(is_held(mover.motion.function) for mover in followers)


def _is_soft(robot: Robot) -> bool:
    return any(c.coupling or c.locked for c in robot.all_coordinates)


def _other_order(robot: Robot) -> Words:
    order = [mover.coordinate for mover in coordinate_order(robot) if mover.is_home]
    names = ", ".join(coordinate.name for coordinate in order)
    return {} if order == list(robot.all_coordinates) else {"order": names}


def _impossible_inertias(robot: Robot) -> Iterator[Found]:
    for link, _ in written_inertias(robot):
        if missing(link.inertia) is None:
            yield Found(Subject("link", link.name))


def _increased_inertias(robot: Robot) -> Iterator[Found]:
    for link, _ in written_inertias(robot):
        if by := missing(link.inertia):
            yield Found(Subject("link", link.name), {"by": by})


def _increased_masses(robot: Robot) -> Iterator[Found]:
    for link, written in written_inertias(robot):
        if written.mass != link.inertia.mass:
            yield Found(Subject("link", link.name), {"mass": written.mass})


def _own_bounds(muscle: Muscle) -> bool:
    return muscle.model.kind in LAWS and (muscle.f_min > 0.0 or muscle.f_max < math.inf)


def _equal_bounds(muscle: Muscle) -> Words:
    are_equal = muscle.model.kind not in LAWS and muscle.f_min == muscle.f_max
    return {"force": muscle.f_min} if are_equal else {}


def _equal_torques(c: Coordinate) -> Words:
    are_equal = c.actuated and c.is_free and c.tau_min == c.tau_max
    return {"torque": c.tau_min} if are_equal else {}


def _ended_cylinders(robot: Robot) -> Iterator[Found]:
    for surface in robot.wrap_surfaces:
        if surface.shape == "cylinder" and math.isfinite(surface.length):
            yield Found(Subject("robot", robot.name), {"surface": surface.name})


def _wraps(robot: Robot, *, first: bool) -> Iterator[tuple[Muscle, Wrap]]:
    """The first wraps of each segment, or the others."""
    for muscle in robot.muscles:
        held = first_wraps(muscle).values()
        yield from ((muscle, wrap) for wrap in muscle.wraps if (wrap in held) == first)


def _second_wraps(robot: Robot) -> Iterator[Found]:
    for muscle, wrap in _wraps(robot, first=False):
        yield Found(Subject("muscle", muscle.name), {"surface": wrap.surface})


def _whole_turns(robot: Robot) -> Iterator[Found]:
    for muscle, wrap in _wraps(robot, first=True):
        if wrap.turns:
            words = {"turns": wrap.turns, "surface": wrap.surface}
            yield Found(Subject("muscle", muscle.name), words)


def _chosen_sides(robot: Robot) -> Iterator[Found]:
    for muscle, wrap in _wraps(robot, first=True):
        if wrap.side and not wrap.turns:  # a site inside the surface means a path inside
            yield Found(Subject("muscle", muscle.name), {"surface": wrap.surface})


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
        refused(
            features.DRIVEN_JOINTS,
            "driven-joint",
            "no motion of MuJoCo's is its coordinate {coordinate!r} itself; write sdf",
            _without_home,
            only="without a motion that is the coordinate",
        ),
        refused(
            features.DRIVEN_JOINTS,
            "driven-joint",
            "MuJoCo couples a joint to one other, by a polynomial of degree 4 at most; write sdf",
            _beyond_quartics,
            only="but by polynomials of degree 4 of one",
        ),
        changed(
            features.DRIVEN_JOINTS,
            "motion-as-joint",
            "motions that follow a coordinate become separate joints: {names}",
            _as_joints,
            only="others",
        ),
        changed(
            features.DRIVEN_JOINTS,
            "soft-equalities",
            "MuJoCo's equalities are soft: coupled and locked joints deviate a little",
            of_robot(_is_soft),
            only="others",
        ),
        features.loops_but(EQUALITIES),
        changed(
            features.LOOPS,
            "soft-loops",
            "MuJoCo's loops are soft: its equalities of bodies are springs with dampers",
            of_robot(lambda robot: any(loop.type in EQUALITIES for loop in robot.loops)),
            only="balls and fixed ones",
        ),
        left_out(features.LIMIT_FORCES),
        refused(
            "chains of more than 480 links",
            "too-many-nested",
            f"MuJoCo reads chains of at most {MAX_NESTED} links; this link exceeds that",
            too_deep,
        ),
        refused(
            "inertias that no body has",
            "inertia-triangle",
            "MuJoCo rejects a principal moment of inertia above the sum of the other two; correct "
            "the inertia",
            _impossible_inertias,
        ),
        changed(
            "moments of inertia that are zero",
            "inertia-increased",
            "MuJoCo needs positive moments of inertia; {by!r} kg·m² added to each",
            _increased_inertias,
        ),
        changed(
            "links without mass",
            "mass-increased",
            "MuJoCo needs masses; it gets {mass!r} kg",
            _increased_masses,
        ),
        changed(
            features.LIMITS,
            "soft-stops",
            "MuJoCo's joint limits are soft: a joint that hits one at v rad/s or m/s exceeds it by "
            f"up to v · {STEP:g} s and returns with up to 3 % of v; at rest it exceeds it by 1e-7",
            of_robot(features.has_limits),
        ),
        changed(
            features.FRICTION,
            "soft-friction",
            "MuJoCo's Coulomb friction is soft: a joint that it holds creeps by about 1e-8 rad "
            "or m in a second",
            of_robot(has_friction),
        ),
        changed(
            "coordinates in another order than bodies",
            "coordinate-order",
            "MuJoCo's order of the coordinates is another: {order}",
            of_robot(_other_order),
        ),
        left_out(
            "bounds of the force of MuJoCo's own muscles",
            "force-limits-left-out",
            "MuJoCo's muscles have no bounds of their force; f_min and f_max left out",
            of_muscles(_own_bounds),
        ),
        left_out(
            "equal bounds of forces",
            "force-limits-left-out",
            "MuJoCo has no equal limits of a control; command {force!r} N",
            of_muscles(_equal_bounds),
        ),
        left_out(
            "equal bounds of motors",
            "force-limits-left-out",
            "MuJoCo has no equal limits of a control; command {torque!r}",
            of_coordinates(_equal_torques),
        ),
        left_out(features.BOUNDS_WITHOUT_MOTOR),
        left_out(features.CONDITIONS),
        left_out(features.MOVING_POINTS),
        left_out(
            features.TERMS,
            "terms-left-out",
            "MuJoCo's tendons have a path, or lengths in proportion to joints; left out",
            of_muscles(lambda muscle: muscle.terms and muscle.via_points),
            only="beside a path",
        ),
        left_out(features.ELLIPSOIDS),
        left_out(features.OPENSIM_WRAPS),
        changed(
            "cylinders with ends",
            "cylinder-ends-left-out",
            "MuJoCo wraps over cylinders without ends; {surface!r} has some",
            _ended_cylinders,
        ),
        left_out(
            features.WRAPS,
            "wrap-left-out",
            "MuJoCo has one wrap a segment; {surface!r} is left out",
            _second_wraps,
            only="the second of a segment",
        ),
        left_out(
            features.WRAPS,
            "turns-left-out",
            "MuJoCo has no whole turns; {turns} about {surface!r} left out",
            _whole_turns,
            only="their whole turns",
        ),
        changed(
            features.WRAPS,
            "side-by-place",
            "a site shows on which side of {surface!r} it passes; it is placed for the initial "
            "coordinates",
            _chosen_sides,
            only="with a chosen side",
        ),
        *wrap_ends.rows("MuJoCo"),
        changed(
            features.COLLISIONS,
            "collisions-off",
            "the collisions of its {count} shapes are off, as in this simulation",
            of_links(_shapes),
        ),
        features.laws_but(LAWS),
        *features.NOT_IN_OTHER_SIMULATORS,
        left_out(features.JOINT_NAMES),
    ),
)
