"""Losses in SDF: errors where it would refuse the file, warnings elsewhere."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator

from ...checks.masses import density_matrix, positive_semidefinite
from ...finding import Finding, Subject, errors_first
from ...finding_builders import error, warning
from ...model.robot import WORLD, Robot
from ..cardsflow.write import wrap_losses
from ..writing.common_losses import loop_types
from .names import NO_LIMIT, joint_frame_name, needs_frame
from .write_joints import KINDS, is_chained, sdf_joints


def sdf_losses(robot: Robot) -> list[Finding]:
    """Everything that SDF with its plugin and cardsflow.xml cannot hold.

    Returns:
        Errors, for which it is not written, then warnings for what is left out or doubtful.
    """
    found = [
        *_names(robot),
        *_mesh_texts(robot),
        *_limits(robot),
        *_chains(robot),
        *loop_types(robot, "SDF", KINDS),
        *_beyond(robot),
        *_inertias(robot),
        *wrap_losses(robot),
    ]
    return errors_first(found)


def _names(robot: Robot) -> Iterator[Finding]:
    """SDF keeps the names of links, joints and frames in one drawer and reserves some."""
    named = [Subject("link", link.name) for link in robot.links]
    named += [Subject("joint", joint.name) for joint in robot.joints]
    named += [Subject("joint", loop.name) for loop in robot.loops]
    counts = Counter(subject.name for subject in named)
    counts.update(joint_frame_name(loop.name, loop.child) for loop in robot.loops)
    for parts in sdf_joints(robot).values():
        counts.update(
            joint_frame_name(part.name, part.child)
            for part in parts
            if needs_frame(part.T_child_joint)
        )
    named.append(Subject("robot", robot.name))
    for subject in named:
        name = subject.name
        if counts[name] > 1 and subject.kind != "robot":
            problem = "SDF needs different names for links, joints and frames; rename it"
            yield error(subject, "sdf-name-clash", f"{problem}, {name!r} is taken")
        if "::" in name or (name.startswith("__") and name.endswith("__")) or name == WORLD:
            yield error(subject, "sdf-reserved-name", f"SDF reserves the name {name!r}; rename it")
        if "  " in name and subject.kind != "robot":
            problem = "libsdformat takes spaces in a row for one, and finds no link of the name"
            yield warning(subject, "sdf-spaces", problem)


def _mesh_texts(robot: Robot) -> Iterator[Finding]:
    for link in robot.links:
        for text in (text for mesh in link.meshes for text in (mesh.uri, mesh.name)):
            if text and (text != text.strip() or not text.isprintable()):
                problem = (
                    "a mesh's URI or name begins or ends with a space or has control characters"
                )
                yield error(Subject("link", link.name), "sdf-mesh-text", problem)


def _limits(robot: Robot) -> Iterator[Finding]:
    for c in robot.all_coordinates:
        if any(NO_LIMIT <= abs(limit) < math.inf for limit in (c.lower, c.upper)):
            problem = f"a limit of {NO_LIMIT:g} or more is none in SDF; make it infinite"
            yield error(Subject("coordinate", c.name), "sdf-limit", problem)
        if any(NO_LIMIT <= abs(limit) < math.inf for limit in (c.tau_min, c.tau_max)):
            problem = f"a motor's bound of {NO_LIMIT:g} or more is none in SDF; make it infinite"
            yield error(Subject("coordinate", c.name), "sdf-limit", problem)


def _chains(robot: Robot) -> Iterator[Finding]:
    for joint in robot.joints:
        if is_chained(joint):
            problem = (
                f"SDF has no {joint.type} joint with coordinates; other programs see "
                f"{len(joint.motions)} single joints with links without mass between them"
            )
            yield warning(Subject("joint", joint.name), "joint-in-a-chain", problem)
        if not joint.is_plain:
            problem = (
                "what drives it is in the CARDSFlow plugin alone; in other programs its motions "
                "are coordinates of their own"
            )
            yield warning(Subject("joint", joint.name), "functions-in-the-plugin", problem)


def _beyond(robot: Robot) -> Iterator[Finding]:
    """What moves the robot otherwise in other programs."""
    subject = Subject("robot", robot.name)
    several = {
        "armatures": any(c.armature for c in robot.all_coordinates),
        "forces beyond a range": any(c.limit_force for c in robot.all_coordinates),
    }
    there = " and ".join(what for what, is_there in several.items() if is_there)
    if there:
        problem = f"SDF has no {there}: others do not read them from CARDSFlow's own elements"
        yield warning(subject, "held-in-the-plugin", problem)
    if robot.loops:
        names = ", ".join(repr(loop.name) for loop in robot.loops)
        problem = f"Drake refuses models with joints that close loops: {names}"
        yield warning(subject, "loops-in-drake", problem)


def _inertias(robot: Robot) -> Iterator[Finding]:
    for link in robot.links:
        if not positive_semidefinite(density_matrix(link.inertia.matrix)):
            problem = "no body has its inertia: libsdformat refuses it, Drake takes another"
            yield warning(Subject("link", link.name), "sdf-inertia-refused", problem)
