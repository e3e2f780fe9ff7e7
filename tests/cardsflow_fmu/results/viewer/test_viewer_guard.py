"""Files and other web sites cannot execute code in the browser of the user."""

from __future__ import annotations

import http.client
import re
import socket
import struct
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from support.browser import Page
from support.recorded import sinusoidal_result
from support.robots.robots import planar_2r

from addin_sdfusion.robot import Muscle, Robot
from cardsflow_fmu.results.viewer import Motion, Stage, motion_of
from cardsflow_fmu.results.viewer.html.page import replay_page
from cardsflow_fmu.results.viewer.live.page_server import PageServer, page_server
from cardsflow_fmu.results.viewer.scene.act import Act

EVIL = (
    "<img src=x onerror=\"fetch('http://evil.example/')\">"
    "<iframe srcdoc='<script>parent.document.title=1</script>'></iframe>"
    "![x](/etc/passwd) [x](javascript:alert(1)) </script><script>alert(1)</script> &amp; **b**"
)


def evil_robot() -> Robot:
    """Return a robot with scripts in all names."""
    robot = planar_2r()
    cables = robot.cable_sets[0]

    def renamed(k: int, muscle: Muscle) -> Muscle:
        return replace(muscle, name=f"{EVIL}{k}")

    muscles = tuple(renamed(k, muscle) for k, muscle in enumerate(cables.muscles))
    joints = tuple(
        replace(j, coordinates=tuple(replace(c, name=f"{EVIL}{k}{c.name}") for c in j.coordinates))
        for k, j in enumerate(robot.joints)
    )
    return replace(
        robot,
        name=EVIL,
        joints=joints,
        cable_sets=(replace(cables, muscles=muscles), *robot.cable_sets[1:]),
        cable_set=cables.name,
    )


@pytest.fixture
def opened() -> Iterator[PageServer]:
    with page_server("<p>page</p>") as server:
        yield server


def port_of(server: PageServer) -> int:
    return int(server.address.rstrip("/").rpartition(":")[2])


def answer(port: int, headers: dict[str, str], path: str = "/") -> http.client.HTTPResponse:
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=300)
    try:
        connection.putrequest("GET", path, skip_host=True, skip_accept_encoding=True)
        for name, value in headers.items():
            connection.putheader(name, value)
        connection.endheaders()
        response = connection.getresponse()
        response.read()
        return response
    finally:
        connection.close()


@pytest.mark.parametrize(
    ("host", "origin", "admitted"),
    [
        ("127.0.0.1:{}", None, True),
        ("localhost:{}", None, True),
        ("127.0.0.1:{}", "http://127.0.0.1:{}", True),
        ("localhost:{}", "http://localhost:{}", True),
        ("localhost:9000", "http://localhost:9000", True),  # through a custom tunnel
        ("127.0.0.1:{}", "http://evil.example", False),
        ("127.0.0.1:{}", "http://127.0.0.1:1", False),
        ("127.0.0.1:{}", "http://127.0.0.1.evil.example:{}", False),
        ("127.0.0.1:{}", "https://127.0.0.1:{}", False),
        ("127.0.0.1:{}", "null", False),
        ("evil.example:{}", None, False),
        ("evil.example:{}", "http://evil.example:{}", False),
        ("127.0.0.1@evil.example:{}", None, False),
        ("127.0.0.1:{}, evil.example", None, False),
        ("127.0.0.1/x", None, False),
        ("[", None, False),
        ("", None, False),
        (None, None, False),
    ],
)
def test_requests_of_other_sites_and_host_names_are_rejected(
    opened: PageServer, host: str | None, origin: str | None, admitted: bool
) -> None:
    port = port_of(opened)
    given = {"Host": host, "Origin": origin}
    headers = {name: value.format(port) for name, value in given.items() if value is not None}
    for path in ("/", "/nothing"):
        status = answer(port, headers, path).status
        assert status == ((200 if path == "/" else 404) if admitted else 403)


@pytest.mark.parametrize(
    "data", [b"no request\r\n\r\n", b"GET / HTTP/9\r\n\r\n", b"\xff" * 9000, b"GET /frames", b""]
)
def test_garbage_of_clients_prints_nothing(
    opened: PageServer, data: bytes, capfd: pytest.CaptureFixture[str]
) -> None:
    with socket.create_connection(("127.0.0.1", port_of(opened)), 60) as connection:
        connection.sendall(data)
        linger = struct.pack("ii", 1, 0)  # close with a reset
        connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, linger)
    assert answer(port_of(opened), {"Host": f"127.0.0.1:{port_of(opened)}"}).status == 200
    assert capfd.readouterr() == ("", "")


def test_events_are_streamed_and_the_page_can_be_replaced(opened: PageServer) -> None:
    port = port_of(opened)
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=60)
    connection.request("GET", "/frames")
    stream = connection.getresponse()
    assert stream.getheader("Content-Type") == "text/event-stream"
    opened.send("[1]")
    assert stream.readline() == b"data: [1]\n"
    stream.readline()
    opened.replace("<p>other</p>")
    assert stream.readline() == b"event: reload\n"
    connection.close()
    assert opened.page == b"<p>other</p>"


def test_page_only_executes_its_script() -> None:
    page = replay_page([Act(Stage(planar_2r(), Motion.still([0.1, 0.2])), "arm")])
    policy = re.search(r'Policy" content="([^"]*)"', page)[1]
    assert policy.startswith("default-src 'none'; script-src 'sha256-")
    assert "unsafe-inline" not in policy.split(";")[1]
    assert "http" not in policy


def test_markup_in_names_is_escaped_in_a_replay_page() -> None:
    robot = evil_robot()
    act = Act(Stage(robot, motion_of(robot, sinusoidal_result(robot, 1.0))), EVIL, (EVIL,))
    page = replay_page([act])
    assert "evil.example" not in re.sub(r"<title>[^<]*</title>", "", page)
    assert "<iframe" not in page


@pytest.mark.browser
def test_scripts_in_names_are_not_executed_in_a_browser(page: Page, tmp_path: Path) -> None:
    robot = evil_robot()
    act = Act(Stage(robot, motion_of(robot, sinusoidal_result(robot, 1.0))), EVIL, (EVIL,))
    file = tmp_path / "page.html"
    file.write_text(replay_page([act]))
    page.open(file.as_uri())
    page.wait_for("document.body?.innerText.includes('onerror')")
    assert not page.evaluate("!!document.querySelector('iframe, img[src=x]')")
    assert not [url for url in page.requests if "evil.example" in url or "passwd" in url]
    assert page.errors == []
    page.evaluate("document.body.insertAdjacentHTML('beforeend', '<p onclick=\"hit = 1\">')")
    page.evaluate("document.querySelector('p').click()")
    assert page.evaluate("typeof hit") == "undefined"
