"""Points, vectors and matrices of adsk.core with the conventions of Fusion. Lengths are in cm."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from .base import Base, api, new

_TOLERANCE = 1e-6  # cm; tolerance of points in Fusion


def point(xyz: Any) -> Point3D:
    """Return a Point3D with three coordinates, in [cm]."""
    x, y, z = (float(v) for v in xyz)
    return new(Point3D, x=x, y=y, z=z)


def vector(xyz: Any) -> Vector3D:
    """Return a Vector3D with three components."""
    x, y, z = (float(v) for v in xyz)
    return new(Vector3D, x=x, y=y, z=z)


def matrix(cells: Any) -> Matrix3D:
    """Return a Matrix3D of a 4x4 array."""
    return new(Matrix3D, m=np.array(cells, dtype=float).reshape(4, 4))


def xyz(item: Any) -> np.ndarray:
    """Return the components of a Point3D or Vector3D."""
    return np.array((item._x, item._y, item._z))


def apply(m: np.ndarray, p: Any) -> np.ndarray:
    """Return a point transformed by a 4x4 matrix."""
    return m[:3, :3] @ np.asarray(p, dtype=float) + m[:3, 3]


class _Triple(Base):
    """Object with writable coordinates x, y, z."""

    @property
    def x(self) -> float:
        return self._x

    @x.setter
    def x(self, value: float) -> None:
        self._x = float(value)

    @property
    def y(self) -> float:
        return self._y

    @y.setter
    def y(self, value: float) -> None:
        self._y = float(value)

    @property
    def z(self) -> float:
        return self._z

    @z.setter
    def z(self, value: float) -> None:
        self._z = float(value)

    def asArray(self) -> tuple:
        return (self._x, self._y, self._z)

    def copy(self) -> Any:
        return new(type(self), x=self._x, y=self._y, z=self._z)

    def _set(self, values: Any) -> bool:
        self._x, self._y, self._z = (float(v) for v in values)
        return True


@api("adsk.core")
class Point3D(_Triple):
    @staticmethod
    def create(x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Point3D:
        return point((x, y, z))

    def asVector(self) -> Vector3D:
        return vector(xyz(self))

    def transformBy(self, matrix: Matrix3D) -> bool:
        return self._set(apply(matrix._m, xyz(self)))


@api("adsk.core")
class Vector3D(_Triple):
    @staticmethod
    def create(x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Vector3D:
        return vector((x, y, z))

    length = property(lambda self: math.sqrt(self._x**2 + self._y**2 + self._z**2))

    def scaleBy(self, scale: float) -> bool:
        return self._set(scale * xyz(self))

    def transformBy(self, matrix: Matrix3D) -> bool:
        """Rotate and scale the vector without translation."""
        return self._set(matrix._m[:3, :3] @ xyz(self))


_vector = vector


def rotation(angle: float, axis: Any, origin: Any = (0.0, 0.0, 0.0)) -> np.ndarray:
    """Return the 4x4 matrix of a rotation by an angle, in [rad], about an axis through a point."""
    x, y, z = np.asarray(axis, dtype=float) / np.linalg.norm(axis)
    K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    R = np.eye(3) + math.sin(angle) * K + (1.0 - math.cos(angle)) * K @ K
    T = np.eye(4)
    T[:3, :3] = R
    T[:3, 3] = np.asarray(origin) - R @ np.asarray(origin, dtype=float)
    return T


def translation(xyz: Any) -> np.ndarray:
    """Return the 4x4 matrix of a translation."""
    T = np.eye(4)
    T[:3, 3] = xyz
    return T


def inverse(T: np.ndarray) -> np.ndarray:
    """Return the inverse of a rigid 4x4 matrix."""
    made = np.eye(4)
    made[:3, :3] = T[:3, :3].T
    made[:3, 3] = -T[:3, :3].T @ T[:3, 3]
    return made


def is_rigid(T: np.ndarray) -> bool:
    """Return whether a 4x4 matrix is a rigid transform."""
    R = T[:3, :3]
    right = np.allclose(R @ R.T, np.eye(3), atol=1e-6) and np.linalg.det(R) > 0.0
    return bool(right and np.array_equal(T[3], (0.0, 0.0, 0.0, 1.0)))


def frame(origin: Any, z: Any = (0.0, 0.0, 1.0), x: Any = None) -> np.ndarray:
    """Return a 4x4 matrix from an origin, z axis and approximate x axis."""
    z = np.asarray(z, dtype=float) / np.linalg.norm(z)
    if x is None:
        x = np.eye(3)[int(np.argmin(np.abs(z)))]
    x = np.asarray(x, dtype=float)
    x = x - (x @ z) * z
    x /= np.linalg.norm(x)
    T = np.eye(4)
    T[:3, 0], T[:3, 1], T[:3, 2], T[:3, 3] = x, np.cross(z, x), z, origin
    return T


@api("adsk.core")
class Matrix3D(Base):
    """A 4x4 matrix that acts on column vectors; arrays are in row-major order."""

    @staticmethod
    def create() -> Matrix3D:
        return matrix(np.eye(4))

    def copy(self) -> Matrix3D:
        return matrix(self._m)

    def asArray(self) -> tuple:
        return tuple(self._m.ravel().tolist())

    @property
    def translation(self) -> Vector3D:
        return vector(self._m[:3, 3])

    @translation.setter
    def translation(self, value: Vector3D) -> None:
        self._m[:3, 3] = xyz(value)

    def invert(self) -> bool:
        if abs(np.linalg.det(self._m)) < 1e-300:
            return False
        self._m = inverse(self._m) if is_rigid(self._m) else np.linalg.inv(self._m)
        return True

    def transformBy(self, matrix: Matrix3D) -> bool:
        """Apply another transform after this one: this = matrix · this."""
        self._m = matrix._m @ self._m
        return True
