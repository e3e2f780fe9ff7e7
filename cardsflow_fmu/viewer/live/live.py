"""The live view in a browser of this machine: a server on loopback, and its controls."""

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
from cardsflow_fmu.utils.arrays import FloatArray
from cardsflow_fmu.viewer.html.page_data import Act
from cardsflow_fmu.viewer.scene import colours
from cardsflow_fmu.viewer.scene import shapes as s
from cardsflow_fmu.viewer.scene.camera import StageView, view_of
from cardsflow_fmu.viewer.scene.meshes import LinkMeshes
from cardsflow_fmu.viewer.scene.motion import Motion, motion_of
from cardsflow_fmu.viewer.scene.stage import Stage
from sim_dart import MusclePaths, Scene

from .viser_scene import Painter

HOST = "127.0.0.1"
PORT = 8080
_PICTURES = 25.0  # a second
_FIELD = 0.72  # of the camera, in [rad]
_SPEEDS = ("0.1", "0.25", "0.5", "1", "2", "4")
_FREE = {"rad": np.pi, "m": 0.5}  # how far a slider reaches for a coordinate without limits

Ended = Callable[[], bool]


@contextlib.contextmanager
def server(port: int | None = None, *, browser: bool = False) -> Iterator[Any]:
    """A viser server that this machine alone can reach.

    Args:
        port: The port; a free one from 8080 on when None.
        browser: Whether to open the browser.

    Raises:
        InputError: viser is missing, or the port is taken.
    """
    try:
        import viser
    except ImportError:
        raise InputError(
            "the live view needs viser: pip install 'cardsflow[viewer]', or write a page by --html"
        ) from None
    with contextlib.redirect_stdout(io.StringIO()):  # its banner
        opened = viser.ViserServer(HOST, PORT if port is None else port, verbose=False)
    opened.gui.configure_theme(
        show_logo=False, show_share_button=False
    )  # sharing leaves the machine
    try:
        if port and opened.get_port() != port:
            raise InputError(f"port {port} is taken; choose another by --port")
        if browser:
            webbrowser.open(address(opened))
        yield opened
    finally:
        with contextlib.redirect_stdout(io.StringIO()):
            opened.stop()


def address(opened: Any) -> str:
    """What to type into a browser."""
    return f"http://{HOST}:{opened.get_port()}"


def _painters(opened: Any, stages: Sequence[Stage]) -> list[Painter]:
    """A painter a stage, side by side, and a camera that sees all."""
    view = view_of(stages[0])
    apart = 1.1 * max(stage.reach for stage in stages)
    opened.scene.set_up_direction(tuple(view.up))
    painters = []
    for i, stage in enumerate(stages):
        painter = Painter(opened, f"/{i}", i * apart * view.aside)
        painter.floor(view_of(stage))
        painters.append(painter)
    _look(opened, view, 0.5 * (len(stages) - 1) * apart * view.aside, len(stages))
    return painters


def _look(opened: Any, view: StageView, middle: FloatArray, count: int) -> None:
    camera = opened.initial_camera
    camera.up = tuple(view.up)
    camera.fov = _FIELD
    middle = view.centre + middle + 0.15 * view.reach * view.aside  # the controls are on the right
    camera.look_at = tuple(middle)
    camera.position = tuple(middle + (view.eye - view.centre) * (0.4 + 0.6 * count))


def _switches(opened: Any, painters: Sequence[Painter], stages: Sequence[Stage]) -> None:
    """A switch a group that has shapes."""
    used = {shape.group for stage in stages for shape in stage.scene(len(stage) - 1)}
    with opened.gui.add_folder("Show"):
        for group in s.GROUPS:
            if group in used:
                box = opened.gui.add_checkbox(group, group not in s.HIDDEN_AT_FIRST)
                box.on_update(_shower(painters, group))


def _shower(painters: Sequence[Painter], group: str) -> Callable[[Any], None]:
    def show(event: Any) -> None:
        for painter in painters:
            painter.show(group, event.target.value)

    return show


