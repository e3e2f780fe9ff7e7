from __future__ import annotations

import json
import re
import shutil
import signal
import socket
import subprocess
import sys
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.browser import opened_browser
from support.command_line import CommandLine
from support.process_output import wait_until
from support.recorded import sinusoidal_result
from support.robots.robots import EXAMPLES, PLANAR_2R, planar_2r

from cardsflow_fmu import Experiment, run
from cardsflow_fmu.models.browser import pack
from cardsflow_fmu.results.viewer import Stage, motion_of
from cardsflow_fmu.results.viewer.live.page_server import PageServer, page_server
from cardsflow_fmu.results.viewer.live.run_stream import frame_text, stream_frames
from cardsflow_fmu.simulation.run import simulate


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("results")
    run(Experiment.load(PLANAR_2R, {"run.duration": 2.0}), folder, coupling="direct")
    return folder


@pytest.fixture
def opened() -> Iterator[PageServer]:
    with page_server("<p>page</p>") as server:
        yield server


def start_command(*words: object) -> subprocess.Popen[str]:
    command = [sys.executable, "-m", "cardsflow_fmu.cli", *map(str, words)]
    pipe = subprocess.PIPE
    return subprocess.Popen(command, stdout=pipe, stderr=pipe, text=True)


def address_of(process: subprocess.Popen[str]) -> str:
    """Return the address that a command prints."""
    line = process.stderr.readline()
    found = re.match(r"(http://127\.0\.0\.1:\d+/)  \(press Ctrl-C to stop\)$", line)
    if not found:
        process.kill()  # it runs until it is stopped
        pytest.fail(line + process.stderr.read())
    return found[1]


def test_server_only_listens_on_loopback(opened: PageServer) -> None:
    port = int(opened.address.rstrip("/").rpartition(":")[2])
    assert opened.address == f"http://127.0.0.1:{port}/"
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


@pytest.mark.slow
def test_streaming_does_not_change_a_run(opened: PageServer) -> None:
    experiment = Experiment.load(PLANAR_2R, {"run.duration": 1.0})
    seen: list[int] = []
    draw = stream_frames(opened, experiment.robot, {})

    def watch(names: tuple[str, ...], rows: np.ndarray) -> None:
        seen.append(len(rows))
        draw(names, rows)

    result = simulate(experiment, compute="python", coupling="direct", watch=watch)
    alone = simulate(experiment, compute="python", coupling="direct")
    assert seen[-1] == 1000
    assert seen == sorted(set(seen))
    np.testing.assert_array_equal(result.rows, alone.rows)


def test_frame_contains_the_shapes_of_the_last_row() -> None:
    robot = planar_2r()
    stage = Stage(robot, motion_of(robot, sinusoidal_result(robot, 1.0)))
    frame = json.loads(frame_text(stage))
    assert frame["time"] == pytest.approx(1.0, abs=1e-3)
    for shape, sent in zip(stage.scene(len(stage) - 1), frame["shapes"], strict=True):
        assert sent["name"] == shape.name
        np.testing.assert_allclose(sent["points"], shape.points.reshape(-1), atol=1e-6)


@pytest.mark.slow
def test_ctrl_c_ends_a_view_without_an_error(results: Path) -> None:
    process = start_command("view", results, "--no-browser")
    address_of(process)
    process.send_signal(signal.SIGINT)
    assert process.communicate(timeout=300) == ("", "")
    assert process.returncode == 0


@pytest.mark.slow
def test_run_with_view_shows_the_run_and_then_its_replay(tmp_path: Path) -> None:
    settings = ("--set", "run.duration=0.5", "-o", tmp_path)
    process = start_command("run", PLANAR_2R, *settings, "--view", "--no-browser")
    address = address_of(process)
    assert "complete" in process.stdout.readline()
    assert wait_until(lambda: b'id="follows"' not in urllib.request.urlopen(address).read())
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


def test_missing_meshes_are_reported_first(
    tmp_path: Path, cardsflow: CommandLine, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(pack, "wasm_module", lambda: b"module")
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


@pytest.mark.browser
def test_page_follows_a_run_and_then_shows_its_replay(tmp_path: Path) -> None:
    settings = ("--set", "run.duration=8", "--set", "run.compute='python'", "-o", tmp_path / "out")
    process = start_command("run", PLANAR_2R, *settings, "--view", "--no-browser")
    try:
        url = address_of(process)
        with opened_browser(tmp_path, size=(480, 320)) as page:
            page.open(url)
            page.wait_for("document.querySelector('.bar button') && document.body.dataset.drawn")
            assert page.evaluate("document.querySelector('.bar output').textContent").endswith(
                "8.00 s"
            )
            assert page.errors == []
            assert all(one.startswith((url, "data:")) for one in page.requests), page.requests
    finally:
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=300)
    assert process.returncode == 0


@pytest.mark.slow
def test_cable_set_option_is_rejected_for_a_run(results: Path, cardsflow: CommandLine) -> None:
    words = "view", results, "--cable-set", "basic", "--html", "page.html"
    assert "--cable-set: is only for a robot" in cardsflow.error_line(*words)
