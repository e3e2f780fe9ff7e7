"""Writer of muscles and task frames for cardsflow.xml and the SDF plugin.

A muscle lists its links in order, each with its via points in the frame of the link. Data that the
original format cannot hold is in additional attributes and elements, which its readers ignore:

    myoMuscle    f_min f_max       force limits, in [N]
                 friction          cable friction on the guides, if not 0
                 presliding        presliding distance, in [m], if not 0.2 mm
    cable_model  kind              muscle law; its parameter elements by name
    base_pulley  kind              a swivelling pulley at the first point; parameters likewise
    viaPoint     coordinate low high smoothing
                                   condition under which the via point is active
    viaPoint, wrap  friction       cable friction at this point, if it differs from the muscle's
    move         axis coordinate low high and a function
                                   in a viaPoint: its motion on the link
    branch       point divisor     start of another branch at a via point, counted from 0
    term         coordinate factor a part of the length that is proportional to a coordinate
    endEffector  axes              its task coordinates: letters, or alpha, beta, gamma

In cardsflow.xml a wrap surface is a via point of the path, as in the original format: type
SPHERICAL or CYLINDRICAL with radius, state and revCounter. The state is the initial state of the
cable: 0 straight, 1 the shorter path around the surface, 2 the longer path. The original plugin
then follows the motion of the cable. `surface`, `length` and `side` (the sense of rotation about
the z axis) are additions. In the plugin, surfaces are separate elements, and the `wrap` elements of
a muscle refer to them.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from itertools import groupby
from pathlib import Path
from xml.etree import ElementTree

from ...model.muscle import PRESLIDING, Muscle, ViaPoint, Wrap, WrapSurface
from ...model.robot import Robot, TaskFrame
from ..writing.file_names import write_document
from ..writing.functions import function_element
from ..writing.wrap_side import is_shorter_path
from ..writing.xml_text import document, element, numbers
from .wraps import WRAP_TYPES, supported_wraps

WRAP_STATES = ("0", "1", "2")
"""The `state` of a wrap via point: initially straight, the shorter path, the longer path."""
INSIDE = "inside"
"""The `side` of a wrap on the inner side of its surface."""


def write_cardsflow_xml(robot: Robot, folder: str | Path) -> list[Path]:
    """Write only cardsflow.xml, next to a model.sdf; returns and raises as `write_document`."""
    return write_document(robot, folder, "cardsflow", "xml", cardsflow_xml)


def muscle_element(parent: ElementTree.Element, muscle: Muscle) -> ElementTree.Element:
    """Add a muscle without its wraps: `<myoMuscle name f_min f_max>`."""
    return _muscle(parent, muscle, [_Step(point) for point in muscle.via_points])


def wrap_elements(node: ElementTree.Element, muscle: Muscle) -> None:
    """Add the `<wrap surface segment side turns>` elements of a muscle."""
    for wrap in muscle.wraps:
        side = INSIDE if wrap.inside else str(wrap.side)
        words = {"segment": str(wrap.segment), "side": side, "turns": str(wrap.turns)}
        words |= _rule_attributes(wrap) | _friction_attributes(wrap)
        element(node, "wrap", surface=wrap.surface, **words)


def _rule_attributes(wrap: Wrap) -> dict[str, str]:
    """Return the attributes of a wrap by the rules of another program; empty for our rules."""
    if wrap.rule == "taut":
        return {}
    words: dict[str, str] = {"rule": wrap.rule}
    if wrap.quadrant != "all":
        words["quadrant"] = wrap.quadrant
    if wrap.last_segment is not None:
        words["last_segment"] = str(wrap.last_segment)
    if wrap.side_point is not None:
        words["side_link"] = wrap.side_point.link
        words["side_position"] = numbers(wrap.side_point.position)
    return words


def end_effector_element(parent: ElementTree.Element, frame: TaskFrame) -> None:
    """Add an `<endEffector name link axes>` element."""
    text = numbers(frame.position)
    letters = all(len(axis) == 1 for axis in frame.axes)
    axes = ("" if letters else " ").join(frame.axes)
    element(parent, "endEffector", text, name=frame.name, link=frame.link, axes=axes)


def cardsflow_xml(robot: Robot) -> str:
    """Return the text of a cardsflow.xml with the active muscles and task frames of a robot."""
    root = element(None, "cardsflow")
    surfaces = {surface.name: surface for surface in robot.wrap_surfaces}
    for muscle in robot.muscles:
        wraps = {wrap.segment: wrap for wrap in supported_wraps(muscle, surfaces)}
        steps = []
        for i, point in enumerate(muscle.via_points):
            steps.append(_Step(point))
            if i in wraps:
                steps.append(_wrap_step(robot, muscle, wraps[i], surfaces[wraps[i].surface]))
        _muscle(root, muscle, steps)
    for frame in robot.task_frames:
        end_effector_element(root, frame)
    return document(root)


class _Step:
    """Via point element to write: its position and its attributes."""

    def __init__(self, point: ViaPoint, **attributes: str) -> None:
        self.point = point
        words = {"type": "FIXPOINT", **_condition_attributes(point), **_friction_attributes(point)}
        self.attributes = attributes or words


def _condition_attributes(point: ViaPoint) -> dict[str, str]:
    when = point.when
    if when is None:
        return {}
    values = {"low": when.low, "high": when.high, "smoothing": when.smoothing}
    return {"coordinate": when.coordinate} | {k: numbers([x]) for k, x in values.items()}


def _friction_attributes(bend: ViaPoint | Wrap) -> dict[str, str]:
    return {} if bend.friction is None else {"friction": numbers([bend.friction])}


def _wrap_step(robot: Robot, muscle: Muscle, wrap: Wrap, surface: WrapSurface) -> _Step:
    more = _friction_attributes(wrap)
    if surface.length != math.inf:
        more["length"] = numbers([surface.length])
    state = WRAP_STATES[0]
    if wrap.inside:
        more["side"] = INSIDE
    elif wrap.side:
        state = WRAP_STATES[1 if is_shorter_path(robot, muscle, wrap) else 2]
        more["side"] = str(wrap.side)
    return _Step(
        ViaPoint(surface.link, surface.pose.position),
        type=WRAP_TYPES[surface.shape],
        radius=numbers([surface.radius]),
        state=state,
        revCounter=str(wrap.turns),
        surface=surface.name,
        **more,
    )


def _muscle(
    parent: ElementTree.Element, muscle: Muscle, steps: Iterable[_Step]
) -> ElementTree.Element:
    limits = {"f_min": numbers([muscle.f_min]), "f_max": numbers([muscle.f_max])}
    if muscle.friction:
        limits["friction"] = numbers([muscle.friction])
    if muscle.presliding != PRESLIDING:
        limits["presliding"] = numbers([muscle.presliding])
    node = element(parent, "myoMuscle", name=muscle.name, **limits)
    for link, group in groupby(steps, key=lambda step: step.point.link):
        block = element(node, "link", name=link)
        for step in group:
            item = element(block, "viaPoint", numbers(step.point.position), **step.attributes)
            for move in step.point.moves:
                words = {"axis": numbers(move.axis), "coordinate": move.coordinate}
                words |= {"low": numbers([move.low]), "high": numbers([move.high])}
                function_element(item, "move", move.function, **words)
    for branch in muscle.branches:
        words = {"point": str(branch.point), "divisor": numbers([branch.divisor])}
        element(node, "branch", **words)
    for term in muscle.terms:
        element(node, "term", coordinate=term.coordinate, factor=numbers([term.factor]))
    if muscle.model.kind != "ideal" or muscle.model.parameters:
        rows = ((name, (number,)) for name, number in muscle.model.parameters)
        _parameters(element(node, "cable_model", kind=muscle.model.kind), rows)
    if muscle.pulley is not None:
        pulley = element(node, "base_pulley", kind=muscle.pulley.kind)
        _parameters(pulley, muscle.pulley.parameters)
    return node


def _parameters(parent: ElementTree.Element, rows: Iterable[tuple[str, tuple[float, ...]]]) -> None:
    for name, values in rows:
        element(parent, "parameter", numbers(values), name=name)