def replay(opened: Any, acts: Sequence[Act], ended: Ended) -> None:
    """Show motions side by side with play, scrub, speed and switches, until it is to end.

    Args:
        opened: The server.
        acts: What to show.
        ended: Asked after every picture.
    """
    opened.scene.reset()
    opened.gui.reset()
    stages = [act.stage for act in acts]
    painters = _painters(opened, stages)
    for act in acts:
        opened.gui.add_markdown("  \n".join((f"**{act.title}**", *act.notes)))
    end = max(float(stage.motion.time[-1]) for stage in stages)
    clock = _Clock(end)
    button = opened.gui.add_button("Play")
    button.on_click(lambda event: clock.toggle())
    slider = opened.gui.add_slider("time [s]", 0.0, max(end, 1e-3), 1e-3, 0.0)
    speed = opened.gui.add_dropdown("speed", _SPEEDS, initial_value="1")
    _legend(opened, stages[0])
    _switches(opened, painters, stages)
    drawn, before = None, time.perf_counter()
    while not ended():
        now = time.perf_counter()
        if clock.playing:
            slider.value = clock.moved(slider.value, float(speed.value) * (now - before))
        label = "Pause" if clock.playing else "Play"
        if button.label != label:
            button.label = label
        before = now
        if slider.value != drawn:
            drawn = slider.value
            for painter, stage in zip(painters, stages, strict=True):
                painter.draw(stage.scene(frame_at(stage.motion, drawn)))
        time.sleep(max(0.0, 1.0 / _PICTURES - (time.perf_counter() - now)))


class _Clock:
    """Whether a replay plays, and how its time goes on: it stops at the end, and begins anew."""

    def __init__(self, end: float) -> None:
        self._end = end
        self._again = False
        self.playing = False

    def toggle(self) -> None:
        self.playing = not self.playing
        self._again = self.playing

    def moved(self, at: float, seconds: float) -> float:
        """The time so many seconds after `at`."""
        begin = 0.0 if self._again and at >= self._end else at
        self._again = False
        self.playing = begin + seconds < self._end
        return min(begin + seconds, self._end)


def frame_at(motion: Motion, t: float) -> int:
    """The last frame that is not later than t; the first, if all are."""
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
    """Show a robot with a slider a joint, muscle lengths and moment arms, until it is to end.

    Args:
        opened: The server.
        robot: The robot.
        meshes: What its links look like.
        ended: Asked after every picture.
    """
    paths = MusclePaths(robot)
    sliders = []
    opened.gui.add_markdown(f"**{robot.name}**")
    with opened.gui.add_folder("Joints"):
        for c in robot.coordinates:
            low = c.lower if np.isfinite(c.lower) else -_FREE[c.unit]
            high = c.upper if np.isfinite(c.upper) else _FREE[c.unit]
            high = max(high, low + 1e-6)
            start = float(np.clip(c.initial, low, high))
            step = (high - low) / 1000.0
            sliders.append(opened.gui.add_slider(f"{c.name} [{c.unit}]", low, high, step, start))
    stage = Stage(robot, Motion.still([slider.value for slider in sliders]), meshes)
    painters = _painters(opened, [stage])
    table = opened.gui.add_html("")
    _switches(opened, painters, [stage])
    drawn = None
    while not ended():
        q = [slider.value for slider in sliders]
        if q != drawn:
            drawn = q
            painters[0].draw(Stage(robot, Motion.still(q), meshes).scene(0))
            table.content = muscle_table(robot, paths, q)
        time.sleep(1.0 / _PICTURES)


def muscle_table(robot: Robot, paths: MusclePaths, q: Sequence[float]) -> str:
    """Length and moment arms r = -dl/dq of every muscle at q, as HTML.

    Args:
        robot: The robot.
        paths: Its muscle paths.
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


def _row(tag: str, cells: Sequence[str]) -> str:
    return f"<tr>{''.join(f'<{tag}>{escape(cell)}</{tag}>' for cell in cells)}</tr>"


def follower(opened: Any, robot: Robot, meshes: LinkMeshes, world: Scene | None = None) -> Watch:
    """What draws a run while it goes on, as `run(..., watch=...)` takes it.

    Args:
        opened: The server.
        robot: The robot of the run.
        meshes: What its links look like.
        world: What stands around it.
    """
    painters: list[Painter] = []
    due = 0.0

    def watch(names: tuple[str, ...], rows: FloatArray) -> None:
        nonlocal due
        begin = time.perf_counter()
        if begin < due:
            return
        motion = motion_of(robot, RunData(names, rows, {}, {}), world=world)
        stage = Stage(robot, motion, meshes, world=world)
        if not painters:
            painters.extend(_painters(opened, [stage]))
        painters[0].draw(stage.scene(len(stage) - 1))
        # the run has at least three quarters of the time
        due = begin + max(1.0 / _PICTURES, 4.0 * (time.perf_counter() - begin))

    return watch
