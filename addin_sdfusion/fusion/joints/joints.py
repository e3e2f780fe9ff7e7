"""Joints and as-built joints of an occurrence, in the root frame.

They are read component by component: the root's `allJoints` fails with an internal error where a
design has assembly constraints. Joints of sub-assemblies are read through proxies, since their
geometry is null otherwise.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

from ...robot.finding import Subject
from ...robot.model.pose import Vector3
from ...robot.model.transform import Transform
from ...snapshot import JointKind, JointSnapshot, MotionSnapshot
from ..health import problem_of
from ..notes import Notes, optional
from ..occurrences import Occurrence, Occurrences, each_in, subject_in
from ..units import finite, length
from .axes import ball_axes, signed
from .frames import JointFrames, Place, as_built_frame, joint_frames
from .motions import Freedom, joint_kinds, read_freedoms

REMEDY = "Modify > Compute All; if that does not help, make the joint anew"


@dataclass(frozen=True)
class _Ends:
    """What a joint joins; None if Fusion does not say."""

    one: Occurrence | None
    two: Occurrence | None


def read_joints(
    occurrence: Occurrence, occurrences: Occurrences, notes: Notes
) -> Iterator[JointSnapshot]:
    """The joints of the component in an occurrence."""
    component = occurrence.component
    for _, name, joint in each_in(occurrence, lambda: component.joints, notes, "joint"):
        yield _Reader(joint, name, occurrence, occurrences, notes).joint()
    for _, name, joint in each_in(occurrence, lambda: component.asBuiltJoints, notes, "joint"):
        yield _Reader(joint, name, occurrence, occurrences, notes, as_built=True).joint()
    _note_others(occurrence, notes)


def _note_others(occurrence: Occurrence, notes: Notes) -> None:
    """What also relates parts to each other, and is not read."""
    component = occurrence.component
    name = occurrence.path or "the root component"
    for code, count, text in (
        (
            "assembly-constraints",
            optional(lambda: int(component.assemblyConstraints.count)),  # since July 2025
            "assembly constraints, which have neither axes nor limits: where parts move, replace "
            "them by joints (Assemble > Joint)",
        ),
        (
            "tangent-relationships",
            optional(lambda: int(component.tangentRelationships.count)),  # since May 2022
            "tangent relationships, which a robot's description does not have: where faces slide "
            "or roll on each other, replace them by joints (Assemble > Joint)",
        ),
    ):
        if count:
            notes.warn(occurrence.subject, code, f"{name} has {count} {text}")


class _Reader:
    """Reads one joint."""

    def __init__(
        self,
        joint: Any,
        name: str,
        occurrence: Occurrence,
        occurrences: Occurrences,
        notes: Notes,
        *,
        as_built: bool = False,
    ) -> None:
        self._joint, self._name, self._occurrence, self._occurrences = (
            joint,
            name,
            occurrence,
            occurrences,
        )
        self._as_built = as_built
        self._notes = notes
        self._subject: Subject = subject_in(occurrence, "joint", name)

    def joint(self) -> JointSnapshot:
        """Return the joint; one that cannot be read reports it itself, and is there to be named."""
        empty = JointSnapshot(self._name, "inferred", None, None, as_built=self._as_built)
        try:
            empty = replace(empty, suppressed=bool(self._joint.isSuppressed))
            empty = replace(empty, problem=problem_of(self._joint, self._subject, self._notes))
            return self._whole(empty)
        except Exception as error:
            self._notes.trace(f"joint {self._name}")
            return replace(empty, problem=empty.problem or f"it cannot be read ({error}). {REMEDY}")

    def _whole(self, joint: JointSnapshot) -> JointSnapshot:
        motion = self._joint.jointMotion
        kind = "inferred" if motion is None else joint_kinds().get(motion.jointType)
        if kind is None:
            return replace(joint, problem=f"Fusion's joint type {motion.jointType} is not known")
        ends = self._ends(broken=bool(joint.problem))
        locked = bool(optional(lambda: self._joint.isLocked))  # as-built joints cannot be
        one, two = (None if end is None else end.path for end in (ends.one, ends.two))
        joint = replace(joint, kind=kind, one=one, two=two, locked=locked)
        if kind == "inferred":
            return joint
        try:
            return self._placed(joint, read_freedoms(kind, motion), ends)
        except Exception:
            if joint.problem or joint.suppressed:  # said already, or of no effect
                return joint
            raise

    def _ends(self, *, broken: bool) -> _Ends:
        one = self._end(self._joint.occurrenceOne, broken)
        two = self._end(self._joint.occurrenceTwo, broken)
        if one is two and one is not None and not broken:
            raise ValueError(f"both sides are {one.path or 'the root component'}")
        return _Ends(one, two)

    def _end(self, native: Any, broken: bool) -> Occurrence | None:
        """One side; null is the component that holds the joint, or lost."""
        occurrence = self._occurrence
        if native is None:
            return None if broken else occurrence
        path = str(native.fullPathName)
        # Below the occurrence that holds the joint, in case the path is not from the root.
        for candidate in (path, f"{occurrence.path}+{path}"):
            if candidate in self._occurrences:
                return self._occurrences[candidate]
        raise ValueError(f"{path} is not in the design, or is left out")

    def _placed(
        self, joint: JointSnapshot, freedoms: tuple[Freedom, ...], ends: _Ends
    ) -> JointSnapshot:
        slides = [f.motion.value for f in freedoms if f.motion.kind == "translation"]
        offset = 0.0 if self._as_built else self._offset()
        here = self._occurrence
        place = Place(here, here.T_first, ends.one or here, ends.two or here)
        if self._as_built:
            frame = as_built_frame(self._joint, place)
            # Which side the one geometry stays with is known only if both are in one place.
            frames = JointFrames(None if any(slides) else frame, frame)
        else:
            reach = math.hypot(*slides) + offset
            frames = joint_frames(self._joint, place, reach)
        self._note_if_apart(joint, frames)
        free = not self._as_built and offset == 0.0 and self._unturned()
        motions = self._motions(joint.kind, freedoms, frames, free)
        return replace(
            joint, origin_one=_origin(frames.one), origin_two=_origin(frames.two), motions=motions
        )

    def _motions(
        self,
        kind: JointKind,
        freedoms: tuple[Freedom, ...],
        frames: JointFrames,
        free: bool,
    ) -> tuple[MotionSnapshot, ...]:
        """Return the motions, with axes in the root frame.

        Args:
            kind: The joint's type.
            freedoms: As Fusion gives them.
            frames: Of the joint.
            free: Whether it has neither offset nor angle, and is not flipped.
        """
        motions = tuple(freedom.motion for freedom in freedoms)
        posed = frames if free else replace(frames, one=None)
        if kind != "ball":
            return signed(motions, posed)
        motions, certain = ball_axes(motions, freedoms[1].along, posed)
        if not certain:
            self._warn(
                "ball-axes-uncertain",
                "its yaw and roll axes are not known at this pose: drive it to zero "
                "(Drive Joints) before the export",
            )
        return motions

    def _offset(self) -> float:
        """How far the sides are apart on purpose, in [m]."""
        joint = self._joint
        values = (
            optional(lambda: joint.offsetX.value),  # since September 2022
            optional(lambda: joint.offsetY.value),
            optional(lambda: joint.offset.value),
        )
        return math.hypot(*(length(value or 0.0) for value in values))

    def _unturned(self) -> bool:
        turned = optional(lambda: finite(self._joint.angle.value) != 0.0)
        return turned is False and not self._joint.isFlipped

    def _note_if_apart(self, joint: JointSnapshot, frames: JointFrames) -> None:
        if frames.apart > 0.0 and not joint.suppressed and not joint.problem:
            self._warn(
                "joint-apart",
                f"its two sides are {1000.0 * frames.apart:.3g} mm apart though it has no offset: "
                "the parts are not where it holds them. Modify > Compute All, or undo the "
                "last move",
            )

    def _warn(self, code: str, message: str) -> None:
        self._notes.warn(self._subject, code, f"joint {self._name!r}: {message}")


def _origin(frame: Transform | None) -> Vector3 | None:
    return None if frame is None else frame.p
