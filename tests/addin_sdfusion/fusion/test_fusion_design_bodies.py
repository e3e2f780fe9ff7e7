"""Tests of reading bodies: masses and meshes compared with closed forms."""

from __future__ import annotations

import json
import math
import random
from typing import Any

import fake_fusion
import numpy as np
import pytest
import trimesh
from fake_fusion import Builder, designs
from fake_fusion.base import CLASSES
from fake_fusion.maths import rotation, translation
from hypothesis import given
from hypothesis import strategies as st
from support.designs.drawn import tensor

from addin_sdfusion.snapshot import BodySnapshot, DesignSnapshot, MeshSnapshot

with fake_fusion.modules():
    from addin_sdfusion.fusion.design import read_design

API = CLASSES["adsk.fusion"]
STEEL = 7850.0
SIZES = st.floats(0.1, 50.0)
SEEDS = st.integers(0, 2**32)


def one_body(snapshot: DesignSnapshot) -> BodySnapshot:
    (body,) = snapshot.bodies
    return body


def solid(mesh: MeshSnapshot) -> Any:
    nodes = np.array(mesh.nodes).reshape(-1, 3)
    return trimesh.Trimesh(nodes, np.array(mesh.triangles).reshape(-1, 3), process=False)


def codes(snapshot: DesignSnapshot) -> list[str]:
    return [finding.code for finding in snapshot.findings]


# Mass --------------------------------------------------------------------------------------------


@given(SIZES, SIZES, SIZES, SEEDS, st.sampled_from(["tensor", "integral"]))
def test_box_mass_equals_closed_form(a: float, b: float, c: float, seed: int, sign: Any) -> None:
    with fake_fusion.install() as fake:
        fake.options.product_sign = sign
        order = random.Random(seed)
        build = Builder()
        path = designs.nested_place(build, "box", designs.random_motion(order), order, 2)
        T = designs.random_motion(order)
        build.box(path, (a, b, c), T)
        snapshot = read_design(build.done(), meshes=False)
    T = path[0].T @ path[1].T @ path[2].T @ T
    a, b, c = 0.01 * a, 0.01 * b, 0.01 * c
    m = STEEL * a * b * c
    R, r = T[:3, :3], 0.01 * T[:3, 3]
    moments = m / 12.0 * np.array([b * b + c * c, a * a + c * c, a * a + b * b])
    I = R @ np.diag(moments) @ R.T + m * (r @ r * np.eye(3) - np.outer(r, r))  # noqa: E741
    flip = 1.0 if sign == "tensor" else -1.0
    expected = [*np.diag(I), flip * I[0, 1], flip * I[1, 2], flip * I[0, 2]]
    (whole,) = (o for o in snapshot.occurrences if o.component == "box")
    for mass in (one_body(snapshot).mass, whole.mass):
        assert mass is not None
        assert mass.mass == pytest.approx(m, rel=1e-9)
        assert mass.com == pytest.approx(r, abs=1e-12)
        assert mass.moments == pytest.approx(expected, rel=1e-9, abs=1e-9 * max(expected))
        assert sorted(mass.principal) == pytest.approx(
            sorted(moments), rel=1e-9, abs=1e-12 * max(expected)
        )


@given(SIZES, SIZES)
def test_cylinder_mass_equals_closed_form(radius: float, height: float) -> None:
    with fake_fusion.install():
        build = Builder()
        build.cylinder((), radius, height, rotation(math.pi / 2, (0.0, 1.0, 0.0)))
        mass = one_body(read_design(build.done(), meshes=False)).mass
    assert mass is not None
    r, h = 0.01 * radius, 0.01 * height
    m = STEEL * math.pi * r * r * h
    across = m * (3.0 * r * r + h * h) / 12.0
    assert mass.mass == pytest.approx(m, rel=1e-9)
    assert mass.moments[:3] == pytest.approx((m * r * r / 2.0, across, across), rel=1e-9)


