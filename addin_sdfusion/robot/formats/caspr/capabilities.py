"""Features that CASPR files hold, change, omit or reject."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Sequence

from ...caspr_vocabulary import CASPR_CABLES, CASPR_PULLEYS, Property, cable_tag
from ...finding import Finding, Subject, errors_first
from ...finding_builders import all_task_frames
from ...model.joint import Joint
from ...model.muscle import Muscle
from ...model.pose import IDENTITY
from ...model.robot import GRAVITY, WORLD, Robot
from ...model.trajectory import Trajectory
from .. import features
from ..capability import (
    Capabilities,
    FeaturePlace,
    changed,
    in_all_sets,
    kept,
    omitted,
    omitted_together,
    rejected,
)
from ..features import Words, of_joints, of_links, of_muscles, of_robot
from .joints import CASPR_JOINTS, caspr_joint_type
from .trajectory_losses import NOT_AN_ID, XML_ID, trajectory_losses
from .write_tasks import task_items


def caspr_losses(robot: Robot, trajectories: Sequence[Trajectory] = ()) -> list[Finding]:
    """Return findings on everything that CASPR files cannot hold."""
    return errors_first([*CASPR.losses(robot), *trajectory_losses(robot, trajectories)])


def _renamed(robot: Robot) -> Words:
    """Return a message on the joints and coordinates that get another name when read again."""
    names = {
        f"{name!r} becomes {new_name}": None
        for i, joint in enumerate(robot.joints, start=1)
        for name, new_name in _names(joint, f"joint_{i}")
        if name != new_name
    }
    return {"renamed": ", ".join(names)} if names else {}


def _names(joint: Joint, new_name: str) -> Iterator[tuple[str, str]]:
    yield joint.name, new_name
    words = [j.suffixes for j in CASPR_JOINTS.values() if j.motions == joint.motions]
    suffixes = words[0] if words else ("",) * len(joint.coordinates)
    for coordinate, suffix in zip(joint.coordinates, suffixes, strict=False):
        yield coordinate.name, f"{new_name}_{suffix}" if suffix else new_name


def _has_other_motions(joint: Joint) -> bool:
    return joint.type != "fixed" and caspr_joint_type(joint.motions) is None


def _is_turned(joint: Joint) -> bool:
    return any(joint.T_parent_joint.rpy) or any(joint.T_child_joint.rpy)


def _is_moved(joint: Joint) -> Words:
    moved = joint.T_child_joint != IDENTITY and not _is_turned(joint)
    return {"child": joint.child} if moved else {}


def _other_law(muscle: Muscle) -> Words:
    kind = muscle.model.kind
    return {} if CASPR_CABLES[cable_tag(kind)].kind == kind else {"kind": kind}


def _missing_parameters(muscle: Muscle) -> Words:
    used, table = _parameters(muscle)
    missing = [names for item, names in table if item.required and not set(names) <= set(used)]
    return _names_for(cable_tag(muscle.model.kind), [name for names in missing for name in names])


def _other_parameters(muscle: Muscle) -> Words:
    used, table = _parameters(muscle)
    names = {name for _, names in table for name in names}
    return _names_for(cable_tag(muscle.model.kind), [name for name in used if name not in names])


def _parameters(muscle: Muscle) -> tuple[list[str], list[tuple[Property, list[str]]]]:
    """Return the parameters of a cable, and CASPR's properties with their parameters."""
    cable = CASPR_CABLES[cable_tag(muscle.model.kind)]
    names = [] if _other_law(muscle) else [name for name, _ in muscle.model.parameters]
    return names, [
        (item, [item.name(k) for k in range(1, (item.size or len(names)) + 1)])
        for item in cable.properties
    ]


def _missing_numbers(muscle: Muscle) -> Words:
    tag, sizes, properties = _numbers(muscle)
    missing = [item for item in properties if sizes.get(item.tag) != item.size]
    return _names_for(tag, [f"{item.size} numbers {item.tag}" for item in missing])


