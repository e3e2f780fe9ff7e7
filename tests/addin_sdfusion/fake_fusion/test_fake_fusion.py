"""The fake refuses what Fusion refuses, and its matrices are right."""

from __future__ import annotations

import math
import sys
import threading
from typing import Any

import numpy as np
import pytest
from fake_fusion import Builder, Fake, designs, install, modules
from fake_fusion.base import CLASSES, new
from fake_fusion.maths import matrix, point, vector, xyz
from hypothesis import given
from hypothesis import strategies as st

numbers = st.floats(-10.0, 10.0)
triples = st.tuples(numbers, numbers, numbers)
angles = st.floats(-math.pi, math.pi)


@st.composite
def motions(draw: Any) -> np.ndarray:
    """Rigid motions, made without the fake's own maths."""
    q = np.array([20.0 + draw(numbers), *draw(triples)])
    w, x, y, z = q / np.linalg.norm(q)
    T = np.eye(4)
    T[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    T[:3, 3] = draw(triples)
    return T


# Strictness --------------------------------------------------------------------------------------


def test_unknown_member_names_class_and_member(fusion: Fake) -> None:
    designs.single_cube()
    body = fusion.design.rootComponent.bRepBodies[0]
    with pytest.raises(AttributeError, match="BRepBody has no member 'isVisble'"):
        _ = body.isVisble
    with pytest.raises(AttributeError, match="BRepBody has no member 'isVisble' to write"):
        body.isVisble = True
    with pytest.raises(AttributeError, match=r"BRepBody\.volume is read-only"):
        body.volume = 1.0


def test_every_class_refuses_unknown_members() -> None:
    with modules():
        for name, cls in {**CLASSES["adsk.core"], **CLASSES["adsk.fusion"]}.items():
            if isinstance(getattr(cls, "_values", None), dict):
                with pytest.raises(AttributeError, match=name):
                    _ = cls.NoSuchValue
                continue
            with pytest.raises(AttributeError, match="noSuchMember"):
                _ = new(cls).noSuchMember


def test_modules_hold_only_what_exists(fusion: Fake) -> None:
    import adsk.core

    with pytest.raises(AttributeError, match="Matrix4D"):
        _ = adsk.core.Matrix4D


def test_modules_go_away_again() -> None:
    before = sys.modules.get("adsk")
    with install():
        assert "adsk.fusion" in sys.modules
    assert sys.modules.get("adsk") is before


def test_there_are_no_constructors(fusion: Fake) -> None:
    import adsk.core

    with pytest.raises(AttributeError, match="No constructor defined"):
        adsk.core.Matrix3D()


@pytest.mark.parametrize(
    "arguments", [("1", 2.0, 3.0), (True, 2.0, 3.0), (None, 1.0, 1.0), (1.0, 2.0, 3.0, 4.0)]
)
def test_arguments_are_checked(fusion: Fake, arguments: tuple[Any, ...]) -> None:
    import adsk.core

    with pytest.raises(TypeError, match=r"Point3D\.create"):
        adsk.core.Point3D.create(*arguments)


def test_keyword_arguments_are_refused(fusion: Fake) -> None:
    import adsk.core

    with pytest.raises(TypeError):
        adsk.core.Point3D.create(x=1.0)


def test_written_values_are_checked(fusion: Fake) -> None:
    with pytest.raises(TypeError, match=r"Point3D\.x"):
        point((0, 0, 0)).x = "1"


def test_objects_come_and_go(fusion: Fake) -> None:
    root = designs.no_groups().rootComponent
    assert root.occurrences[0] is not root.occurrences[0]
    assert root.occurrences[0] == root.occurrences[0]
    assert root.occurrences[0] != root.occurrences[1]
    with pytest.raises(TypeError, match="unhashable"):
        hash(root)


def test_cast_gives_none(fusion: Fake) -> None:
    import adsk.core
    import adsk.fusion

    assert fusion.app.activeProduct is None
    assert adsk.fusion.Design.cast(None) is None
    assert adsk.fusion.Design.cast(point((0, 0, 0))) is None
    design = designs.single_cube()
    assert adsk.fusion.Design.cast(fusion.app.activeProduct) == design
    assert design.objectType == adsk.fusion.Design.classType() == "adsk::fusion::Design"
    assert isinstance(design, adsk.core.Product)


def test_active_product_may_be_none_of_ours(fusion: Fake) -> None:
    import adsk.fusion

    designs.single_cube()
    fusion.world.in_design = False
    assert fusion.app.activeProduct is not None
    assert adsk.fusion.Design.cast(fusion.app.activeProduct) is None


def test_closed_document_is_gone(fusion: Fake) -> None:
    first, second = designs.single_cube(), designs.no_groups()
    assert fusion.design == second
    fusion.close(second)
    assert fusion.design == first
    assert not second.isValid
    with pytest.raises(RuntimeError, match="deleted"):
        _ = second.rootComponent


def test_other_threads_are_refused(fusion: Fake) -> None:
    design = designs.single_cube()
    caught: list[BaseException] = []

    def work() -> None:
        try:
            _ = design.rootComponent
        except RuntimeError as error:
            caught.append(error)

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert "Design.rootComponent called from a worker thread" in str(caught[0])


def test_other_threads_may_fire_custom_events(fusion: Fake) -> None:
    import adsk
    import adsk.core

    class Handler(adsk.core.CustomEventHandler):
        def notify(self, args: Any) -> None:
            heard.append(args.additionalInfo)

    heard: list[str] = []
    handler = Handler()
    fusion.app.registerCustomEvent("progress").add(handler)
    app = fusion.app
    thread = threading.Thread(target=lambda: app.fireCustomEvent("progress", "half"))
    thread.start()
    thread.join()
    assert heard == []
    adsk.doEvents()
    assert heard == ["half"]


def test_older_versions_miss_members(fusion: Fake) -> None:
    design = designs.single_cube()
    assert design.designIntent == 2
    fusion.without("Design.designIntent")
    assert not hasattr(design, "designIntent")


# Maths -------------------------------------------------------------------------------------------


@given(motions(), motions(), triples)
def test_transform_by_multiplies_from_the_left(A: np.ndarray, B: np.ndarray, p: Any) -> None:
    product = matrix(A)
    product.transformBy(matrix(B))
    assert np.array(product.asArray()).reshape(4, 4) == pytest.approx(B @ A)
    one, other = point(p), point(p)
    one.transformBy(product)
    other.transformBy(matrix(A))
    other.transformBy(matrix(B))
    assert xyz(one) == pytest.approx(xyz(other), abs=1e-9)
    assert xyz(one) == pytest.approx((B @ A @ (*p, 1.0))[:3], abs=1e-9)


@given(motions(), triples)
def test_vectors_are_turned_not_moved(T: np.ndarray, v: Any) -> None:
    turned = vector(v)
    turned.transformBy(matrix(T))
    assert xyz(turned) == pytest.approx(T[:3, :3] @ v, abs=1e-9)
    assert turned.length == pytest.approx(np.linalg.norm(v))


@given(motions())
def test_matrices_are_inverted_unless_singular(T: np.ndarray) -> None:
    inverted = matrix(T)
    assert inverted.invert()
    assert inverted._m @ T == pytest.approx(np.eye(4), abs=1e-12)
    assert matrix(T).determinant == pytest.approx(1.0)
    assert not matrix(np.zeros((4, 4))).invert()


@given(motions(), motions())
def test_coordinate_systems_come_back_and_are_aligned(A: np.ndarray, B: np.ndarray) -> None:
    made = matrix(np.eye(4))
    made.setWithCoordinateSystem(*matrix(A).getAsCoordinateSystem())
    assert made._m == pytest.approx(A)
    made.setToAlignCoordinateSystems(
        *matrix(A).getAsCoordinateSystem(), *matrix(B).getAsCoordinateSystem()
    )
    assert made._m @ A == pytest.approx(B, abs=1e-9)


@given(angles, triples.filter(lambda v: np.linalg.norm(v) > 1e-3), triples)
def test_rotation_has_its_angle_axis_and_origin(angle: float, axis: Any, origin: Any) -> None:
    turned = matrix(np.eye(4))
    turned.setToRotation(angle, vector(axis), point(origin))
    R = turned._m[:3, :3]
    assert np.trace(R) == pytest.approx(1.0 + 2.0 * math.cos(angle))
    assert R @ axis == pytest.approx(np.array(axis), abs=1e-9)
    assert (turned._m @ (*origin, 1.0))[:3] == pytest.approx(np.array(origin), abs=1e-9)
    sine = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]) / 2.0
    assert sine @ axis == pytest.approx(math.sin(angle) * np.linalg.norm(axis), abs=1e-9)


