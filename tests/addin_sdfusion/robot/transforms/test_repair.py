from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.robots.random_robots import inertias, vectors

from addin_sdfusion.robot import Inertia, Link, Pose, Robot, Subject, read_robot
from addin_sdfusion.robot.checks.masses import density_matrix, positive_semidefinite
from addin_sdfusion.robot.formats.read import read
from addin_sdfusion.robot.model.rotations import point_inertia
from addin_sdfusion.robot.transforms.repair import about_com, diagnose, repair

PUBLISHED = {
    # robot: (links repaired, links left as they are, radii of gyration after repair)
    "msj_platform": (4, 0, {"top": 0.036}),
    "roboy_upper_body": (27, 5, {"upper_arm_left": 0.076}),
    "test_robot": (7, 0, {"link5": 0.075}),
    "VRpuppet": (11, 0, {"motor0": 0.040}),
    "exosuit": (3, 0, {"lowerarm": 0.060}),
    "roboy_icecream": (24, 2, {"head": 0.144}),
    "musc-le": (0, 0, {}),
}
SWAPPED = ("msj_platform", "roboy_upper_body", "test_robot")


def gyration(inertia):
    """Return the radius of gyration from the trace, which is invariant to rotations, in [m]."""
    return math.sqrt((inertia.ixx + inertia.iyy + inertia.izz) / 2 / inertia.mass)


def named(findings, code):
    return [finding for finding in findings if finding.code == code]


@pytest.mark.parametrize("name", PUBLISHED)
def test_published_inertias_are_detected_and_repaired(shared, name):
    repaired, left, radii = PUBLISHED[name]
    folder = shared / "robots/cardsflow" / name
    found = read(folder).findings
    assert bool(named(found, "inertia-about-origin")) == bool(repaired)
    assert bool(named(found, "inertia-xz-yz-swapped")) == (name in SWAPPED)
    again = read(folder, repair=True)
    assert not named(again.findings, "inertia-about-origin")
    reported = named(again.findings, "repaired-inertia")
    assert (len(reported), len(named(again.findings, "inertia-not-repaired"))) == (repaired, left)
    assert all(finding.file.name == "model.sdf" and finding.line for finding in reported)
    if again.robot is not None:
        bodies = {finding.subject.name for finding in reported}
        for link in again.robot.links:
            if link.name in bodies:
                assert positive_semidefinite(density_matrix(link.inertia.matrix))
            if link.name in radii:
                assert gyration(link.inertia) == pytest.approx(radii[link.name], abs=1e-3)


def test_repair_is_only_applied_on_request(shared):
    folder = shared / "robots/cardsflow/msj_platform"
    assert read_robot(folder) != read_robot(folder, repair=True)
    assert gyration(read_robot(folder).link("top").inertia) == pytest.approx(0.179, abs=1e-3)


def test_robots_without_the_defect_are_unchanged(shared):
    folder = shared / "robots/caspr/RoboyLeftArm"
    assert read_robot(folder, repair=True) == read_robot(folder)


def about_origin(inertia, r, swapped):
    """Return an inertia with the defect of the published exporter."""
    matrix = np.array(inertia.matrix) + np.array(point_inertia(inertia.mass, r))
    xz, yz = (matrix[1, 2], matrix[0, 2]) if swapped else (matrix[0, 2], matrix[1, 2])
    diagonal = {"ixx": matrix[0, 0], "iyy": matrix[1, 1], "izz": matrix[2, 2]}
    numbers = {**diagonal, "ixy": matrix[0, 1], "ixz": xz, "iyz": yz}
    return replace(inertia, **{key: float(value) for key, value in numbers.items()})


def centred(inertia):
    return replace(inertia, com=(0.0, 0.0, 0.0))


@given(inertias(), vectors, st.booleans())
def test_repair_restores_the_original_inertia(inertia, r, swapped):
    back = about_com(about_origin(inertia, r, swapped), r, swapped)
    np.testing.assert_allclose(back.matrix, inertia.matrix, atol=1e-10)


body = inertias().map(centred)
arms = st.tuples(*[st.floats(3.0, 9.0)] * 3)


@given(st.lists(st.tuples(body, arms), min_size=3, max_size=6), st.booleans())
def test_valid_inertias_are_never_detected_as_defective(parts, far):
    """Bodies with an inertia about the centre of mass, near the origin or far away."""
    parts = [(i, r if far else (0.0, 0.0, 0.0)) for i, r in parts]
    small = [replace(i, mass=10.0 * i.mass + 1.0) for i, _ in parts]
    links = [Link(f"l{k}", i) for k, i in enumerate(small)]
    assert diagnose(links, [Pose(r) for _, r in parts]) is None


@pytest.mark.slow
@given(st.lists(st.tuples(body, arms), min_size=2, max_size=6))
def test_inertias_about_the_origin_are_repaired_per_link(parts):
    links = [Link(f"l{k}", about_origin(i, r, False)) for k, (i, r) in enumerate(parts)]
    robot = Robot("r", tuple(links), ())
    diagnosis = diagnose(links, [Pose(r) for _, r in parts])
    if any(gyration(i) > 2.0 for i, _ in parts):  # too large for an error at this distance
        return
    assert diagnosis is not None
    repaired, findings = repair(robot, diagnosis)
    assert [f.subject for f in findings] == [Subject("link", link.name) for link in links]
    if not diagnosis.swapped:
        for link, (inertia, _) in zip(repaired.links, parts, strict=True):
            np.testing.assert_allclose(link.inertia.matrix, inertia.matrix, atol=1e-8)


def test_frames_of_other_exporters_are_not_evidence():
    inertia = about_origin(Inertia(1.0, ixx=0.1, iyy=0.1, izz=0.1), (5.0, 5.0, 5.0), False)
    pose = Pose((5.0, 5.0, 5.0))
    assert diagnose([Link("a", inertia)], [pose]) is not None
    assert diagnose([Link("a", inertia)], [replace(pose, rpy=(0.1, 0.0, 0.0))]) is None
    assert diagnose([Link("a", replace(inertia, com=(0.1, 0.0, 0.0)))], [pose]) is None