def _other_numbers(muscle: Muscle) -> Words:
    tag, sizes, properties = _numbers(muscle)
    return _names_for(tag, sorted(set(sizes) - {item.tag for item in properties}))


def _numbers(muscle: Muscle) -> tuple[str, dict[str, int], tuple[Property, ...]]:
    """Return CASPR's element of a pulley, its sizes by name, and the properties in CASPR."""
    if muscle.pulley is None:
        return "", {}, ()
    tag, words = next(p for p in CASPR_PULLEYS.items() if p[1].kind == muscle.pulley.kind)
    return tag, {name: len(values) for name, values in muscle.pulley.parameters}, words.properties


def _names_for(tag: str, names: Sequence[str]) -> Words:
    return {"tag": tag, "names": ", ".join(names)} if names else {}


def _has_pulley_off_base(muscle: Muscle) -> bool:
    return muscle.pulley is not None and [p.link for p in muscle.via_points[:1]] != [WORLD]


def _crowded_links(robot: Robot) -> Iterator[FeaturePlace]:
    for task_set in robot.task_sets:
        counts = Counter(item.link for item in task_items(task_set.frames))
        for link, count in counts.items():
            if count > 1:
                yield FeaturePlace(
                    Subject("task_set", task_set.name), {"count": count, "link": link}
                )


def _points_of_orientations(robot: Robot) -> Iterator[FeaturePlace]:
    for subject, frame in all_task_frames(robot):
        if frame.is_orientation and any(frame.position):
            yield FeaturePlace(subject)


def _sets_without_id(robot: Robot) -> Iterator[FeaturePlace]:
    groups = [*(Subject("cable_set", group.name) for group in robot.cable_sets)]
    groups += [Subject("task_set", group.name) for group in robot.task_sets]
    return (FeaturePlace(subject) for subject in groups if not XML_ID.fullmatch(subject.name))