@given(
    triples.filter(lambda v: np.linalg.norm(v) > 1e-2),
    triples.filter(lambda v: np.linalg.norm(v) > 1e-2),
)
def test_rotation_takes_one_vector_to_another(a: Any, b: Any) -> None:
    turned = matrix(np.eye(4))
    turned.setToRotateTo(vector(a), vector(b))
    a, b = a / np.linalg.norm(a), b / np.linalg.norm(b)
    assert turned._m[:3, :3] @ a == pytest.approx(b, abs=1e-6)
    assert np.linalg.det(turned._m) == pytest.approx(1.0)


def test_cells_and_arrays_are_row_major() -> None:
    made = matrix(np.eye(4))
    made.setWithArray([float(k) for k in range(16)])
    assert made.getCell(1, 2) == 6.0
    assert made.asArray() == tuple(float(k) for k in range(16))
    made.setCell(0, 3, 9.0)
    assert xyz(made.translation) == pytest.approx([9.0, 7.0, 11.0])
    made.translation = vector((1.0, 2.0, 3.0))
    assert made.getCell(2, 3) == 3.0
    with pytest.raises(RuntimeError, match="cells"):
        made.setWithArray([1.0, 2.0])
    with pytest.raises(RuntimeError, match="row or column"):
        made.getCell(4, 0)


