"""Live view in a browser: a server on loopback and its controls."""

from __future__ import annotations

import contextlib
import io
import time
import webbrowser
from collections.abc import Callable, Iterator, Sequence
from html import escape
from typing import Any

import numpy as np

from addin_sdfusion.robot import InputError, Robot
from cardsflow_fmu.cosim.recording import Watch
from cardsflow_fmu.results.run_data import RunData
from cardsflow_fmu.results.viewer.scene import colours
from cardsflow_fmu.results.viewer.scene import shapes as s
from cardsflow_fmu.results.viewer.scene.act import Act
from cardsflow_fmu.results.viewer.scene.camera import CameraView, view_of
from cardsflow_fmu.results.viewer.scene.meshes import LinkMeshes
from cardsflow_fmu.results.viewer.scene.motion import Motion, motion_of
from cardsflow_fmu.results.viewer.scene.stage import Stage
from cardsflow_fmu.utils.arrays import FloatArray
from sim_dart import MusclePaths, Scene

from .guarded_server import HOST, guarded_server
from .viser_scene import ViserScene

PORT = 8080
_FRAME_RATE = 25.0  # in [1/s]
_FIELD = 0.72  # of the camera, in [rad]
_SPEEDS = ("0.1", "0.25", "0.5", "1", "2", "4")
_FREE = {"rad": np.pi, "m": 0.5}  # range of a slider without limits

Ended = Callable[[], bool]


@contextlib.contextmanager
def server(port: int | None = None, *, browser: bool = False) -> Iterator[Any]:
    """Start a viser server on loopback that only serves its own pages.

    Args:
        port: The port (default: the first free port from 8080).
        browser: Whether to open the browser.

    Raises:
        InputError: viser is not installed, or the port is used.
    """
    try:
        with contextlib.redirect_stdout(io.StringIO()):  # its banner
            opened = guarded_server(PORT if port is None else port)
    except ImportError:
        what = "the live view requires viser, which is not installed; or write a page with --html"
        raise InputError(what) from None
    opened.gui.configure_theme(show_logo=False, show_share_button=False)
    try:
        if port and opened.get_port() != port:
            raise InputError(f"port {port} is already used; choose another with --port")
        if browser:
            webbrowser.open(address(opened))
        yield opened
    finally:
        with contextlib.redirect_stdout(io.StringIO()):
            opened.stop()


def address(opened: Any) -> str:
    """Return the address for a browser."""
    return f"http://{HOST}:{opened.get_port()}"


def _viser_scenes(opened: Any, stages: Sequence[Stage]) -> list[ViserScene]:
    """Create a viser scene per stage, side by side, and a camera that shows all."""
    view = view_of(stages[0])
    apart = 1.1 * max(stage.reach for stage in stages)
    opened.scene.set_up_direction(tuple(view.up))
    scenes = []
    for i, stage in enumerate(stages):
        scene = ViserScene(opened, f"/{i}", i * apart * view.aside)
        scene.floor(view_of(stage))
        scenes.append(scene)
    _look(opened, view, 0.5 * (len(stages) - 1) * apart * view.aside, len(stages))
    return scenes


def _look(opened: Any, view: CameraView, middle: FloatArray, count: int) -> None:
    camera = opened.initial_camera
    camera.up = tuple(view.up)
    camera.fov = _FIELD
    middle = view.centre + middle + 0.15 * view.reach * view.aside  # the controls are to the right
    camera.look_at = tuple(middle)
    camera.position = tuple(middle + (view.eye - view.centre) * (0.4 + 0.6 * count))


def _switches(opened: Any, scenes: Sequence[ViserScene], stages: Sequence[Stage]) -> None:
    """Add one switch per group with shapes."""
    used = {shape.group for stage in stages for shape in stage.scene(len(stage) - 1)}
    with opened.gui.add_folder("Show"):
        for group in s.GROUPS:
            if group in used:
                box = opened.gui.add_checkbox(group, group not in s.HIDDEN_AT_FIRST)
                box.on_update(_shower(scenes, group))


def _shower(scenes: Sequence[ViserScene], group: str) -> Callable[[Any], None]:
    def show(event: Any) -> None:
        for scene in scenes:
            scene.show(group, event.target.value)

    return show


def replay(opened: Any, acts: Sequence[Act], ended: Ended) -> None:
    """Show motions side by side with player controls, until `ended`."""
    opened.scene.reset()
    opened.gui.reset()
    stages = [act.stage for act in acts]
    scenes = _viser_scenes(opened, stages)
    for act in acts:
        opened.gui.add_html(heading(act.title, *act.notes))
    end = max(float(stage.motion.time[-1]) for stage in stages)
    clock = _Clock(end)
    button = opened.gui.add_button("Play")
    button.on_click(lambda event: clock.toggle())
    slider = opened.gui.add_slider("time [s]", 0.0, max(end, 1e-3), 1e-3, 0.0)
    speed = opened.gui.add_dropdown("speed", _SPEEDS, initial_value="1")
    _legend(opened, stages[0])
    _switches(opened, scenes, stages)
    drawn, before = None, time.perf_counter()
    while not ended():
        now = time.perf_counter()
        if clock.playing:
            slider.value = clock.advanced(slider.value, float(speed.value) * (now - before))
        label = "Pause" if clock.playing else "Play"
        if button.label != label:
            button.label = label
        before = now
        if slider.value != drawn:
            drawn = slider.value
            for scene, stage in zip(scenes, stages, strict=True):
                scene.draw(stage.scene(frame_at(stage.motion, drawn)))
        time.sleep(max(0.0, 1.0 / _FRAME_RATE - (time.perf_counter() - now)))


