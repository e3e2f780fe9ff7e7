from __future__ import annotations

import re
import shutil
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.browser import Page, opened_browser
from support.command_line import CommandLine
from support.process_output import wait_until
from support.recorded import sinusoidal_result
from support.robots.robots import EXAMPLES, PLANAR_2R, planar_2r

from addin_sdfusion.robot import InputError
from cardsflow_fmu import Experiment, run
from cardsflow_fmu.results.viewer import Motion, Stage, motion_of
from cardsflow_fmu.results.viewer.live import live
from cardsflow_fmu.results.viewer.scene.act import Act
from cardsflow_fmu.simulation.run import simulate
from sim_dart import MusclePaths


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("results")
    run(Experiment.load(PLANAR_2R, {"run.duration": 2.0}), folder, coupling="direct")
    return folder


@pytest.fixture
def opened() -> Iterator[Any]:
    with live.server() as server:
        yield server


def start_command(*words: object) -> subprocess.Popen[str]:
    command = [sys.executable, "-m", "cardsflow_fmu.cli", *map(str, words)]
    pipe = subprocess.PIPE
    return subprocess.Popen(command, stdout=pipe, stderr=pipe, text=True)


def address_of(process: subprocess.Popen[str]) -> str:
    """Return the address that a command prints."""
    line = process.stderr.readline()
    found = re.match(r"(http://127\.0\.0\.1:\d+)  \(press Ctrl-C to stop\)$", line)
    if not found:
        process.kill()  # it runs until it is stopped
        pytest.fail(line + process.stderr.read())
    return found[1]


def test_moment_arms_in_the_table_match_the_closed_form() -> None:
    """A straight cable from p to a point u on a link that rotates about y: r = -dl/dq."""
    robot = planar_2r()
    q = [0.3, -0.2]
    table = live.muscle_table(robot, MusclePaths(robot), q)
    rows = [re.findall(r"<td>([^<]*)</td>", row) for row in table.split("<tr>")[2:]]
    assert [row[0] for row in rows] == [muscle.name for muscle in robot.muscles]
    for row, muscle in zip(rows, robot.muscles, strict=True):
        base, moving = (np.array(point.position) for point in muscle.via_points)
        assert muscle.via_points[0].link == "world"

        def length(a: float, b: float, m: Any = muscle, p: Any = base, u: Any = moving) -> float:
            def turned(angle: float, v: np.ndarray) -> np.ndarray:
                c, s = np.cos(angle), np.sin(angle)
                return np.array([c * v[0] + s * v[2], v[1], -s * v[0] + c * v[2]])

            if m.via_points[1].link == "link_1":
                return float(np.linalg.norm(turned(a, u) - p))
            elbow = turned(a, np.array([0.0, 0.0, 1.0]))
            return float(np.linalg.norm(elbow + turned(a + b, u) - p))

        h = 1e-6
        arms = [
            -(length(q[0] + h, q[1]) - length(q[0] - h, q[1])) / (2 * h),
            -(length(q[0], q[1] + h) - length(q[0], q[1] - h)) / (2 * h),
        ]
        expected = [length(*q), *arms]
        np.testing.assert_allclose([float(cell) for cell in row[1:]], expected, atol=6e-5)


def test_frame_changes_at_its_time() -> None:
    motion = Motion(np.array([0.0, 0.04, 0.08]), np.zeros((3, 1)))
    assert [live.frame_at(motion, t) for t in (-1.0, 0.0, 0.039, 0.04, 9.0)] == [0, 0, 0, 1, 2]


def test_server_only_listens_on_loopback(opened: Any) -> None:
    port = opened.get_port()
    assert live.address(opened) == f"http://127.0.0.1:{port}"
    with socket.create_connection(("127.0.0.1", port), 60) as connection:
        connection.sendall(b"no request\r\n\r\n")
        while connection.recv(1000):  # until the server has closed it
            pass
    listening = [  # of /proc/net/tcp: state 0A, address in hexadecimal
        line.split()[1]
        for line in Path("/proc/net/tcp").read_text().splitlines()[1:]
        if line.split()[3] == "0A" and line.split()[1].endswith(f":{port:04X}")
    ]
    assert listening == [f"0100007F:{port:04X}"]


def test_used_port_is_an_input_error(opened: Any) -> None:
    with (
        pytest.raises(InputError, match=r"port \d+ is already used; choose another with --port"),
        live.server(opened.get_port()),
    ):
        pass


def test_missing_viser_is_named_in_the_message(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "viser", None)
    with pytest.raises(InputError, match=r"requires viser.*--html"), live.server():
        pass


@pytest.mark.slow
def test_live_drawing_does_not_change_a_run(opened: Any) -> None:
    experiment = Experiment.load(PLANAR_2R, {"run.duration": 1.0})
    seen: list[int] = []
    draw = live.live_drawing(opened, experiment.robot, {})

    def watch(names: tuple[str, ...], rows: np.ndarray) -> None:
        seen.append(len(rows))
        draw(names, rows)

    result = simulate(experiment, compute="python", coupling="direct", watch=watch)
    alone = simulate(experiment, compute="python", coupling="direct")
    assert seen[-1] == 1000
    assert seen == sorted(set(seen))
    np.testing.assert_array_equal(result.rows, alone.rows)
    assert opened.scene.get_handle_by_name("/0/links/rod_100") is not None
    assert opened.scene.get_handle_by_name("/0/trail/ball_100") is not None


