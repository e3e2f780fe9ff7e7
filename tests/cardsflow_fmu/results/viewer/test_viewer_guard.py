"""Files and other web sites cannot execute code in the browser of the user."""

from __future__ import annotations

import http.client
import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from support.browser import opened_browser
from support.recorded import sinusoidal_result
from support.robots.robots import planar_2r

from addin_sdfusion.robot import Muscle, Robot
from cardsflow_fmu.results.viewer import Stage, motion_of
from cardsflow_fmu.results.viewer.html.page import replay_page
from cardsflow_fmu.results.viewer.live import live
from cardsflow_fmu.results.viewer.scene.act import Act
from sim_dart import MusclePaths

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
def opened() -> Iterator[Any]:
    with live.server() as server:
        yield server


def is_plain(text: str) -> bool:
    """Return whether HTML only contains tags of tables and lines."""
    return set(re.findall(r"<\s*/?\s*([a-zA-Z!]+)", text)) <= {
        "div",
        "b",
        "table",
        "tr",
        "th",
        "td",
    }


def test_titles_notes_and_tables_are_escaped() -> None:
    robot = evil_robot()
    assert is_plain(live.heading(EVIL, EVIL, "second"))
    table = live.muscle_table(robot, MusclePaths(robot), [0.1, 0.2])
    assert is_plain(table)
    assert "&lt;iframe" in table


def test_names_are_not_passed_to_markdown(opened: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """Markdown of viser would execute scripts and open local images."""
    texts: list[str] = []
    made = opened.gui.add_html
    monkeypatch.setattr(opened.gui, "add_html", lambda text: texts.append(text) or made(text))

    def refused(*args: object, **options: object) -> None:
        raise AssertionError("Markdown")

    monkeypatch.setattr(opened.gui, "add_markdown", refused)
    robot = evil_robot()
    pictures = iter(range(2))
    live.show_robot(opened, robot, {}, lambda: next(pictures, None) is None)
    pictures = iter(range(2))
    act = Act(Stage(robot, motion_of(robot, sinusoidal_result(robot, 1.0))), EVIL, (EVIL,))
    live.show_replay(opened, [act], lambda: next(pictures, None) is None)
    assert any("&lt;img" in text for text in texts)
    assert all(map(is_plain, texts))


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


SOCKET = {
    "Upgrade": "websocket",
    "Connection": "Upgrade",
    "Sec-WebSocket-Version": "13",
    "Sec-WebSocket-Key": "dGhlIHNhbXBsZSBub25jZQ==",
}


@pytest.mark.parametrize("kind", [{}, SOCKET], ids=["page", "socket"])
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
    opened: Any, kind: dict[str, str], host: str | None, origin: str | None, admitted: bool
) -> None:
    port = opened.get_port()
    given = {"Host": host, "Origin": origin} | kind
    headers = {name: value.format(port) for name, value in given.items() if value is not None}
    status = answer(port, headers).status
    assert status == ((101 if kind else 200) if admitted else 403)


def test_page_may_only_connect_to_its_server(opened: Any) -> None:
    port = opened.get_port()
    policy = answer(port, {"Host": f"127.0.0.1:{port}"}).getheader("Content-Security-Policy")
    assert policy is not None
    assert policy.startswith("default-src 'self'")
    assert "http" not in policy
    assert "frame-src 'none'" in policy


def test_client_cannot_make_the_server_open_a_tunnel(opened: Any) -> None:
    assert opened.request_share_url() is None
    assert opened._share_tunnel is None


def test_markup_in_names_is_escaped_in_a_replay_page() -> None:
    robot = evil_robot()
    act = Act(Stage(robot, motion_of(robot, sinusoidal_result(robot, 1.0))), EVIL, (EVIL,))
    page = replay_page([act])
    assert "evil.example" not in re.sub(r"<title>[^<]*</title>", "", page)
    assert "<iframe" not in page


@pytest.mark.browser
@pytest.mark.parametrize("kind", ["live", "page"])
def test_scripts_in_names_are_not_executed_in_a_browser(
    opened: Any, tmp_path: Path, kind: str
) -> None:
    robot = evil_robot()
    act = Act(Stage(robot, motion_of(robot, sinusoidal_result(robot, 1.0))), EVIL, (EVIL,))
    with opened_browser(tmp_path, size=(480, 320)) as page:
        if kind == "page":
            file = tmp_path / "page.html"
            file.write_text(replay_page([act]))
            page.open(file.as_uri())
        else:
            page.open(live.address(opened))
        seen = "document.body?.innerText.includes('onerror')"

        def over() -> bool:
            return bool(page.evaluate(f"!!({seen})"))

        if kind == "live":
            live.show_replay(opened, [act], over)
        page.wait_for(seen)
        assert not page.evaluate("!!document.querySelector('iframe, img[src=x]')")
        assert not [url for url in page.requests if "evil.example" in url or "passwd" in url]
        assert page.errors == []
