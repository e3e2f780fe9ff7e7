"""Features that SDF holds with its plugin; robots that libsdformat rejects are rejected."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Sequence

from ...checks.masses import density_matrix, positive_semidefinite
from ...finding import Finding, Subject
from ...model.joint import Joint
from ...model.robot import WORLD, Link, Robot
from .. import features
from ..capability import Capabilities, FeaturePlace, changed, changed_together, kept, rejected
from ..cardsflow.capabilities import WRAPS_IN_CARDSFLOW_XML
from ..features import Words, of_coordinates, of_joints, of_links, of_robot
from .names import NO_LIMIT, joint_frame_name, needs_frame
from .write_joints import is_chained, loops_in_plugin, sdf_joints


def sdf_losses(robot: Robot) -> list[Finding]:
    """Return findings on everything that SDF, its plugin and cardsflow.xml cannot hold."""
    return SDF.losses(robot)


def _named_parts(robot: Robot) -> Iterator[Subject]:
    """Yield everything that has a name in the model."""
    yield from (Subject("link", link.name) for link in robot.links)
    yield from (Subject("joint", joint.name) for joint in robot.joints)
    yield from (Subject("joint", loop.name) for loop in robot.loops)


def _name_clashes(robot: Robot) -> Iterator[FeaturePlace]:
    """Report equal names of links, joints and frames, which share one namespace in SDF."""
    counts = Counter(subject.name for subject in _named_parts(robot))
    counts.update(joint_frame_name(loop.name, loop.child) for loop in robot.loops)
    for joints in sdf_joints(robot).values():
        counts.update(
            joint_frame_name(joint.name, joint.child)
            for joint in joints
            if needs_frame(joint.T_child_joint)
        )
    for subject in _named_parts(robot):
        if counts[subject.name] > 1:
            yield FeaturePlace(subject, {"name": subject.name})


def _reserved_names(robot: Robot) -> Iterator[FeaturePlace]:
    for subject in (*_named_parts(robot), Subject("robot", robot.name)):
        name = subject.name
        if "::" in name or (name.startswith("__") and name.endswith("__")) or name == WORLD:
            yield FeaturePlace(subject, {"name": name})


def _with_double_spaces(robot: Robot) -> Iterator[FeaturePlace]:
    return (FeaturePlace(subject) for subject in _named_parts(robot) if "  " in subject.name)


def _has_bad_text(link: Link) -> bool:
    texts = [text for mesh in link.meshes for text in (mesh.uri, mesh.name) if text]
    return any(text != text.strip() or not text.isprintable() for text in texts)


def _is_infinite_in_sdf(limits: Sequence[float]) -> bool:
    return any(NO_LIMIT <= abs(limit) < math.inf for limit in limits)


def _chain(joint: Joint) -> Words:
    return {"type": joint.type, "count": len(joint.motions)} if is_chained(joint) else {}


def _other_loops(robot: Robot) -> Iterator[FeaturePlace]:
    for loop in loops_in_plugin(robot):
        yield FeaturePlace(Subject("joint", loop.name), {"type": loop.type})


SDF = Capabilities(
    "SDF",
    (
        kept(features.LINKS, features.FIXED_JOINTS, features.JOINT_NAMES, features.LINK_FRAMES),
        kept(features.GRAVITIES, features.MESHES, features.MESH_NAMES, features.COLLISIONS),
        kept(features.LINK_ENDS, features.INITIAL_VALUES, features.LIMITS, features.DAMPING),
        kept(features.SPRINGS, features.FRICTION, features.MOTORS, features.MOTOR_BOUNDS),
        kept(
            features.BOUNDS_WITHOUT_MOTOR,
            features.VELOCITY_LIMITS,
            *features.MUSCLE_AND_TASK_FEATURES,
        ),
        rejected(
            "links, joints and frames with the same name",
            "sdf-name-clash",
            "SDF requires unique names of links, joints and frames; rename {name!r}",
            _name_clashes,
        ),
        rejected(
            "reserved names",
            "sdf-reserved-name",
            "SDF reserves the name {name!r}; rename it",
            _reserved_names,
        ),
        changed(
            "names with consecutive spaces",
            "sdf-spaces",
            "libsdformat merges consecutive spaces and then does not find this name",
            _with_double_spaces,
        ),
        rejected(
            "meshes with control characters in names or URIs",
            "sdf-mesh-text",
            "the URI or name of a mesh contains control characters, or begins or ends with a space",
            of_links(_has_bad_text),
        ),
        rejected(
            "limits above 1e16",
            "sdf-limit",
            f"in SDF a limit of {NO_LIMIT:g} or more means no limit; use an infinite limit",
            of_coordinates(lambda c: _is_infinite_in_sdf((c.lower, c.upper))),
        ),
        rejected(
            "motor and velocity limits above 1e16",
            "sdf-limit",
            f"in SDF a limit of a motor or velocity of {NO_LIMIT:g} or more means no limit; use an "
            "infinite limit",
            of_coordinates(lambda c: _is_infinite_in_sdf((c.tau_min, c.tau_max, c.max_velocity))),
        ),
        changed(
            features.CHAINS,
            "joint-in-a-chain",
            "SDF has no {type} joint with coordinates; other programs read {count} separate joints "
            "connected by massless links",
            of_joints(_chain),
            only="except universal joints",
        ),
        changed(
            features.DRIVEN_JOINTS,
            "functions-in-the-plugin",
            "its functions are only in the CARDSFlow plugin; in other programs its motions are "
            "independent coordinates",
        ),
        changed(
            features.LOOPS,
            "loop-in-the-plugin",
            "SDF has no {type} joint as loop joint; it is only in the CARDSFlow plugin, and the "
            "loop is open in other programs",
            _other_loops,
            only="cylindrical and planar ones",
        ),
        changed_together(
            (features.ARMATURES, features.LIMIT_FORCES),
            "held-in-the-plugin",
            "SDF has no {feature}; other programs ignore the CARDSFlow elements that contain them",
        ),
        changed(
            features.LOOPS,
            "loops-in-drake",
            "Drake rejects models with loop joints: {names}",
            of_robot(lambda robot: [loop.name for loop in robot.loops]),
            only="others",
        ),
        changed(
            "physically impossible inertias",
            "sdf-inertia-refused",
            "its inertia is physically impossible; libsdformat rejects it, Drake replaces it",
            of_links(lambda link: not positive_semidefinite(density_matrix(link.inertia.matrix))),
        ),
        WRAPS_IN_CARDSFLOW_XML,
    ),
)
