"""Frames of a run in progress, for a page that a server on loopback sends."""

from __future__ import annotations

import time
from typing import Any

from addin_sdfusion.robot import Robot
from addin_sdfusion.robot.json_text import json_text
from cardsflow_fmu.cosim.recording import Watch
from cardsflow_fmu.results.run_data import RunData
from cardsflow_fmu.results.viewer.scene import shapes as s
from cardsflow_fmu.results.viewer.scene.meshes import LinkMeshes
from cardsflow_fmu.results.viewer.scene.motion import motion_of
from cardsflow_fmu.results.viewer.scene.stage import Stage
from cardsflow_fmu.utils.arrays import FloatArray
from sim_dart import Scene

from .page_server import PageServer

_FRAME_RATE = 25.0  # in [1/s]


def stream_frames(
    server: PageServer, robot: Robot, meshes: LinkMeshes, world: Scene | None = None
) -> Watch:
    """Return a function that sends the frames of a run, for `run(..., watch=...)`."""
    due = 0.0

    def watch(names: tuple[str, ...], rows: FloatArray) -> None:
        nonlocal due
        begin = time.perf_counter()
        if begin < due:
            return
        motion = motion_of(robot, RunData(names, rows, {}, {}), world=world)
        server.send(frame_text(Stage(robot, motion, meshes, world=world)))
        # at least three quarters of the time remain for the run
        due = begin + max(1.0 / _FRAME_RATE, 4.0 * (time.perf_counter() - begin))

    return watch


def frame_text(stage: Stage) -> str:
    """Return the shapes of the last frame of a stage as JSON; surfaces of meshes are omitted."""
    last = len(stage) - 1
    shapes = [_shape(shape) for shape in stage.scene(last)]
    time_of_frame = round(float(stage.motion.time[last]), 6)
    return json_text({"time": time_of_frame, "shapes": shapes}, separators=(",", ":"))


def _shape(shape: s.Shape) -> dict[str, Any]:
    data: dict[str, Any] = {
        "name": shape.name,
        "kind": type(shape).__name__,
        "group": s.GROUPS.index(shape.group),
        "points": [round(float(x), 6) for x in shape.points.reshape(-1)],
        "colour": list(shape.colour),
        "opacity": shape.opacity,
        "radius": getattr(shape, "radius", 0.0),
    }
    if isinstance(shape, s.Label):
        data["value"] = shape.value
    if isinstance(shape, s.Trail):
        data["value"] = len(shape.path)
    return data
