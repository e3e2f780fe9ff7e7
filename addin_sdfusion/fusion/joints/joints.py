"""Joints and as-built joints of an occurrence, in the root frame.

They are read component by component, because `allJoints` of the root fails with an internal error
if a design has assembly constraints. Joints of sub-assemblies are read through proxies, since the
geometry of native joints is null.
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
from .axes import ball_axes, correct_signs
from .frames import JointFrames, Place, as_built_frame, joint_frames
from .motions import Freedom, joint_kinds, read_freedoms

REMEDY = "Modify > Compute All; if that does not help, create the joint again"


@dataclass(frozen=True)
class _Ends:
    """The two occurrences that a joint connects; None if unknown."""

    one: Occurrence | None
    two: Occurrence | None


def read_joints(
    occurrence: Occurrence, occurrences: Occurrences, notes: Notes
) -> Iterator[JointSnapshot]:
    """Yield the joints of the component of an occurrence."""
    component = occurrence.component
    for _, name, joint in each_in(occurrence, lambda: component.joints, notes, "joint"):
        yield _Reader(joint, name, occurrence, occurrences, notes).joint()
    for _, name, joint in each_in(occurrence, lambda: component.asBuiltJoints, notes, "joint"):
        yield _Reader(joint, name, occurrence, occurrences, notes, as_built=True).joint()
    _note_others(occurrence, notes)


def _note_others(occurrence: Occurrence, notes: Notes) -> None:
    """Warn of other relations between parts, which are not exported."""
    component = occurrence.component
    name = occurrence.path or "the root component"
    for code, count, text in (
        (
            "assembly-constraints",
            optional(lambda: int(component.assemblyConstraints.count)),  # since July 2025
            "assembly constraints, which have no axes and no limits: replace them with joints "
            "(Assemble > Joint) between parts that move",
        ),
        (
            "tangent-relationships",
            optional(lambda: int(component.tangentRelationships.count)),  # since May 2022
            "tangent relationships, which robot models do not support: replace them with joints "
            "(Assemble > Joint) between faces that slide or roll on each other",
        ),
    ):
        if count:
            notes.warn(occurrence.subject, code, f"{name} has {count} {text}")


class _Reader:
    """Reader for one joint."""

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
        """Return the joint; if it cannot be read, return a joint with this problem."""
        empty = JointSnapshot(self._name, "inferred", None, None, as_built=self._as_built)
        try:
            empty = replace(empty, suppressed=bool(self._joint.isSuppressed))
            empty = replace(empty, problem=problem_of(self._joint, self._subject, self._notes))
            return self._read_joint(empty)
        except Exception as error:
            self._notes.trace(f"joint {self._name}")
            return replace(empty, problem=empty.problem or f"it cannot be read ({error}). {REMEDY}")

    def _read_joint(self, joint: JointSnapshot) -> JointSnapshot:
        motion = self._joint.jointMotion
        kind = "inferred" if motion is None else joint_kinds().get(motion.jointType)
        if kind is None:
            return replace(joint, problem=f"unknown joint type {motion.jointType} of Fusion")
        ends = self._ends(broken=bool(joint.problem))
        locked = bool(optional(lambda: self._joint.isLocked))  # as-built joints have no lock
        one, two = (None if end is None else end.path for end in (ends.one, ends.two))
        joint = replace(joint, kind=kind, one=one, two=two, locked=locked)
        if kind == "inferred":
            return joint
        try:
            return self._with_frames(joint, read_freedoms(kind, motion), ends)
        except Exception:
            if joint.problem or joint.suppressed:  # reported already, or not exported
                return joint
            raise

    def _ends(self, *, broken: bool) -> _Ends:
        one = self._end(self._joint.occurrenceOne, broken)
        two = self._end(self._joint.occurrenceTwo, broken)
        if one is two and one is not None and not broken:
            raise ValueError(f"both sides are {one.path or 'the root component'}")
        return _Ends(one, two)

    def _end(self, native: Any, broken: bool) -> Occurrence | None:
        """Return one side of the joint.

        A null value is the component that contains the joint, or unknown if the joint is broken.
        """
        occurrence = self._occurrence
        if native is None:
            return None if broken else occurrence
        path = str(native.fullPathName)
        # The path may be relative to the occurrence that contains the joint.
        for candidate in (path, f"{occurrence.path}+{path}"):
            if candidate in self._occurrences:
                return self._occurrences[candidate]
        raise ValueError(f"{path} is not in the design or is not exported")

    def _with_frames(
        self, joint: JointSnapshot, freedoms: tuple[Freedom, ...], ends: _Ends
    ) -> JointSnapshot:
        slides = [f.motion.value for f in freedoms if f.motion.kind == "translation"]
        offset = 0.0 if self._as_built else self._offset()
        owner = self._occurrence
        place = Place(owner, owner.T_first, ends.one or owner, ends.two or owner)
        if self._as_built:
            frame = as_built_frame(self._joint, place)
            # The geometry moves with an unknown side, so the sides must coincide.
            frames = JointFrames(None if any(slides) else frame, frame)
        else:
            reach = math.hypot(*slides) + offset
            frames = joint_frames(self._joint, place, reach)
        self._note_if_apart(joint, frames)
        free = not self._as_built and offset == 0.0 and self._has_no_angle()
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
            freedoms: Degrees of freedom as reported by Fusion.
            free: Whether the joint has no offset and no angle and is not flipped.
        """
        motions = tuple(freedom.motion for freedom in freedoms)
        posed = frames if free else replace(frames, one=None)
        if kind != "ball":
            return correct_signs(motions, posed)
        motions, certain = ball_axes(motions, freedoms[1].along, posed)
        if not certain:
            self._warn(
                "ball-axes-uncertain",
                "its yaw and roll axes are unknown at this pose: drive it to zero (Drive Joints) "
                "before the export",
            )
        return motions

    def _offset(self) -> float:
        """Return the distance of the sides because of offsets, in [m]."""
        joint = self._joint
        values = (
            optional(lambda: joint.offsetX.value),  # since September 2022
            optional(lambda: joint.offsetY.value),
            optional(lambda: joint.offset.value),
        )
        return math.hypot(*(length(value or 0.0) for value in values))

    def _has_no_angle(self) -> bool:
        turned = optional(lambda: finite(self._joint.angle.value) != 0.0)
        return turned is False and not self._joint.isFlipped

    def _note_if_apart(self, joint: JointSnapshot, frames: JointFrames) -> None:
        if frames.apart > 0.0 and not joint.suppressed and not joint.problem:
            self._warn(
                "joint-apart",
                f"its two sides are {1000.0 * frames.apart:.3g} mm apart although it has no "
                "offset. Modify > Compute All, or undo the last move",
            )

    def _warn(self, code: str, message: str) -> None:
        self._notes.warn(self._subject, code, f"joint {self._name!r}: {message}")


def _origin(frame: Transform | None) -> Vector3 | None:
    return None if frame is None else frame.p