def test_two_runs_are_replayed_side_by_side(opened: Any) -> None:
    robot = planar_2r()
    acts = [
        Act(Stage(robot, motion_of(robot, sinusoidal_result(robot, t))), f"{t} s")
        for t in (1.0, 2.0)
    ]
    pictures = iter(range(30))
    live.show_replay(opened, acts, lambda: next(pictures, None) is None)
    for side in "01":
        rods = opened.scene.get_handle_by_name(f"/{side}/muscles/rod_100")
        assert len(rods.batched_positions) == 4
    roots = [opened.scene.get_handle_by_name(f"/{side}").position for side in "01"]
    assert np.linalg.norm(roots[1] - roots[0]) > acts[0].stage.reach


def test_sliders_change_the_robot_and_the_table(
    opened: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    sliders: list[Any] = []
    tables: list[Any] = []
    for name, kept in (("add_slider", sliders), ("add_html", tables)):
        made = getattr(opened.gui, name)
        monkeypatch.setattr(
            opened.gui, name, lambda *a, m=made, k=kept, **w: k.append(m(*a, **w)) or k[-1]
        )
    over = threading.Event()
    shown = threading.Thread(target=live.show_robot, args=(opened, planar_2r(), {}, over.is_set))
    shown.start()
    try:
        assert wait_until(lambda: tables and "<table>" in tables[-1].content)
        before = tables[-1].content
        rods = opened.scene.get_handle_by_name("/0/links/rod_100")
        at = rods.batched_wxyzs.copy()
        sliders[1].value = 1.0
        assert wait_until(lambda: tables[-1].content != before)
        assert len(sliders) == 2
        assert not np.array_equal(rods.batched_wxyzs, at)
    finally:
        over.set()
        shown.join(10)


@pytest.mark.slow
def test_ctrl_c_ends_a_view_without_an_error(results: Path) -> None:
    process = start_command("view", results, "--no-browser")
    address_of(process)
    time.sleep(0.5)
    process.send_signal(signal.SIGINT)
    assert process.communicate(timeout=300) == ("", "")
    assert process.returncode == 0


@pytest.mark.slow
def test_run_with_view_shows_the_run_and_then_its_replay(tmp_path: Path) -> None:
    settings = ("--set", "run.duration=0.5", "-o", tmp_path)
    process = start_command("run", PLANAR_2R, *settings, "--view", "--no-browser")
    address_of(process)
    assert "complete" in process.stdout.readline()
    time.sleep(0.5)
    assert process.poll() is None
    process.send_signal(signal.SIGINT)
    process.communicate(timeout=300)
    assert process.returncode == 0
    assert (tmp_path / "results.csv").is_file()


@pytest.mark.slow
def test_command_writes_pages_of_runs_and_robots(
    results: Path, tmp_path: Path, cardsflow: CommandLine
) -> None:
    for words in ([results], [results, results], [PLANAR_2R / "robot"]):
        file = tmp_path / f"{len(words)}.html"
        assert cardsflow("view", *words, "--html", file)[:2] == (0, f"{file}\n")
        assert file.read_text().startswith("<!DOCTYPE html>")


def test_missing_meshes_are_reported_first(tmp_path: Path, cardsflow: CommandLine) -> None:
    shutil.copytree(EXAMPLES / "pick_up/robot", tmp_path / "robot")
    shutil.rmtree(tmp_path / "robot/meshes")
    code, _, err = cardsflow("view", tmp_path / "robot", "--html", tmp_path / "arm.html")
    assert code == 0
    assert "mesh files are not found, such as" in err.splitlines()[0]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["nowhere"], "cannot be read"),
        ([PLANAR_2R / "robot", PLANAR_2R / "robot"], "only results can be shown side by side"),
        ([PLANAR_2R / "robot", "--cable-set", "basik"], "did you mean 'basic"),
    ],
)
def test_invalid_view_options_are_rejected(
    words: list[Any], message: str, tmp_path: Path, cardsflow: CommandLine
) -> None:
    assert message in cardsflow.error_line("view", *words, "--html", tmp_path / "page.html")
    assert not (tmp_path / "page.html").exists()


def picture(page: Page) -> np.ndarray:
    """Return the image left of the controls, after the coloured muscles are drawn."""
    begin = time.perf_counter()
    while time.perf_counter() - begin < 300.0:
        image = page.screenshot()[:, :250]
        if np.count_nonzero(np.ptp(image, axis=2) > 60) > 50:
            return image
    raise AssertionError("the robot does not appear")


BUTTON = "[...document.querySelectorAll('button')].find(b => /^(Play|Pause)$/.test(b.textContent))"
TIME = "[...document.querySelectorAll('input[type=text]')].find(i => i.inputMode === 'decimal')"


@pytest.mark.browser
def test_live_view_draws_and_plays_without_other_connections(results: Path, tmp_path: Path) -> None:
    process = start_command("view", results, "--no-browser")
    try:
        url = address_of(process)
        with opened_browser(tmp_path, size=(480, 320)) as page:
            page.open(url)
            page.wait_for(f"document.querySelector('canvas') && {BUTTON} && {TIME}")
            first = picture(page)  # the first image of software WebGL is slow
            page.evaluate(f"{BUTTON}.click()")
            page.wait_for(f"{BUTTON}?.textContent === 'Play' && Number({TIME}.value) === 2")
            second = picture(page)
            assert np.count_nonzero(np.abs(second - first).max(axis=2) > 40) > 50
            assert page.errors == []
            asked = {re.sub(r"^(data|blob):.*", r"\1:", request) for request in page.requests}
            assert all(a in ("data:", "blob:") or a.startswith(url) for a in asked), asked
    finally:
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=300)
    assert process.returncode == 0


@pytest.mark.slow
def test_cable_set_option_is_rejected_for_a_run(results: Path, cardsflow: CommandLine) -> None:
    words = "view", results, "--cable-set", "basic", "--html", "page.html"
    assert "--cable-set: is only for a robot" in cardsflow.error_line(*words)
