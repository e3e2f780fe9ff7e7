"""Tests of reading wrap surfaces: cylinder and sphere faces in every occurrence."""

from __future__ import annotations

import math
import random
from typing import Any

import fake_fusion
import numpy as np
import pytest
from fake_fusion import Builder, designs
from fake_fusion.base import CLASSES
from fake_fusion.maths import rotation, translation
from fake_fusion.model.data import paths_below
from fake_fusion.model.shapes import EdgeShape, FaceShape
from hypothesis import given
from hypothesis import strategies as st
from support.designs.drawn import at

from addin_sdfusion.snapshot import DesignSnapshot, SurfaceUse

with fake_fusion.modules():
    from addin_sdfusion.fusion.design import read_design

API = CLASSES["adsk.fusion"]
SIZES = st.floats(0.1, 50.0)
SEEDS = st.integers(0, 2**32)


def codes(snapshot: DesignSnapshot) -> list[str]:
    return [finding.code for finding in snapshot.findings]


def wrap(design: Any, kind: str, text: str = '{"name": "w"}', *, others: bool = False) -> None:
    """Write the attribute to every face of a type."""
    root = design._data.root
    for component in {
        id(c): c for c in (root, *(p[-1].component for p in paths_below(root)))
    }.values():
        for body in component.bodies:
            for face in body.topology()[2]:
                if others or face.geometry.kind == kind:
                    face.attributes["CARDSFlow", "wrap"] = text


@given(SEEDS, SIZES, SIZES)
def test_cylinder_face_is_read_in_every_occurrence(seed: int, radius: float, height: float) -> None:
    with fake_fusion.install() as fake:
        order = random.Random(seed)
        build = Builder()
        path = designs.nested_place(build, "drum", designs.random_motion(order), order, 1)
        again = build.place(path[-1].component, designs.random_motion(order))
        T = designs.random_motion(order)
        build.cylinder(path, radius, height, T)
        design = build.done()
        wrap(design, "cylinder")
        before = fake.full_fingerprint()
        snapshot = read_design(design, meshes=False)
        assert fake.full_fingerprint() == before
    assert not snapshot.findings
    assert len(snapshot.surfaces) == 2
    assert len({s.entity for s in snapshot.surfaces}) == 1
    poses = {"drum:2": again[0].T @ T, "drum holder 0:1+drum:1": path[0].T @ path[1].T @ T}
    for surface in snapshot.surfaces:
        pose = poses[surface.occurrence]
        assert surface.shape == "cylinder"
        assert surface.radius == pytest.approx(0.01 * radius)
        assert surface.length == pytest.approx(0.01 * height)
        assert surface.centre == pytest.approx(at(pose, (0, 0, 0)), abs=1e-12)
        assert surface.axis == pytest.approx(pose[:3, 2], abs=1e-12)
        assert surface.use == SurfaceUse("w")


def test_centre_of_a_cylinder_is_found_from_its_edges(
    fusion: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Fusion's origin may be any point of the axis; the edges bound the face."""
    from fake_fusion.curves import surface_of

    def shifted(face: Any) -> Any:
        data = face._data.geometry
        moved = FaceShape(data.kind, data.origin + 7.0 * data.axis, -data.axis, data.radius)
        return surface_of(moved, face._T)

    monkeypatch.setattr(API["BRepFace"], "geometry", property(shifted))
    build = Builder()
    build.cylinder((), 1.0, 4.0, translation((0.0, 0.0, 2.0)))
    design = build.done()
    wrap(design, "cylinder")
    (surface,) = read_design(design).surfaces
    assert surface.centre == pytest.approx((0.0, 0.0, 0.02))
    assert surface.length == pytest.approx(0.04)


def test_length_of_an_obliquely_cut_cylinder(fusion: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """An end cut at 45 degrees is an ellipse, which is approximated by a polyline."""
    from fake_fusion.base import new
    from fake_fusion.curves import curve_of
    from fake_fusion.maths import point

    class Evaluator:
        def getParameterExtents(self) -> Any:
            return True, 0.0, 2.0 * math.pi

        def getStrokes(self, start: float, end: float, tolerance: float) -> Any:
            turns = np.linspace(start, end, 721)
            return True, [point((math.cos(t), math.sin(t), 2.0 + math.cos(t))) for t in turns]

    curves = (
        curve_of(EdgeShape(np.array((0.0, 0.0, -2.0)), np.array((0.0, 0.0, 1.0)), 1.0), np.eye(4)),
        new(CLASSES["adsk.core"]["Curve3D"]),
    )
    edges = [type("Edge", (), {"geometry": c, "evaluator": Evaluator()})() for c in curves]
    monkeypatch.setattr(API["BRepFace"], "edges", property(lambda _: edges))
    build = Builder()
    build.cylinder((), 1.0, 4.0)
    design = build.done()
    wrap(design, "cylinder")
    (surface,) = read_design(design).surfaces
    assert surface.length == pytest.approx(0.05, rel=1e-4)
    assert surface.centre == pytest.approx((0.0, 0.0, 0.005), abs=1e-6)


def test_sphere_face_has_centre_and_radius(fusion: Any) -> None:
    build = Builder()
    path = build.place("ball", translation((1.0, 2.0, 3.0)) @ rotation(1.0, (1.0, 0.0, 0.0)))
    build.sphere(path, 1.5, translation((0.0, 1.0, 0.0)))
    design = build.done()
    wrap(design, "sphere")
    (surface,) = read_design(design).surfaces
    assert (surface.shape, surface.length) == ("sphere", 0.0)
    assert surface.axis == (0.0, 0.0, 1.0)
    assert surface.radius == pytest.approx(0.015)
    assert surface.centre == pytest.approx(at(path[0].T, (0.0, 1.0, 0.0)))


def test_faces_of_other_shapes_are_reported(fusion: Any) -> None:
    build = Builder()
    build.cylinder((), 1.0, 2.0)
    design = build.done()
    wrap(design, "cylinder", others=True)
    snapshot = read_design(design)
    assert len(snapshot.surfaces) == 1
    assert len(snapshot.findings) == 1  # both ends have the same finding
    assert "neither a cylinder nor a sphere" in snapshot.findings[0].message


def test_two_faces_of_a_body_are_two_entities(fusion: Any) -> None:
    build = Builder()
    path = build.place("part")
    for k in range(2):
        build.cylinder(path, 1.0, 2.0, translation((5.0 * k, 0.0, 0.0)))
    design = build.done()
    wrap(design, "cylinder")
    assert len({s.entity for s in read_design(design).surfaces}) == 2


def test_lost_and_split_faces_are_reported(fusion: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    build = Builder()
    build.cylinder((), 1.0, 2.0)
    design = build.done()
    wrap(design, "cylinder")
    attribute = CLASSES["adsk.core"]["Attribute"]
    monkeypatch.setattr(attribute, "otherParents", property(lambda _: [object()]))
    snapshot = read_design(design)
    assert codes(snapshot) == ["split-face"]
    assert len(snapshot.surfaces) == 1
    monkeypatch.setattr(attribute, "parent", property(lambda _: None))
    snapshot = read_design(design)
    assert codes(snapshot) == ["lost-face"]
    assert not snapshot.surfaces
