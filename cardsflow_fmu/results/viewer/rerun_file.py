"""Recordings for Rerun: shapes of all frames, and plots with the same time axis.

The viewer of Rerun sends usage data by default. Writing a file does not start the viewer and does
not open a network connection.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from addin_sdfusion.robot import InputError
from cardsflow_fmu.utils.arrays import FloatArray
from cardsflow_fmu.utils.extras import install
from cardsflow_fmu.utils.overwrite import MARK, output_file, write_output
from cardsflow_fmu.utils.temporary import temporary_folder

from .scene import shapes as s
from .scene.act import Act
from .scene.primitives import AXES

_MAX_TRAIL_POINTS = 400
"""Maximum number of points of a trail; each frame contains the whole trail."""


def require_rerun() -> Any:
    """Return the module rerun.

    Raises:
        InputError: rerun-sdk is not installed.
    """
    try:
        import rerun
    except ImportError:
        what = f"a recording requires rerun-sdk: {install('rerun')}"
        raise InputError(what, key="--rrd") from None
    return rerun


def write_rrd(acts: Sequence[Act], file: str | Path, *, overwrite: bool = False) -> Path:
    """Write a recording that Rerun opens.

    Raises:
        InputError: rerun-sdk is not installed, or the file cannot be written.
    """
    target, rr = output_file(file, [".rrd"], overwrite=overwrite), require_rerun()
    with temporary_folder() as scratch:
        draft = scratch / "recording.rrd"
        recording = rr.RecordingStream(MARK, recording_id=acts[0].title)
        recording.save(draft)
        for number, act in enumerate(acts):
            _Recorder(rr, recording, f"{number + 1} {act.title}").record(act)
        recording.flush()
        recording.disconnect()
        return write_output(target, draft.read_bytes())


class _Recorder:
    """Writer of an act below a root entity."""

    def __init__(self, rr: Any, recording: Any, root: str) -> None:
        self._rr, self._recording, self._root = rr, recording, root
        self._meshes: set[str] = set()

    def record(self, act: Act) -> None:
        stage = act.stage
        for k, t in enumerate(stage.motion.time):
            self._recording.set_time("time", duration=float(t))
            groups: defaultdict[str, list[s.Shape]] = defaultdict(list)
            for shape in stage.scene(k):
                groups[shape.group].append(shape)
            for group, shapes in groups.items():
                self._draw(group, shapes)
            if stage.motion.tensions is not None:
                names = [muscle.name for muscle in stage.robot.muscles]
                self._plot("tensions", names, stage.motion.tensions[k])
            self._plot("joints", [c.name for c in stage.robot.coordinates], stage.motion.q[k])

    def _log(self, path: str, entity: Any, *, static: bool = False) -> None:
        self._recording.log(f"{self._path(self._root)}/{path}", entity, static=static)

    def _path(self, *parts: str) -> str:
        return self._rr.escape_entity_path_part("/".join(parts))  # type: ignore[no-any-return]

    def _plot(self, what: str, names: Sequence[str], values: Sequence[float]) -> None:
        for name, value in zip(names, values, strict=True):
            self._log(f"{what}/{self._path(name)}", self._rr.Scalars([float(value)]))

    def _draw(self, group: str, shapes: Sequence[s.Shape]) -> None:
        """Log one entity for all lines, balls and arrows of a group."""
        rr, path = self._rr, self._path(group)
        lines, line_colours, line_radii = _lines(shapes)
        if lines:
            drawn = rr.LineStrips3D(lines, colors=line_colours, radii=line_radii)
            self._log(f"{path}/lines", drawn)
        balls, ball_colours, ball_radii = _balls(shapes)
        if balls:
            self._log(f"{path}/balls", rr.Points3D(balls, colors=ball_colours, radii=ball_radii))
        arrows = [shape for shape in shapes if isinstance(shape, s.Arrow)]
        if arrows:
            drawn = rr.Arrows3D(
                origins=[arrow.start for arrow in arrows],
                vectors=[arrow.end - arrow.start for arrow in arrows],
                colors=[arrow.colour for arrow in arrows],
                radii=[arrow.radius for arrow in arrows],
            )
            self._log(f"{path}/arrows", drawn)
        labels = [shape for shape in shapes if isinstance(shape, s.Label)]
        if labels:
            drawn = rr.Points3D(
                [label.position for label in labels],
                colors=[label.colour for label in labels],
                labels=[label.text for label in labels],
                radii=1e-6,
            )
            self._log(f"{path}/labels", drawn)
        for shape in shapes:
            if isinstance(shape, s.MeshShape):
                self._draw_mesh(path, shape)

    def _draw_mesh(self, group: str, mesh: s.MeshShape) -> None:
        path = f"{group}/{self._path(mesh.name)}"
        if path not in self._meshes:
            self._meshes.add(path)
            surface = self._rr.Mesh3D(
                vertex_positions=mesh.triangles.vertices,
                triangle_indices=mesh.triangles.faces,
                albedo_factor=mesh.colour,
            )
            self._log(path, surface, static=True)
        pose = self._rr.Transform3D(translation=mesh.T[:3, 3], mat3x3=mesh.T[:3, :3])
        self._log(path, pose)


def _lines(shapes: Sequence[s.Shape]) -> tuple[list[FloatArray], list[s.Colour], list[float]]:
    """Return corners, colours and radii of lines."""
    found: list[tuple[FloatArray, s.Colour, float]] = []
    for shape in shapes:
        if isinstance(shape, s.Line | s.Capsule | s.Cylinder):
            found.append((shape.points, shape.colour, shape.radius))
        elif isinstance(shape, s.Frame):
            origin, *tips = shape.points
            found += [
                (np.stack([origin, tip]), colour, shape.radius)
                for tip, colour in zip(tips, AXES, strict=True)
            ]
    return [f[0] for f in found], [f[1] for f in found], [f[2] for f in found]


def _balls(shapes: Sequence[s.Shape]) -> tuple[list[FloatArray], list[s.Colour], list[float]]:
    """Return centres, colours and radii of balls."""
    centres: list[FloatArray] = []
    tints: list[s.Colour] = []
    radii: list[float] = []
    for shape in shapes:
        if isinstance(shape, s.Sphere | s.Trail):
            points = shape.points[:: 1 + len(shape.points) // _MAX_TRAIL_POINTS]
            centres += list(points)
            tints += [shape.colour] * len(points)
            radii += [shape.radius] * len(points)
    return centres, tints, radii
