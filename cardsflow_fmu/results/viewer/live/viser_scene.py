"""Drawing of shapes in the scene of a viser server."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from cardsflow_fmu.results.viewer.scene import shapes as s
from cardsflow_fmu.results.viewer.scene.camera import CameraView
from cardsflow_fmu.results.viewer.scene.primitives import (
    Body,
    Kind,
    bodies,
    rotations_from_z,
    unit_body,
)
from cardsflow_fmu.utils.arrays import FloatArray


class _Batch(NamedTuple):
    """Properties of batched meshes of viser, for one kind of body in one group."""

    batched_positions: FloatArray
    batched_wxyzs: FloatArray
    batched_scales: FloatArray
    batched_colors: FloatArray

    def has_size_of(self, other: _Batch) -> bool:
        """Return whether two batches have the same number of bodies."""
        return len(self.batched_positions) == len(other.batched_positions)


class ViserScene:
    """Scene on a viser server; only the changes of each frame are sent.

    Args:
        server: The viser server.
        root: Prefix of the names of all drawn parts, such as `/left`.
        offset: Position of the origin, in [m].
    """

    def __init__(self, server: Any, root: str, offset: FloatArray) -> None:
        self._scene, self._server, self._root = server.scene, server, root
        self._scene.add_frame(root, show_axes=False, position=tuple(offset))
        self._groups = {
            group: self._scene.add_frame(
                self._name(group), show_axes=False, visible=group not in s.HIDDEN_AT_FIRST
            )
            for group in s.GROUPS
        }
        self._batches: dict[tuple[str, Kind, float], tuple[Any, _Batch]] = {}
        self._meshes: dict[str, Any] = {}
        self._labels: dict[str, Any] = {}

    def show(self, group: str, visible: bool) -> None:
        """Show or hide a group of shapes."""
        self._groups[group].visible = visible

    def draw(self, shapes: Sequence[s.Shape]) -> None:
        """Draw a frame; it replaces the last frame."""
        with self._server.atomic():
            self._draw_bodies(shapes)
            for shape in shapes:
                if isinstance(shape, s.MeshShape):
                    self._draw_mesh(shape)
                elif isinstance(shape, s.Label):
                    self._draw_label(shape)

    def draw_floor(self, view: CameraView) -> None:
        """Draw a grid below the robot."""
        cell = 10.0 ** np.floor(np.log10(view.reach / 2.0))
        self._scene.add_grid(
            f"{self._root}/floor",
            width=4.0 * view.reach,
            height=4.0 * view.reach,
            plane="xy",
            cell_size=float(cell),
            cell_color=(214, 220, 228),
            section_size=float(5.0 * cell),
            section_color=(196, 204, 214),
            position=tuple(view.floor),
            wxyz=tuple(rotations_from_z(view.up[np.newaxis])[0]),
        )

    def _name(self, group: str, *more: str) -> str:
        return "/".join((self._root, group.replace(" ", "_"), *more))

    def _draw_bodies(self, shapes: Sequence[s.Shape]) -> None:
        sorted_: defaultdict[tuple[str, Kind, float], list[Body]] = defaultdict(list)
        for shape in shapes:
            for body in bodies([shape]):
                sorted_[shape.group, body.kind, shape.opacity].append(body)
        for key, found in sorted_.items():
            self._draw_batch(key, _batch(found))
        for key in set(self._batches) - set(sorted_):
            self._batches.pop(key)[0].remove()

    def _draw_batch(self, key: tuple[str, Kind, float], batch: _Batch) -> None:
        handle, before = self._batches.get(key, (None, None))
        if handle is None or before is None or not before.has_size_of(batch):
            handle = self._add_batch(key, batch)
        else:
            for name, old, new in zip(_Batch._fields, before, batch, strict=True):
                if not np.array_equal(old, new):
                    setattr(handle, name, new)
        self._batches[key] = (handle, batch)

    def _add_batch(self, key: tuple[str, Kind, float], batch: _Batch) -> Any:
        group, kind, opacity = key
        unit = unit_body(kind)
        return self._scene.add_batched_meshes_simple(
            self._name(group, f"{kind}_{round(100 * opacity)}"),
            unit.vertices,
            unit.faces,
            **batch._asdict(),
            opacity=None if opacity == 1.0 else opacity,
            lod="off",
            cast_shadow=False,
            receive_shadow=False,
        )

    def _draw_mesh(self, mesh: s.MeshShape) -> None:
        wxyz, position = _quaternion(mesh.T[:3, :3]), mesh.T[:3, 3]
        handle = self._meshes.get(mesh.name)
        if handle is None:
            self._meshes[mesh.name] = self._scene.add_mesh_simple(
                self._name(mesh.group, f"mesh_{len(self._meshes)}"),
                mesh.triangles.vertices,
                mesh.triangles.faces,
                color=mesh.colour,
                flat_shading=True,
                side="double",
                wxyz=wxyz,
                position=position,
            )
        else:
            handle.wxyz, handle.position = wxyz, position

    def _draw_label(self, label: s.Label) -> None:
        handle = self._labels.get(label.name)
        if handle is None:
            self._labels[label.name] = self._scene.add_label(
                self._name(label.group, f"label_{len(self._labels)}"),
                label.text,
                position=label.position,
                anchor="center-center",
            )
        else:
            handle.text, handle.position = label.text, label.position


def _batch(found: Sequence[Body]) -> _Batch:
    a = np.array([body.a for body in found])
    along = np.array([body.b for body in found]) - a
    radius = np.array([body.radius for body in found])
    length = np.linalg.norm(along, axis=1)
    length[[body.kind == "ball" for body in found]] = 1.0
    is_ball = np.array([body.kind == "ball" for body in found])
    height = np.where(is_ball, radius, np.maximum(length, 1e-9))
    return _Batch(
        a.astype(np.float32),
        rotations_from_z(along).astype(np.float32),
        np.column_stack([radius, radius, height]).astype(np.float32),
        np.array([body.colour for body in found], dtype=np.uint8),
    )


def _quaternion(R: FloatArray) -> FloatArray:
    """Return the quaternion (w, x, y, z) of a rotation matrix."""
    from scipy.spatial.transform import Rotation

    x, y, z, w = Rotation.from_matrix(R).as_quat()
    return np.array([w, x, y, z])
