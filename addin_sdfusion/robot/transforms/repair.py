"""Diagnosis and repair of the inertias of published CARDSFlow models.

Their exporter wrote each tensor about the origin of the design, although the file says that it is
about the centre of mass; older exports have ixz and iyz swapped as well. One file was made by one
version of the exporter, so the defect belongs to a file, not to a link.

Evidence: all frames of such a file are at the centres of mass and parallel to the design's,
and a link far from the origin (r at least `FAR` of its radius of gyration as stored) has a tensor
that is mostly that of a mass point at r. Such a link speaks for the defect if what remains after
m (r² 1 - r rᵀ) is taken away is the inertia of a body, which needs six numbers to agree by chance
where the tensor is right, and against it if not. The defect is there if half of the links far
enough away speak for it; xz and yz are swapped if that explains more links.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

from ..checks.masses import density_matrix, positive_semidefinite
from ..finding import Finding, Subject
from ..finding_builders import finite, listed, warning
from ..model.pose import Pose, Vector3
from ..model.robot import Inertia, Link, Robot
from ..model.rotations import Matrix3, point_inertia, subtract

FAR = 0.7
"""Least distance from the origin of a link that is evidence, over its stored radius of gyration."""
UNDONE = "--repair undoes it"
"""How, in words of the command line; `read(..., repair=True)` in Python."""
ENOUGH = 0.5
"""Share of the far links that must speak for the defect."""


@dataclass(frozen=True)
class Diagnosis:
    """What is wrong with the inertias of a file.

    Attributes:
        swapped: Whether ixz and iyz are swapped.
        arms: For each link, from the origin of the design to its centre of mass, in [m].
        explained: Names of the links whose tensor is explained by the defect only.
    """

    swapped: bool
    arms: tuple[Vector3, ...]
    explained: tuple[str, ...]

    def findings(self, subject: Subject) -> list[Finding]:
        """Return the defect in words: one finding, or two where products are swapped too."""
        who = f"of {len(self.explained)} links ({listed(self.explained, 3)})"
        problem = (
            f"the inertias {who} are about the origin of the design, not about the centre of mass; "
            f"{UNDONE}"
        )
        found = [warning(subject, "inertia-about-origin", problem)]
        if self.swapped:
            problem = f"ixz and iyz {who} are swapped; {UNDONE}"
            found.append(warning(subject, "inertia-xz-yz-swapped", problem))
        return found


def diagnose(links: Sequence[Link], poses: Sequence[Pose]) -> Diagnosis | None:
    """Return whether the inertias of a file are about the origin of the design.

    Returns:
        None if they are not, or if there is no evidence.
    """
    if any(any(link.inertia.com) or any(pose.rpy) for link, pose in zip(links, poses, strict=True)):
        return None
    arms = tuple(pose.position for pose in poses)
    far = [(link, r) for link, r in zip(links, arms, strict=True) if _is_far(link.inertia, r)]
    explained = {
        swapped: [link.name for link, r in far if _is_body(about_com(link.inertia, r, swapped))]
        for swapped in (False, True)
    }
    swapped = len(explained[True]) > len(explained[False])
    names = explained[swapped]
    if not names or len(names) < ENOUGH * len(far):
        return None
    return Diagnosis(swapped, arms, tuple(names))


def repair(robot: Robot, diagnosis: Diagnosis) -> tuple[Robot, list[Finding]]:
    """Undo the defect in every link of a file.

    A link whose tensor would then be that of no body, because its mass was changed by hand, say, is
    left as it is.

    Returns:
        The repaired robot, and a finding for every link.
    """
    links, findings = [], []
    for link, r in zip(robot.links, diagnosis.arms, strict=True):
        subject, inertia = Subject("link", link.name), about_com(link.inertia, r, diagnosis.swapped)
        if not _is_body(inertia):
            problem = (
                "its inertia is not repaired: about the centre of mass no body would have it; "
                "take mass and inertia from the design again"
            )
            findings.append(warning(subject, "inertia-not-repaired", problem))
        elif inertia != link.inertia:
            swap = ", ixz and iyz swapped back" if diagnosis.swapped else ""
            before, after = (_gyration(i) for i in (link.inertia, inertia))
            problem = (
                f"inertia moved from the origin of the design to the centre of mass{swap}; "
                f"radius of gyration {before:.3g} m became {after:.3g} m"
            )
            findings.append(warning(subject, "repaired-inertia", problem))
            link = replace(link, inertia=inertia)
        links.append(link)
    return replace(robot, links=tuple(links)), findings


def about_com(inertia: Inertia, r: Vector3, swapped: bool) -> Inertia:
    """Return the inertia about the centre of mass, from one about the origin of the design.

    Args:
        inertia: As stored.
        r: From that origin to the centre of mass, in [m].
        swapped: Whether ixz and iyz are swapped.
    """
    if swapped:
        inertia = replace(inertia, ixz=inertia.iyz, iyz=inertia.ixz)
    x, y, z = map(subtract, inertia.matrix, point_inertia(inertia.mass, r))
    return Inertia.of(inertia.mass, inertia.com, (x, y, z))


def _is_far(inertia: Inertia, r: Vector3) -> bool:
    if not finite(_flat((r, *inertia.matrix))) or not 0.0 < inertia.mass < math.inf:
        return False
    return 0.0 < FAR * _gyration(inertia) <= math.hypot(*r)


def _gyration(inertia: Inertia) -> float:
    """Return the radius of gyration, √(½ tr I / m), in [m]; zero if there is none."""
    square = 0.5 * (inertia.ixx + inertia.iyy + inertia.izz)
    return math.sqrt(square / inertia.mass) if square > 0.0 and inertia.mass > 0.0 else 0.0


def _is_body(inertia: Inertia) -> bool:
    matrix: Matrix3 = inertia.matrix
    return finite(_flat(matrix)) and positive_semidefinite(density_matrix(matrix))


def _flat(rows: Iterable[Vector3]) -> list[float]:
    return [entry for row in rows for entry in row]
