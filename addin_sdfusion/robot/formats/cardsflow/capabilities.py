"""Features that cardsflow.xml holds: muscles and end effectors, but no links."""

from __future__ import annotations

from collections.abc import Iterator

from ...finding import Subject
from ...model.robot import Robot
from .. import features
from ..capability import Capabilities, FeaturePlace, changed, kept, omitted, omitted_together
from ..features import of_robot
from .wraps import supported_wraps


def _omitted_wraps(robot: Robot) -> Iterator[FeaturePlace]:
    surfaces = {surface.name: surface for surface in robot.wrap_surfaces}
    for muscle in robot.muscles:
        supported = supported_wraps(muscle, surfaces)
        unsupported = [repr(wrap.surface) for wrap in muscle.wraps if wrap not in supported]
        if unsupported:
            words = {"count": len(unsupported), "surfaces": ", ".join(unsupported)}
            yield FeaturePlace(Subject("muscle", muscle.name), words)


def _surfaces(robot: Robot, *, used: bool) -> Iterator[FeaturePlace]:
    """Report the wrap surfaces that muscles use in cardsflow.xml, or all others."""
    surfaces = {surface.name: surface for surface in robot.wrap_surfaces}
    names = {wrap.surface for muscle in robot.muscles for wrap in supported_wraps(muscle, surfaces)}
    for surface in robot.wrap_surfaces:
        if used == (surface.name in names) and (not used or any(surface.pose.rpy)):
            yield FeaturePlace(Subject("wrap_surface", surface.name))


WRAPS_IN_CARDSFLOW_XML = omitted(
    features.WRAPS,
    "wraps-left-out",
    "cardsflow.xml holds one wrap per segment and only cylinders along a link's z axis, without "
    "ellipsoids or rules of other programs; {count} of its wraps are omitted, over {surfaces}",
    _omitted_wraps,
    only="in cardsflow.xml: several per segment, rotated cylinders, ellipsoids, other rules",
)

CARDSFLOW = Capabilities(
    "cardsflow.xml",
    (
        kept(features.MUSCLES, features.MUSCLE_LAWS, features.IDEAL_PARAMETERS, features.PULLEYS),
        kept(features.CABLE_FRICTION, features.CONDITIONS, features.MOVING_POINTS),
        kept(features.BRANCHES, features.TERMS, features.TASK_FRAMES, features.TASK_AXES),
        omitted(
            features.LINKS,
            "links-left-out",
            "cardsflow.xml holds muscles and end effectors; links and joints are in model.sdf",
            of_robot(lambda robot: True),
        ),
        omitted_together(*features.LINK_AND_JOINT_FEATURES[1:]),
        omitted(features.CABLE_SETS),
        omitted(features.TASK_SETS),
        omitted(features.SET_NAMES),
        WRAPS_IN_CARDSFLOW_XML,
        omitted_together(features.ELLIPSOIDS, features.OPENSIM_WRAPS, features.MUJOCO_WRAPS),
        omitted(
            features.WRAP_SURFACES,
            "wrap-surfaces-left-out",
            "no muscle in cardsflow.xml uses it; omitted",
            lambda robot: _surfaces(robot, used=False),
            only="that no muscle uses",
        ),
        changed(  # rotated cylinders are omitted
            "rotated spheres",
            "sphere-turned-back",
            "cardsflow.xml has no rotated spheres; it defines the side about the link's z axis",
            lambda robot: _surfaces(robot, used=True),
        ),
    ),
)