def test_l_shape_of_two_bodies_equals_closed_form(fusion: Any) -> None:
    """A plate of 2x3x10 cm and a foot of 6x3x2 cm, with a manual parallel-axis calculation."""
    snapshot = read_design(designs.l_shape(), meshes=False)
    (lower,) = (o for o in snapshot.occurrences if o.component == "lower")
    assert lower.mass is not None
    sizes = np.array([(0.02, 0.03, 0.10), (0.06, 0.03, 0.02)])
    centres = np.array([(0.0, 0.0, 0.25), (0.04, 0.0, 0.21)])
    m = STEEL * sizes.prod(axis=1)
    com = m @ centres / m.sum()
    I = np.zeros((3, 3))  # noqa: E741
    for mass, size, centre in zip(m, sizes, centres, strict=True):
        r = centre - com
        I += mass / 12.0 * (size @ size * np.eye(3) - np.diag(size**2))  # noqa: E741
        I += mass * (r @ r * np.eye(3) - np.outer(r, r))  # noqa: E741
    assert lower.mass.mass == pytest.approx(m.sum(), rel=1e-9)
    assert lower.mass.com == pytest.approx(com, rel=1e-9, abs=1e-12)
    assert tensor(lower.mass) == pytest.approx(I, rel=1e-9, abs=1e-12)
    assert sorted(lower.mass.principal) == pytest.approx(np.linalg.eigvalsh(I), rel=1e-9)
    bodies = [b.mass.mass for b in snapshot.bodies if b.occurrence == "lower:1" and b.mass]
    assert bodies == pytest.approx(m, rel=1e-9)


def test_mass_set_by_the_user_is_the_mass_of_the_occurrence(fusion: Any) -> None:
    snapshot = read_design(designs.overridden_mass(2.5), meshes=False)
    masses = {o.component: o.mass.mass for o in snapshot.occurrences if o.mass}
    assert masses["upper"] == pytest.approx(2.5)
    bodies = sum(b.mass.mass for b in snapshot.bodies if b.occurrence == "upper:1" and b.mass)
    assert bodies == pytest.approx(STEEL * 0.02 * 0.03 * 0.1)


def test_small_parts_keep_full_precision(fusion: Any) -> None:
    snapshot = read_design(designs.small_parts(), meshes=False)
    for body in snapshot.bodies:
        assert body.mass is not None
        assert body.mass.mass == pytest.approx(1200.0 * 0.002 * 0.003 * 0.004, rel=1e-12)
        assert min(body.mass.principal) > 1e-12


def test_body_without_material_has_no_mass_and_is_reported(fusion: Any) -> None:
    snapshot = read_design(designs.no_material(), meshes=False)
    (finding,) = snapshot.findings
    assert finding.subject == ("body", "lower:1/Body1")
    assert "Physical Material" in finding.message
    assert [b.mass for b in snapshot.bodies if b.occurrence == "lower:1"] == [None]
    assert [o.mass for o in snapshot.occurrences if o.path == "lower:1"] == [None]


def test_body_without_volume_has_no_mass(fusion: Any) -> None:
    build = Builder()
    build.box((), (1.0, 1.0, 0.0))
    assert codes(read_design(build.done(), meshes=False)) == ["no-mass"]