CASPR = Capabilities(
    "CASPR",
    (
        kept(features.LINKS, features.LIMITS, features.INITIAL_VALUES, features.LINK_ENDS),
        kept(features.MOTORS, features.MUSCLES, features.CABLE_SETS, features.SET_NAMES),
        kept(features.TASK_FRAMES, features.TASK_SETS, features.TASK_AXES, features.PULLEYS),
        rejected(
            features.GRAVITIES, "caspr-gravity", f"CASPR's gravity is {GRAVITY}, not {{gravity}}"
        ),
        changed(
            "links without far ends",
            "caspr-link-ends",
            "CASPR requires far ends of links, for drawing; 0 0 0 is written for {names}",
            of_robot(lambda robot: [link.name for link in robot.links if link.end is None]),
        ),
        omitted(
            features.JOINT_NAMES,
            "caspr-joint-names",
            "CASPR does not name joints and coordinates; {renamed}",
            of_robot(_renamed),
        ),
        rejected(
            features.FIXED_JOINTS,
            "caspr-fixed-joint",
            "CASPR has no fixed joints; merge link {child!r} into {parent!r}",
        ),
        rejected(
            features.CHAINS,
            "caspr-joint-type",
            "CASPR has no joint with these motions; split it into several joints",
            of_joints(_has_other_motions),
            only="other than those of CASPR",
        ),
        rejected(
            features.DRIVEN_JOINTS,
            "caspr-driven-joint",
            "CASPR has no coupled or locked coordinates; lock them at a value",
            of_joints(lambda joint: not (joint.is_plain or _has_other_motions(joint))),
        ),
        rejected(
            "frames that are rotated at q = 0",
            "caspr-turned-frame",
            "has a frame that is rotated at q = 0, which CASPR does not support; align the frames",
            of_joints(_is_turned),
        ),
        rejected(
            features.LINK_FRAMES,
            "caspr-link-frame",
            "CASPR requires the frame of link {child!r} to equal the joint frame; move it there",
            of_joints(_is_moved),
        ),
        rejected(
            "joints with and without motors on their coordinates",
            "caspr-mixed-actuation",
            "CASPR requires motors on all coordinates of a joint or on none; split the joint",
            of_joints(lambda joint: len({c.actuated for c in joint.coordinates}) > 1),
        ),
        omitted(features.MOTOR_BOUNDS, "caspr-motor-bounds"),
        omitted_together(features.BOUNDS_WITHOUT_MOTOR, features.MESH_NAMES),
        omitted(features.DAMPING, "caspr-damping"),
        omitted(features.SPRINGS, "caspr-spring"),
        omitted(features.FRICTION, "caspr-spring"),
        omitted(features.ARMATURES, "caspr-spring"),
        omitted(features.LIMIT_FORCES, "caspr-spring"),
        omitted(features.LOOPS),
        omitted(features.VELOCITY_LIMITS),
        omitted(features.MESHES, "caspr-meshes", "CASPR has no meshes; {count} omitted"),
        omitted(
            features.COLLISIONS,
            "caspr-meshes",
            "CASPR has no collision shapes; {count} omitted",
            of_links(lambda link: link.shapes),
        ),
        omitted(
            features.WRAP_SURFACES,
            "caspr-wrap",
            "CASPR has no wrap surfaces; omitted, and cables are straight",
        ),
        omitted_together(features.ELLIPSOIDS),
        *in_all_sets(
            omitted(features.OPENSIM_WRAPS),
            omitted(features.MUJOCO_WRAPS),
            omitted(features.WRAPS, "caspr-wrap", "CASPR has no wrapping; the cable is straight"),
            changed(
                "cables without a maximum force",
                "caspr-infinite-force",
                "f_max is written as inf, which the solvers of CASPR may reject; set a number",
                of_muscles(lambda muscle: muscle.f_max == math.inf),
            ),
            omitted(
                features.MUSCLE_LAWS,
                "caspr-tension-law",
                "CASPR has no {kind}; written as an ideal cable with force limits",
                of_muscles(_other_law),
                only="other than those of CASPR",
            ),
            rejected(
                "cables without parameters that CASPR requires",
                "caspr-cable-property",
                "<{tag}> of CASPR requires {names}; add them to the model",
                of_muscles(_missing_parameters),
            ),
            omitted(
                features.IDEAL_PARAMETERS,
                "caspr-cable-property",
                "<{tag}> of CASPR has no {names}; omitted",
                of_muscles(_other_parameters),
                only="those that CASPR does not have",
            ),
            rejected(
                "pulleys that are not at the base",
                "pulley-not-at-base",
                "CASPR requires pulleys at the base; attach the first via point to it",
                of_muscles(_has_pulley_off_base),
            ),
            rejected(
                "pulleys without numbers that CASPR requires",
                "caspr-pulley-property",
                "<{tag}> of CASPR requires {names}; add them",
                of_muscles(_missing_numbers),
            ),
            omitted(
                "additional numbers of pulleys",
                "caspr-pulley-property",
                "<{tag}> of CASPR has no {names}; omitted",
                of_muscles(_other_numbers),
            ),
            omitted(features.CABLE_FRICTION),
            omitted(features.CONDITIONS),
            omitted(features.MOVING_POINTS),
            omitted(features.BRANCHES),
            *features.TERMS_OMITTED,
        ),
        changed(
            "several items of an operational space on one link",
            "caspr-one-item-a-link",
            "has {count} items on link {link!r}; CASPR supports one item per link",
            _crowded_links,
        ),
        omitted(
            "points of orientations",
            "caspr-orientation-point",
            "CASPR has no reference point of orientations; omitted",
            _points_of_orientations,
        ),
        changed("sets whose name is not an XML ID", "caspr-id", NOT_AN_ID, _sets_without_id),
    ),
)
