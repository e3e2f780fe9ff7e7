"""Tests that the fake rejects the same calls as Fusion, and of its matrices."""

from __future__ import annotations

import math
import threading
from typing import Any

import numpy as np
import pytest
from fake_fusion import Fake, designs, modules
from fake_fusion.base import CLASSES, new
from fake_fusion.maths import matrix, point, vector, xyz
from hypothesis import given
from hypothesis import strategies as st

numbers = st.floats(-10.0, 10.0)
triples = st.tuples(numbers, numbers, numbers)
angles = st.floats(-math.pi, math.pi)


@st.composite
def motions(draw: Any) -> np.ndarray:
    """Draw rigid motions, independent of the maths of the fake."""
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


def test_unknown_member_error_contains_class_and_member(fusion: Fake) -> None:
    designs.single_cube()
    body = fusion.design.rootComponent.bRepBodies[0]
    with pytest.raises(AttributeError, match="BRepBody has no member 'isVisble'"):
        _ = body.isVisble
    with pytest.raises(AttributeError, match="BRepBody has no member 'isVisble' to write"):
        body.isVisble = True
    with pytest.raises(AttributeError, match=r"BRepBody\.volume is read-only"):
        body.volume = 1.0


def test_every_class_rejects_unknown_members() -> None:
    with modules():
        for name, cls in {**CLASSES["adsk.core"], **CLASSES["adsk.fusion"]}.items():
            if isinstance(getattr(cls, "_values", None), dict):
                with pytest.raises(AttributeError, match=name):
                    _ = cls.NoSuchValue
                continue
            with pytest.raises(AttributeError, match="noSuchMember"):
                _ = new(cls).noSuchMember


def test_api_classes_have_no_constructors(fusion: Fake) -> None:
    import adsk.core

    with pytest.raises(AttributeError, match="No constructor defined"):
        adsk.core.Matrix3D()


@pytest.mark.parametrize("arguments", [("1", 2.0, 3.0), (True, 2.0, 3.0), (None, 1.0, 1.0)])
def test_arguments_are_checked(fusion: Fake, arguments: tuple[Any, ...]) -> None:
    import adsk.core

    with pytest.raises(TypeError, match=r"Point3D\.create"):
        adsk.core.Point3D.create(*arguments)
    with pytest.raises(TypeError, match=r"Point3D\.x"):
        point((0, 0, 0)).x = arguments[0]


def test_deleted_objects_are_invalid(fusion: Fake) -> None:
    root = designs.no_groups().rootComponent
    assert root.occurrences[0] is not root.occurrences[0]
    assert root.occurrences[0] == root.occurrences[0]
    assert root.occurrences[0] != root.occurrences[1]
    with pytest.raises(TypeError, match="unhashable"):
        hash(root)


def test_calls_from_other_threads_are_rejected(fusion: Fake) -> None:
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


def test_older_versions_lack_new_members(fusion: Fake) -> None:
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
def test_vectors_are_rotated_but_not_translated(T: np.ndarray, v: Any) -> None:
    turned = vector(v)
    turned.transformBy(matrix(T))
    assert xyz(turned) == pytest.approx(T[:3, :3] @ v, abs=1e-9)
    assert turned.length == pytest.approx(np.linalg.norm(v))


@given(motions())
def test_matrices_are_inverted_unless_singular(T: np.ndarray) -> None:
    inverted = matrix(T)
    assert inverted.invert()
    assert inverted._m @ T == pytest.approx(np.eye(4), abs=1e-12)
    assert not matrix(np.zeros((4, 4))).invert()


def test_cells_and_arrays_are_row_major() -> None:
    made = matrix(np.arange(16.0).reshape(4, 4))
    assert made.asArray() == tuple(float(k) for k in range(16))
    assert xyz(made.translation) == pytest.approx([3.0, 7.0, 11.0])
    made.translation = vector((1.0, 2.0, 3.0))
    assert made.asArray()[11] == 3.0
