"""Tests of masses of links: closed forms, signs, and masses set by the user."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation
from support.designs.design_strategies import mass_of, shift
from support.designs.small_designs import arm, body, box, cylinder, group, part, turned

from addin_sdfusion.building.build_robot import build_robot
from addin_sdfusion.robot import Finding, Inertia
from addin_sdfusion.snapshot import DesignSnapshot
from addin_sdfusion.snapshot.eigenvalues import eigenvalues
from addin_sdfusion.snapshot.mass_properties import common_sign, sign_of

PRODUCT_SIGNS = pytest.mark.parametrize("sign", [1, -1])


def one_link(bodies: Any, occurrences: Any = (), **more: Any) -> DesignSnapshot:
    given = occurrences or (part("arm:1"),)
    return DesignSnapshot(
        "arm", occurrences=given, bodies=tuple(bodies), groups=(group("arm"),), **more
    )


def only_inertia(snapshot: DesignSnapshot) -> tuple[Inertia, tuple[Finding, ...]]:
    made = build_robot(snapshot)
    assert made.robot is not None, made.findings
    (link,) = made.robot.links
    return link.inertia, made.findings


def codes(findings: Any) -> list[str]:
    return [f.code for f in findings if f.code != "no-muscles"]


def close(inertia: Inertia, mass: float, com: Any, J: Any, atol: float = 1e-12) -> None:
    assert inertia.mass == pytest.approx(mass, rel=1e-12)
    np.testing.assert_allclose(inertia.com, com, atol=1e-12)
    np.testing.assert_allclose(inertia.matrix, J, rtol=1e-9, atol=atol)


@given(st.lists(st.floats(-100.0, 100.0), min_size=6, max_size=6), st.floats(-12.0, 6.0))
def test_eigenvalues_are_those_of_numpy(entries: list[float], decade: float) -> None:
    a, b, c, d, e, f = (10.0**decade * entry for entry in entries)
    A = ((a, d, e), (d, b, f), (e, f, c))
    expected = np.linalg.eigvalsh(np.array(A))
    np.testing.assert_allclose(eigenvalues(A), expected, atol=1e-13 * np.abs(expected).max())


@pytest.mark.parametrize("values", [(1, 1, 1), (1, 1, 2), (0, 0, 3), (0, 0, 0), (1e-20, 1, 1)])
def test_equal_and_zero_eigenvalues_are_found(values: Any) -> None:
    R = Rotation.from_rotvec([0.3, -0.7, 1.1]).as_matrix()
    A = R @ np.diag(values) @ R.T
    rows = tuple(tuple(map(float, row)) for row in 0.5 * (A + A.T))
    np.testing.assert_allclose(eigenvalues(rows), sorted(values), atol=1e-14)


@PRODUCT_SIGNS
def test_inertia_of_a_rotated_and_translated_box(sign: int) -> None:
    R = Rotation.from_rotvec([0.4, 0.2, -0.9]).as_matrix()
    drawn = turned(box((0.1, 0.2, 0.4), (0.3, -0.2, 0.5), 2.0), R)
    inertia, findings = only_inertia(one_link([body("arm:1", drawn, sign=sign)]))
    close(inertia, *drawn)
    assert codes(findings) == []


@PRODUCT_SIGNS
def test_inertia_of_a_cylinder_away_from_the_origin(sign: int) -> None:
    drawn = cylinder(0.03, 0.4, (0.5, 0.4, -0.3), 1.7, axis=1)
    inertia, _ = only_inertia(one_link([body("arm:1", drawn, sign=sign)]))
    close(inertia, *drawn)


@PRODUCT_SIGNS
def test_inertia_of_several_bodies_follows_the_parallel_axis_theorem(sign: int) -> None:
    long = box((0.4, 0.1, 0.1), (0.2, 0.05, 0.05), 4.0)
    short = box((0.1, 0.2, 0.1), (0.35, 0.2, 0.05), 2.0)
    pin = cylinder(0.01, 0.1, (0.02, 0.05, 0.05), 0.03, axis=2)
    mass = 6.03
    com = (4.0 * long[1] + 2.0 * short[1] + 0.03 * pin[1]) / mass
    J = sum(each[2] + shift(each[0], each[1] - com) for each in (long, short, pin))
    bodies = [body("arm:1", each, f"B{k}", sign) for k, each in enumerate((long, short, pin))]
    inertia, _ = only_inertia(one_link(bodies))
    close(inertia, mass, com, J)


def test_an_ambiguous_sign_is_taken_from_the_other_bodies() -> None:
    centred = turned(box((0.1, 0.3, 0.2)), Rotation.from_rotvec([0.0, 0.0, 0.5]).as_matrix())
    clear = box((0.1, 0.2, 0.4), (0.3, -0.2, 0.5), 2.0)
    for sign in (1, -1):
        assert sign_of(mass_of([centred], sign)) is None
        assert sign_of(mass_of([clear], sign)) == sign
        bodies = [body("arm:1", centred, "A", sign), body("arm:1", clear, "B", sign)]
        com = 2.0 / 3.0 * clear[1]
        J = sum(each[2] + shift(each[0], each[1] - com) for each in (centred, clear))
        close(only_inertia(one_link(bodies))[0], 3.0, com, J)
    assert common_sign([]) == 1


def test_moments_that_fit_neither_sign_are_reported() -> None:
    drawn = body("arm:1", box((0.1, 0.2, 0.4), (0.3, -0.2, 0.5)))
    assert drawn.mass is not None
    wrong = replace(drawn.mass, principal=(0.1, 0.1, 0.1))
    _, findings = only_inertia(one_link([replace(drawn, mass=wrong)]))
    assert codes(findings) == ["inertia-mismatch"]


def test_a_mass_set_for_a_component_is_used() -> None:
    drawn = box((0.1, 0.2, 0.4), (0.1, 0.0, 0.0), 2.0)
    heavy = 5.0, drawn[1], 2.5 * drawn[2]
    below = part("arm:1+pin:1", "arm:1")
    whole = part("arm:1", mass=mass_of([heavy]))
    inertia, _ = only_inertia(one_link([body("arm:1+pin:1", drawn)], (whole, below)))
    close(inertia, *heavy)


def test_a_component_divided_between_links_uses_the_body_masses() -> None:
    arm_box, hand_box = box((0.1, 0.1, 0.4), (0, 0, 0.2), 2.0), box((0.1, 0.1, 0.1), (0, 0, 0.5))
    both = part("arm:1", mass=mass_of([arm_box, hand_box]), grounded=True)
    hand = part("arm:1+hand:1", "arm:1", mass=mass_of([hand_box]), grounded=True)
    bodies = (body("arm:1", arm_box), body("arm:1+hand:1", hand_box))
    groups = (group("arm"), group("hand", "arm:1+hand:1"))
    made = build_robot(
        DesignSnapshot("arm", occurrences=(both, hand), bodies=bodies, groups=groups)
    )
    assert made.robot is not None
    close(made.robot.link("arm").inertia, *arm_box)
    close(made.robot.link("hand").inertia, *hand_box)
    assert codes(made.findings) == []
    assert made.robot.joint("arm_hand").type == "fixed"

    overridden = replace(both, mass=mass_of([box((0.1, 0.1, 0.4), (0, 0, 0.2), 9.0)]))
    again = build_robot(
        DesignSnapshot("arm", occurrences=(overridden, hand), bodies=bodies, groups=groups)
    )
    assert codes(again.findings) == ["mass-not-divided"]


def test_a_link_in_two_branches_includes_each_branch_once() -> None:
    paths = ("a:1", "a:1+b:1", "a:1+b:1+c:1")
    occurrences = (
        part(paths[0], grounded=True),
        part(paths[1], paths[0], grounded=True),
        part(paths[2], paths[1]),
    )
    boxes = [box((0.1, 0.1, 0.1), (0.1 * k, 0, 0), 1.0 + k) for k in range(3)]
    made = build_robot(
        DesignSnapshot(
            "arm",
            occurrences=occurrences,
            bodies=tuple(body(p, b) for p, b in zip(paths, boxes, strict=True)),
            groups=(group("x", paths[0], paths[2]), group("y", paths[1])),
        )
    )
    assert made.robot is not None, made.findings
    assert made.robot.link("x").inertia.mass == pytest.approx(4.0)
    assert made.robot.link("y").inertia.mass == pytest.approx(2.0)


def test_a_link_of_the_root_and_a_component_includes_both_masses() -> None:
    bodies = [
        body("", box((0.1, 0.1, 0.1)), "Plate"),
        body("arm:1", box((0.1, 0.1, 0.1), mass=2.0)),
    ]
    snapshot = replace(one_link(bodies), groups=(group("arm", "", "arm:1"),))
    assert only_inertia(snapshot)[0].mass == pytest.approx(3.0)


def test_parts_of_a_microgram_keep_full_precision() -> None:
    drawn = box((1e-4, 2e-4, 3e-4), (0.01, 0.02, 0.0), 1e-9)
    inertia, findings = only_inertia(one_link([body("arm:1", drawn)]))
    close(inertia, *drawn, atol=1e-30)
    assert codes(findings) == []


def test_hidden_bodies_are_included_in_the_mass_and_reported() -> None:
    drawn = box((0.1, 0.2, 0.3))
    inertia, findings = only_inertia(one_link([body("arm:1", drawn, visible=False)]))
    close(inertia, *drawn)
    assert codes(findings) == ["hidden-body"]


@pytest.mark.parametrize("kind", ["surface", "mesh"])
def test_surface_and_mesh_bodies_have_no_mass_and_are_reported(kind: str) -> None:
    drawn = box((0.1, 0.2, 0.3))
    sheet = body("arm:1", name="Sheet", kind=kind, mass=None)
    inertia, findings = only_inertia(one_link([body("arm:1", drawn), sheet]))
    close(inertia, *drawn)
    (finding,) = (f for f in findings if f.code == f"{kind}-body")
    assert finding.subject == ("body", "arm:1/Sheet")


def test_a_solid_without_material_is_reported() -> None:
    bare = body("arm:1", name="Bare", mass=None, material="")
    _, findings = only_inertia(one_link([body("arm:1"), bare]))
    assert codes(findings) == ["no-mass"]
    broken = replace(mass_of([box((1, 1, 1))]), mass=float("nan"))
    _, findings = only_inertia(one_link([body("arm:1"), body("arm:1", name="N", mass=broken)]))
    assert codes(findings) == ["no-mass"]


def test_bodies_of_links_are_those_of_their_components() -> None:
    made = build_robot(arm())
    assert {
        link: [b.occurrence for b in bodies] for link, bodies in made.bodies_of_link.items()
    } == {
        "base": ["base:1"],
        "lower": ["lower:1"],
        "upper": ["upper:1"],
    }