@pytest.mark.parametrize("value", [math.nan, math.inf, -1.0])
def test_invalid_masses_are_rejected(
    fusion: Any, value: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(API["PhysicalProperties"], "mass", property(lambda _: value))
    build = Builder()
    build.box((), (1.0, 1.0, 1.0))
    log: list[str] = []
    snapshot = read_design(build.done(), meshes=False, log=log.append)
    assert one_body(snapshot).mass is None
    assert codes(snapshot) == ["not-read"]
    assert "Traceback" in log[0]


def test_failed_calculation_results_in_no_mass(
    fusion: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(
        API["PhysicalProperties"], "getXYZMomentsOfInertia", lambda _: (False, *6 * [0.0])
    )
    build = Builder()
    build.box((), (1.0, 1.0, 1.0))
    assert codes(read_design(build.done(), meshes=False)) == ["not-read"]


def test_every_component_is_weighed_once(fusion: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """500 bolts are one calculation; their masses equal closed forms at rotated poses."""
    build = Builder()
    first = build.place("bolt")
    build.box(first, (1.0, 2.0, 4.0), translation((0.5, 0.0, 0.0)))
    random_poses = random.Random(4)
    poses = [designs.random_motion(random_poses) for _ in range(499)]
    for T in poses:
        build.place(first[-1].component, T)
    calls: list[str] = []
    for name in ("BRepBody", "Component", "Occurrence"):
        original = API[name].getPhysicalProperties

        def counted(owner: Any, accuracy: int, original: Any = original) -> Any:
            calls.append(repr(owner))
            return original(owner, accuracy)

        monkeypatch.setattr(API[name], "getPhysicalProperties", counted)
    snapshot = read_design(build.done(), meshes=False)
    assert len(calls) == 1
    m = STEEL * 8e-6
    about = m / 12.0 * np.array([20e-4, 17e-4, 5e-4])
    by_path = {o.path: o.mass for o in snapshot.occurrences}
    for k, T in enumerate(poses, 2):
        mass = by_path[f"bolt:{k}"]
        assert mass is not None
        R, r = T[:3, :3], 0.01 * (T @ (0.5, 0.0, 0.0, 1.0))[:3]
        expected = R @ np.diag(about) @ R.T + m * (r @ r * np.eye(3) - np.outer(r, r))
        assert mass.mass == pytest.approx(m, rel=1e-15)
        assert mass.com == pytest.approx(r, abs=1e-16)
        assert tensor_about_origin(mass) == pytest.approx(expected, rel=1e-12, abs=1e-12 * m)


def tensor_about_origin(mass: Any) -> Any:
    xx, yy, zz, xy, yz, xz = mass.moments
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def test_occurrences_with_other_contents_are_weighed_separately(fusion: Any) -> None:
    """A part that was moved in one of three occurrences changes the mass of this one only."""
    build = Builder()
    places = [build.place("leg")]
    part = build.component("foot")
    build.box(part, (1.0, 2.0, 4.0))
    build.box(places[0], (3.0, 1.0, 1.0))
    foot = build.place(part, translation((0.0, 0.0, 5.0)), above=places[0])
    T = designs.random_motion(random.Random(5))
    places += [build.place(places[0][-1].component, pose) for pose in (T, T @ T)]
    build.pose((places[2][-1], foot[-1]), translation((0.0, 0.0, 9.0)))
    snapshot = read_design(build.done(), meshes=False)
    own = {o.path: o.mass for o in snapshot.occurrences if o.component == "leg"}
    first, second, third = (own[f"leg:{k}"] for k in (1, 2, 3))
    assert first is not None
    assert second is not None
    assert third is not None
    assert sorted(second.principal) == pytest.approx(sorted(first.principal), rel=1e-14)
    assert max(third.principal) > 1.5 * max(first.principal)
    for mass, pose in ((second, T), (third, T @ T)):
        foots = sum(b.mass.mass * np.array(b.mass.com) for b in snapshot.bodies if b.mass and
                    b.occurrence.startswith(f"leg:{2 if mass is second else 3}"))  # fmt: skip
        assert mass.com == pytest.approx(foots / mass.mass, abs=1e-15), pose


# Kinds -------------------------------------------------------------------------------------------


def test_kinds_materials_and_visibility(fusion: Any) -> None:
    snapshot = read_design(designs.surface_and_mesh_bodies())
    kinds = {(b.occurrence, b.name): b.kind for b in snapshot.bodies}
    assert kinds["upper:1", "skin"] == "surface"
    assert kinds["upper:1", "scan"] == kinds["lower:1", "scan"] == "mesh"
    assert kinds["upper:1", "Body1"] == "solid"
    for body in snapshot.bodies:
        assert (body.mass is not None) == (body.kind == "solid")
        assert body.mesh is not None
        assert body.material == "Steel"
    shown = {(b.occurrence, b.name): b.visible for b in read_design(designs.hidden_bodies()).bodies}
    assert shown == {
        ("base:1", "Body1"): True,
        ("upper:1", "Body1"): True,
        ("upper:1", "jig"): False,
        ("lower:1", "Body1"): False,  # with its occurrence
    }


# Meshes ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("frame", ["context", "component"])
def test_mesh_and_mass_agree(fusion: Any, frame: Any) -> None:
    """The volume integral of the mesh equals Fusion's mass properties for any mesh frame."""
    fusion.options.mesh_frame = frame
    order = random.Random(3)
    build = Builder()
    path = designs.nested_place(build, "part", designs.random_motion(order), order, 2)
    build.box(path, (3.0, 4.0, 5.0), designs.random_motion(order))
    build.cylinder(path, 2.0, 6.0, designs.random_motion(order))
    build.torus(path, 3.0, 1.0, designs.random_motion(order))
    build.design.attributes["CARDSFlow", "settings"] = '{"quality": "very_high"}'
    snapshot = read_design(build.done())
    assert not snapshot.findings
    for body, exact in zip(snapshot.bodies, (1e-9, 5e-3, 5e-3), strict=True):
        assert body.mesh is not None
        assert body.mass is not None
        mesh = solid(body.mesh)
        mesh.density = STEEL
        assert mesh.is_watertight
        assert mesh.volume * STEEL == pytest.approx(body.mass.mass, rel=exact)
        assert mesh.center_mass == pytest.approx(body.mass.com, abs=1e-10)
        I = tensor(body.mass)  # noqa: E741
        assert mesh.moment_inertia == pytest.approx(I, abs=exact * np.trace(I))


def test_mesh_of_a_native_body_in_the_root_frame(
    fusion: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    build = Builder()
    path = build.place("part", translation((30.0, 0.0, 0.0)) @ rotation(0.4, (1.0, 0.0, 0.0)))
    data = build.box(path, (1.0, 2.0, 3.0))
    design = build.done()
    expected = one_body(read_design(design)).mesh
    T, nodes = path[0].T, data.shape.mesh(8)[0]
    moved = nodes @ T[:3, :3].T + T[:3, 3]
    mesh = property(lambda _: moved.ravel().tolist())
    monkeypatch.setattr(API["TriangleMesh"], "nodeCoordinatesAsDouble", mesh)
    snapshot = read_design(design)
    found = one_body(snapshot).mesh
    assert found is not None
    assert expected is not None
    assert list(found.nodes) == pytest.approx(list(expected.nodes), abs=1e-12)
    assert not snapshot.findings
    elsewhere = property(lambda _: (moved + 100.0).ravel().tolist())
    monkeypatch.setattr(API["TriangleMesh"], "nodeCoordinatesAsDouble", elsewhere)
    assert codes(read_design(design)) == ["mesh-elsewhere"]


def test_inside_out_meshes_are_corrected(fusion: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    original = API["TriangleMesh"].nodeIndices.fget
    monkeypatch.setattr(
        API["TriangleMesh"], "nodeIndices", property(lambda mesh: original(mesh)[::-1])
    )
    build = Builder()
    build.sphere(build.place("far", translation((99.0, 0.0, 0.0))), 1.0)
    mesh = one_body(read_design(build.done())).mesh
    assert mesh is not None
    assert solid(mesh).volume > 0.0


def test_mesh_quality_follows_the_settings(fusion: Any) -> None:
    counts = []
    for quality in ("low", "normal", "high", "very_high"):
        build = Builder()
        build.sphere((), 1.0)
        build.design.attributes["CARDSFlow", "settings"] = json.dumps({"quality": quality})
        mesh = one_body(read_design(build.done())).mesh
        assert mesh is not None
        counts.append(len(mesh.triangles))
    assert counts == sorted(set(counts))


def test_mesh_is_calculated_once_per_component(
    fusion: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    calls = []
    calculate = API["TriangleMeshCalculator"].calculate
    monkeypatch.setattr(
        API["TriangleMeshCalculator"],
        "calculate",
        lambda self: (calls.append(1), calculate(self))[1],
    )
    build = Builder()
    first = build.place("screw")
    build.cylinder(first, 1.0, 3.0)
    for k in range(5):
        build.place(first[-1].component, translation((k + 1.0, 0.0, 0.0)))
    snapshot = read_design(build.done())
    assert len(calls) == 1
    centres = [solid(b.mesh).center_mass[0] for b in snapshot.bodies if b.mesh]
    assert centres == pytest.approx([0.01 * k for k in range(6)], abs=1e-12)


@pytest.mark.parametrize("nodes", [[], [0, 1, 9], [0, 1], [0, 1, -1]])
def test_damaged_meshes_are_warnings(
    fusion: Any, nodes: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(API["TriangleMesh"], "nodeIndices", property(lambda _: nodes))
    build = Builder()
    build.box((), (1.0, 1.0, 1.0))
    snapshot = read_design(build.done())
    body = one_body(snapshot)
    assert body.mesh is None
    assert body.mass is not None
    assert [(f.code, f.severity) for f in snapshot.findings] == [("not-read", "warning")]