class _Clock:
    """Time of a replay; it stops at the end."""

    def __init__(self, end: float) -> None:
        self._end = end
        self._again = False
        self.playing = False

    def toggle(self) -> None:
        self.playing = not self.playing
        self._again = self.playing

    def advanced(self, at: float, seconds: float) -> float:
        """Return the time after a number of seconds."""
        begin = 0.0 if self._again and at >= self._end else at
        self._again = False
        self.playing = begin + seconds < self._end
        return min(begin + seconds, self._end)


def frame_at(motion: Motion, t: float) -> int:
    """Return the last frame up to time t, or the first frame."""
    return max(int(np.searchsorted(motion.time, t + 1e-9, side="right")) - 1, 0)


def _legend(opened: Any, stage: Stage) -> None:
    if stage.motion.tensions is None or not stage.robot.muscles:
        return
    low, high = stage.tension_range(0)
    ramp = ",".join(f"rgb{colour}" for colour in colours.RAMP)
    bar = f"height:9px;border-radius:4px;background:linear-gradient(90deg,{ramp})"
    opened.gui.add_html(
        f'<div style="padding:4px 12px">tension {low:.4g} to {high:.4g} N'
        f'<div style="{bar}"></div></div>'
    )


def pose(opened: Any, robot: Robot, meshes: LinkMeshes, ended: Ended) -> None:
    """Show a robot with joint sliders, muscle lengths and moment arms, until `ended`."""
    paths = MusclePaths(robot)
    sliders = []
    opened.gui.add_html(heading(robot.name))
    with opened.gui.add_folder("Joints"):
        for c in robot.coordinates:
            low = c.lower if np.isfinite(c.lower) else -_FREE[c.unit]
            high = c.upper if np.isfinite(c.upper) else _FREE[c.unit]
            high = max(high, low + 1e-6)
            start = float(np.clip(c.initial, low, high))
            step = (high - low) / 1000.0
            sliders.append(opened.gui.add_slider(f"{c.name} [{c.unit}]", low, high, step, start))
    stage = Stage(robot, Motion.still([slider.value for slider in sliders]), meshes)
    scenes = _viser_scenes(opened, [stage])
    table = opened.gui.add_html("")
    _switches(opened, scenes, [stage])
    drawn = None
    while not ended():
        q = [slider.value for slider in sliders]
        if q != drawn:
            drawn = q
            scenes[0].draw(Stage(robot, Motion.still(q), meshes).scene(0))
            table.content = muscle_table(robot, paths, q)
        time.sleep(1.0 / _FRAME_RATE)


def muscle_table(robot: Robot, paths: MusclePaths, q: Sequence[float]) -> str:
    """Return lengths and moment arms r = -dl/dq of all muscles at q, as HTML.

    Args:
        robot: The robot.
        paths: The muscle paths.
        q: Joint positions, in [rad] or [m].
    """
    state = paths.evaluate(q)
    moving = [k for k, column in enumerate(state.jacobian.T) if column.any()]
    heads = ["muscle", "l [m]", *(f"r {robot.coordinates[k].name}" for k in moving)]
    rows = [
        [muscle.name, f"{length:.4f}", *(f"{-row[k]:.4f}" for k in moving)]
        for muscle, length, row in zip(robot.muscles, state.lengths, state.jacobian, strict=True)
    ]
    lines = [_row("th", heads), *(_row("td", row) for row in rows)]
    note = "moment arms r = -dl/dq in [m], pulling positive"
    style = "font-size:11px;padding:0 10px;overflow-x:auto"
    return f'<div style="{style}"><table>{"".join(lines)}</table>{note}</div>'


def heading(title: str, *notes: str) -> str:
    """Return a title and lines of plain text as HTML."""
    lines = "".join(f"<div>{escape(note)}</div>" for note in notes)
    return f'<div style="font-size:13px;padding:4px 12px"><b>{escape(title)}</b>{lines}</div>'


def _row(tag: str, cells: Sequence[str]) -> str:
    return f"<tr>{''.join(f'<{tag}>{escape(cell)}</{tag}>' for cell in cells)}</tr>"


def follower(opened: Any, robot: Robot, meshes: LinkMeshes, world: Scene | None = None) -> Watch:
    """Live drawing of a run in progress, for `run(..., watch=...)`."""
    scenes: list[ViserScene] = []
    due = 0.0

    def watch(names: tuple[str, ...], rows: FloatArray) -> None:
        nonlocal due
        begin = time.perf_counter()
        if begin < due:
            return
        motion = motion_of(robot, RunData(names, rows, {}, {}), world=world)
        stage = Stage(robot, motion, meshes, world=world)
        if not scenes:
            scenes.extend(_viser_scenes(opened, [stage]))
        scenes[0].draw(stage.scene(len(stage) - 1))
        # leaves at least three quarters of the time to the run
        due = begin + max(1.0 / _FRAME_RATE, 4.0 * (time.perf_counter() - begin))

    return watch
