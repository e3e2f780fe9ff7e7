"""Diagnosis and repair of the inertias of published CARDSFlow models.

Their exporter wrote each tensor about the origin of the design, although the file format requires
the tensor about the centre of mass. Older exports also swap ixz and iyz. One version of the
exporter wrote each file, so the defect applies to all links of a file.

Evidence: all frames of such a file are at the centres of mass and parallel to the frame of the
design. The tensor of a link far from the origin (r at least `FAR` times its stored radius of
gyration) is mostly the tensor of a point mass at r. A link is evidence for the defect if the tensor
minus m (r² 1 - r rᵀ) is physically possible; for a correct tensor this would be a coincidence of
six numbers. Otherwise the link is evidence against the defect. The defect exists if at least half
of the far links are evidence for it. xz and yz are swapped if this explains more links.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from ..checks.masses import density_matrix, positive_semidefinite
from ..finding import Finding, Subject
from ..finding_builders import finite, listed, warning
from ..model.pose import Pose, Vector3
from ..model.robot import Inertia, Link, Robot

FAR = 0.7
"""Minimum distance of a link from the origin to be evidence, over its stored radius of gyration."""
REPAIR_HINT = "use --repair to correct them"
"""Hint for the command line; in Python use `read(..., repair=True)`."""
ENOUGH = 0.5
"""Fraction of the far links that must be evidence for the defect."""


@dataclass(frozen=True)
class Diagnosis:
    """Diagnosis of the inertias of a file.

    Attributes:
        swapped: Whether ixz and iyz are swapped.
        arms: Vectors from the origin of the design to each link's centre of mass, in [m].
        explained: Names of the links whose tensors only the defect can explain.
    """

    swapped: bool
    arms: tuple[Vector3, ...]
    explained: tuple[str, ...]

    def findings(self, subject: Subject) -> list[Finding]:
        """Return one finding, or two if the products of inertia are swapped too."""
        links = f"of {len(self.explained)} links ({listed(self.explained, 3)})"
        problem = (
            f"the inertias {links} are about the origin of the design, not about the centre of "
            f"mass; {REPAIR_HINT}"
        )
        findings = [warning(subject, "inertia-about-origin", problem)]
        if self.swapped:
            problem = f"ixz and iyz {links} are swapped; {REPAIR_HINT}"
            findings.append(warning(subject, "inertia-xz-yz-swapped", problem))
        return findings


def diagnose(links: Sequence[Link], poses: Sequence[Pose]) -> Diagnosis | None:
    """Diagnose whether the inertias of a file are about the origin of the design.

    Returns:
        The diagnosis, or None if the inertias are correct or evidence is missing.
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
    """Repair the inertia of every link of a file.

    If the repaired tensor of a link is physically impossible, for example since its mass was edited
    manually, the link is not changed.

    Returns:
        The repaired robot, and a finding for every link.
    """
    links, findings = [], []
    for link, r in zip(robot.links, diagnosis.arms, strict=True):
        subject, inertia = Subject("link", link.name), about_com(link.inertia, r, diagnosis.swapped)
        if not _is_body(inertia):
            problem = (
                "its inertia is not repaired, since the result would be physically impossible; "
                "export mass and inertia from the design again"
            )
            findings.append(warning(subject, "inertia-not-repaired", problem))
        elif inertia != link.inertia:
            swap = ", ixz and iyz swapped back" if diagnosis.swapped else ""
            before, after = (i.radius_of_gyration for i in (link.inertia, inertia))
            problem = (
                f"inertia moved from the origin of the design to the centre of mass{swap}; "
                f"radius of gyration {before:.3g} m became {after:.3g} m"
            )
            findings.append(warning(subject, "repaired-inertia", problem))
            link = replace(link, inertia=inertia)
        links.append(link)
    return replace(robot, links=tuple(links)), findings


def about_com(inertia: Inertia, r: Vector3, swapped: bool) -> Inertia:
    """Convert an inertia about the origin of the design to one about the centre of mass.

    Args:
        inertia: Stored inertia.
        r: Vector from the origin to the centre of mass, in [m].
        swapped: Whether ixz and iyz are swapped.
    """
    if swapped:
        inertia = replace(inertia, ixz=inertia.iyz, iyz=inertia.ixz)
    return replace(Inertia.of_origin(inertia.mass, r, inertia.matrix), com=inertia.com)


def _is_far(inertia: Inertia, r: Vector3) -> bool:
    if not finite((*r, *inertia.entries)) or not 0.0 < inertia.mass < math.inf:
        return False
    return 0.0 < FAR * inertia.radius_of_gyration <= math.hypot(*r)


def _is_body(inertia: Inertia) -> bool:
    is_finite = finite(inertia.entries)
    return is_finite and positive_semidefinite(density_matrix(inertia.matrix))
