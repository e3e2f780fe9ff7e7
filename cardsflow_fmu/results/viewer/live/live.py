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
_FIELD_OF_VIEW = 0.72  # in [rad]
_SPEEDS = ("0.1", "0.25", "0.5", "1", "2", "4")
_UNLIMITED_RANGE = {"rad": np.pi, "m": 0.5}  # range of a slider without limits

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
        with contextlib.redirect_stdout(io.StringIO()):  # hides the banner of viser
            viser_server = guarded_server(PORT if port is None else port)
    except ImportError:
        what = "the live view requires viser, which is not installed; or write a page with --html"
        raise InputError(what) from None
    viser_server.gui.configure_theme(show_logo=False, show_share_button=False)
    try:
        if port and viser_server.get_port() != port:
            raise InputError(f"port {port} is already used; choose another with --port")
        if browser:
            webbrowser.open(address(viser_server))
        yield viser_server
    finally:
        with contextlib.redirect_stdout(io.StringIO()):
            viser_server.stop()


def address(viser_server: Any) -> str:
    """Return the address for a browser."""
    return f"http://{HOST}:{viser_server.get_port()}"


def _viser_scenes(viser_server: Any, stages: Sequence[Stage]) -> list[ViserScene]:
    """Create a viser scene per stage, side by side, and a camera that shows all."""
    view = view_of(stages[0])
    apart = 1.1 * max(stage.reach for stage in stages)
    viser_server.scene.set_up_direction(tuple(view.up))
    scenes = []
    for i, stage in enumerate(stages):
        scene = ViserScene(viser_server, f"/{i}", i * apart * view.right)
        scene.draw_floor(view_of(stage))
        scenes.append(scene)
    _set_camera(viser_server, view, 0.5 * (len(stages) - 1) * apart * view.right, len(stages))
    return scenes


def _set_camera(viser_server: Any, view: CameraView, middle: FloatArray, count: int) -> None:
    camera = viser_server.initial_camera
    camera.up = tuple(view.up)
    camera.fov = _FIELD_OF_VIEW
    middle = (
        view.centre + middle + 0.15 * view.reach * view.right
    )  # leaves space for the controls on the right
    camera.look_at = tuple(middle)
    camera.position = tuple(middle + (view.eye - view.centre) * (0.4 + 0.6 * count))


def _add_switches(viser_server: Any, scenes: Sequence[ViserScene], stages: Sequence[Stage]) -> None:
    """Add one switch per group with shapes."""
    used = {shape.group for stage in stages for shape in stage.scene(len(stage) - 1)}
    with viser_server.gui.add_folder("Show"):
        for group in s.GROUPS:
            if group in used:
                box = viser_server.gui.add_checkbox(group, group not in s.HIDDEN_AT_FIRST)
                box.on_update(_visibility_handler(scenes, group))


def _visibility_handler(scenes: Sequence[ViserScene], group: str) -> Callable[[Any], None]:
    def show(event: Any) -> None:
        for scene in scenes:
            scene.show(group, event.target.value)

    return show


def show_replay(viser_server: Any, acts: Sequence[Act], ended: Ended) -> None:
    """Show motions side by side with player controls until `ended` returns true."""
    viser_server.scene.reset()
    viser_server.gui.reset()
    stages = [act.stage for act in acts]
    scenes = _viser_scenes(viser_server, stages)
    for act in acts:
        viser_server.gui.add_html(heading(act.title, *act.notes))
    end = max(float(stage.motion.time[-1]) for stage in stages)
    clock = _Clock(end)
    button = viser_server.gui.add_button("Play")
    button.on_click(lambda event: clock.toggle())
    slider = viser_server.gui.add_slider("time [s]", 0.0, max(end, 1e-3), 1e-3, 0.0)
    speed = viser_server.gui.add_dropdown("speed", _SPEEDS, initial_value="1")
    _add_legend(viser_server, stages[0])
    _add_switches(viser_server, scenes, stages)
    drawn, before = None, time.perf_counter()
    while not ended():
        now = time.perf_counter()
        if clock.playing:
            slider.value = clock.advance(slider.value, float(speed.value) * (now - before))
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
        self._restarts = False
        self.playing = False

    def toggle(self) -> None:
        self.playing = not self.playing
        self._restarts = self.playing

    def advance(self, at: float, seconds: float) -> float:
        """Return the replay time after a number of seconds.

        Args:
            at: Current replay time, in [s].
            seconds: Elapsed time, in [s].
        """
        begin = 0.0 if self._restarts and at >= self._end else at
        self._restarts = False
        self.playing = begin + seconds < self._end
        return min(begin + seconds, self._end)


def frame_at(motion: Motion, t: float) -> int:
    """Return the index of the last frame at or before time t, at least 0."""
    return max(int(np.searchsorted(motion.time, t + 1e-9, side="right")) - 1, 0)


def _add_legend(viser_server: Any, stage: Stage) -> None:
    if stage.motion.tensions is None or not stage.robot.muscles:
        return
    low, high = stage.tension_range(0)
    ramp = ",".join(f"rgb{colour}" for colour in colours.RAMP)
    bar = f"height:9px;border-radius:4px;background:linear-gradient(90deg,{ramp})"
    viser_server.gui.add_html(
        f'<div style="padding:4px 12px">tension {low:.4g} to {high:.4g} N'
        f'<div style="{bar}"></div></div>'
    )


def show_robot(viser_server: Any, robot: Robot, meshes: LinkMeshes, ended: Ended) -> None:
    """Show a robot with joint sliders and a table of muscles until `ended` returns true."""
    paths = MusclePaths(robot)
    sliders = []
    viser_server.gui.add_html(heading(robot.name))
    with viser_server.gui.add_folder("Joints"):
        for c in robot.coordinates:
            low = c.lower if np.isfinite(c.lower) else -_UNLIMITED_RANGE[c.unit]
            high = c.upper if np.isfinite(c.upper) else _UNLIMITED_RANGE[c.unit]
            high = max(high, low + 1e-6)
            start = float(np.clip(c.initial, low, high))
            step = (high - low) / 1000.0
            sliders.append(
                viser_server.gui.add_slider(f"{c.name} [{c.unit}]", low, high, step, start)
            )
    stage = Stage(robot, Motion.still([slider.value for slider in sliders]), meshes)
    scenes = _viser_scenes(viser_server, [stage])
    table = viser_server.gui.add_html("")
    _add_switches(viser_server, scenes, [stage])
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


def live_drawing(
    viser_server: Any, robot: Robot, meshes: LinkMeshes, world: Scene | None = None
) -> Watch:
    """Return a function that draws a run in progress, for `run(..., watch=...)`."""
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
            scenes.extend(_viser_scenes(viser_server, [stage]))
        scenes[0].draw(stage.scene(len(stage) - 1))
        # at least three quarters of the time remain for the run
        due = begin + max(1.0 / _FRAME_RATE, 4.0 * (time.perf_counter() - begin))

    return watch
