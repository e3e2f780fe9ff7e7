"""Conversion of a robot to the files of any format, with findings on all that is lost."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

from ..errors import UnknownNameError
from ..finding import Finding, Subject
from ..finding_builders import all_task_frames, warning
from ..model.robot import Robot
from ..transforms.simplify import align_frames, merge_fixed_joints
from .cardsflow_xml import cardsflow_losses, write_cardsflow_xml
from .caspr.model import losses as caspr_losses
from .caspr.model import write_caspr
from .mujoco.model import mjcf_losses, write_mjcf
from .opensim.model import osim_losses, write_osim
from .sdf.model import sdf_losses, write_sdf
from .urdf import urdf_losses, write_urdf


class Format(NamedTuple):
    """A format that robots are written in.

    Attributes:
        losses: What of a robot it cannot hold.
        write: Writes the files; raises RobotError where `losses` has errors.
        prepare: Makes an equal robot that it can hold.
    """

    losses: Callable[[Robot], list[Finding]]
    write: Callable[[Robot, Path], list[Path]]
    prepare: Callable[[Robot], Robot] = lambda robot: robot


def _for_caspr(robot: Robot) -> Robot:
    """CASPR has neither fixed joints nor frames of their own."""
    return align_frames(merge_fixed_joints(robot))


def _merged_links(robot: Robot, prepared: Robot) -> Iterator[Finding]:
    """Links that are no longer there, because fixed joints were merged."""
    left = {link.name for link in prepared.links}
    gone = [link.name for link in robot.links if link.name not in left]
    if gone:
        problem = (
            "the format has no fixed joints: links are merged into those they are fixed to, or "
            f"into the world, which takes their points and not their mass: {', '.join(gone)}"
        )
        yield warning(Subject("robot", robot.name), "links-merged", problem)


def _turned_orientations(robot: Robot, prepared: Robot) -> Iterator[Finding]:
    """Angles of a link whose frame was turned count from another zero."""
    turned = {
        joint.child
        for joint in robot.joints
        if any(joint.T_parent_joint.rpy) or any(joint.T_child_joint.rpy)
    }
    if prepared is robot or not turned:
        return
    for subject, frame in all_task_frames(robot):
        if frame.is_orientation:
            problem = (
                "link frames are turned parallel to the world at q = 0, where its angles are 0"
            )
            yield warning(subject, "orientation-from-zero-pose", problem)


FORMATS: dict[str, Format] = {
    "sdf": Format(sdf_losses, write_sdf),
    "caspr": Format(caspr_losses, write_caspr, _for_caspr),
    "cardsflow": Format(cardsflow_losses, write_cardsflow_xml),
    "urdf": Format(urdf_losses, write_urdf),
    "mjcf": Format(mjcf_losses, write_mjcf),
    "osim": Format(osim_losses, write_osim),
}


class Conversion(NamedTuple):
    """What a conversion gave.

    Attributes:
        files: The files written.
        findings: What the format cannot hold.
    """

    files: list[Path]
    findings: list[Finding]


def convert(robot: Robot, format_: str, folder: str | Path) -> Conversion:
    """Write a robot in another format.

    Args:
        robot: The robot; its active cable set and operational space count most.
        format_: One of `FORMATS`.
        folder: Where to; made if it does not exist.

    Raises:
        UnknownNameError: There is no such format.
        RobotError: The robot has errors, or the format cannot hold it at all.
        InputError: The folder cannot be written.
    """
    if format_ not in FORMATS:
        raise UnknownNameError("format", format_, FORMATS)
    return convert_to(FORMATS[format_], robot, folder)


def convert_to(format_: Format, robot: Robot, folder: str | Path) -> Conversion:
    """As `convert`, in a format that need not be one of `FORMATS`.

    Raises:
        RobotError: The robot has errors, or the format cannot hold it at all.
        InputError: The folder cannot be written.
    """
    prepared = format_.prepare(robot)
    findings = [
        *_merged_links(robot, prepared),
        *_turned_orientations(robot, prepared),
        *format_.losses(prepared),
    ]
    return Conversion(format_.write(prepared, Path(folder)), findings)