@given(triples, triples)
def test_vector_products_are_those_of_numpy(a: Any, b: Any) -> None:
    assert xyz(vector(a).crossProduct(vector(b))) == pytest.approx(np.cross(a, b))
    assert vector(a).dotProduct(vector(b)) == pytest.approx(np.dot(a, b))
    assert xyz(point(a).vectorTo(point(b))) == pytest.approx(np.subtract(b, a))
    assert point(a).distanceTo(point(b)) == pytest.approx(np.linalg.norm(np.subtract(b, a)))


def test_copies_are_independent() -> None:
    one = matrix(np.eye(4))
    other = one.copy()
    other.setCell(0, 0, 5.0)
    assert one.getCell(0, 0) == 1.0
    assert not vector((0.0, 0.0, 0.0)).normalize()


def test_large_design_is_read_whole(fusion: Fake) -> None:
    root = designs.many_links(200, 400).rootComponent
    assert len(root.allJoints) == 199
    for occurrence in root.allOccurrences:
        occurrence.getPhysicalProperties(3).getXYZMomentsOfInertia()
        assert len(occurrence.transform2.asArray()) == 16
        for body in occurrence.bRepBodies:
            body.getPhysicalProperties(3).getPrincipalMomentsOfInertia()
        for native in occurrence.component.constructionPoints:
            assert native.createForAssemblyContext(occurrence).geometry
    assert sum(c.constructionPoints.count for c in root.parentDesign.allComponents) == 400


def test_builder_makes_names_unique(fusion: Fake) -> None:
    build = Builder()
    for _ in range(3):
        build.point((), (0.0, 0.0, 0.0), "VP")
        build.place("part")
    design = build.done()
    assert [p.name for p in design.rootComponent.constructionPoints] == ["VP", "VP (1)", "VP (2)"]
    names = [o.name for o in design.rootComponent.occurrences]
    assert names == ["part:1", "part (1):1", "part (2):1"]
