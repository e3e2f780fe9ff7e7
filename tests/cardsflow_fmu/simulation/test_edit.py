"""Editing of muscles: evaluation against closed forms, saving, and requests to the server."""

from __future__ import annotations

import copy
import http.client
import json
import math
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import numpy as np
import pytest
from support.robots.robots import EXAMPLES
from support.robots.urdf_arm import TABLE, URDF

from addin_sdfusion.robot import read_robot
from cardsflow_fmu import Experiment, run
from cardsflow_fmu.cli.main import main
from cardsflow_fmu.results.viewer.live.page_server import new_token, page_server
from cardsflow_fmu.simulation.edit import EditSession
from cardsflow_fmu.simulation.starter import init


@pytest.fixture
def arm(tmp_path: Path) -> Path:
    """A URDF without muscles."""
    (tmp_path / "arm.urdf").write_text(URDF)
    return tmp_path / "arm.urdf"


@pytest.fixture
def session(arm: Path) -> EditSession:
    return EditSession(arm, report=lambda line: None)


def document() -> dict[str, Any]:
    """Two muscles of one link about the hinge, at the distance a = 0.05 m from its axis."""
    return {
        "muscles": [
            {
                "name": name,
                "f_min": 10.0,
                "f_max": 100.0,
                "points": [
                    {"link": "base", "position": [x, 0.0, 0.0]},
                    {"link": "upper", "position": [x, 0.0, -0.1]},
                ],
            }
            for name, x in (("front", 0.05), ("back", -0.05))
        ],
        "wraps": [],
    }


def _length(q: float, x: float) -> float:
    """Length for Ry(q) of the point (x, 0, -0.1)."""
    return math.hypot(x * math.cos(q) - 0.1 * math.sin(q) - x, -x * math.sin(q) - 0.1 * math.cos(q))


def test_evaluation_equals_closed_forms(session: EditSession) -> None:
    q, h = 0.3, 1e-6
    answer = session.evaluate({"document": document(), "pose": [q]})
    assert answer["error"] is None
    assert [m["length"] for m in answer["muscles"]] == pytest.approx(
        [_length(q, 0.05), _length(q, -0.05)], abs=1e-15
    )
    assert answer["muscles"][0]["path"][0] == pytest.approx([0.05, 0.0, 0.0])
    arms = [-(_length(q + h, x) - _length(q - h, x)) / (2 * h) for x in (0.05, -0.05)]
    positions, values = answer["moment_arms"]["front"]["shoulder"]["values"]
    assert np.interp(q, positions, values) == pytest.approx(arms[0], abs=1e-3)
    low, high = (min(arms), max(arms))
    assert answer["torque_ranges"]["shoulder"] == pytest.approx(
        [10 * high + 100 * low, 100 * high + 10 * low], rel=1e-6
    )
    turned = np.array(answer["poses"]["upper"][:9]).reshape(3, 3)
    assert turned[0] == pytest.approx([math.cos(q), 0.0, math.sin(q)])


def test_sign_change_is_reported(session: EditSession) -> None:
    changed = document()
    changed["muscles"][0]["points"][1]["position"] = [0.0, 0.0, -0.1]
    changed["muscles"][0]["points"][0]["position"] = [0.0, 0.0, 0.2]
    answer = session.evaluate({"document": changed, "pose": [0.0]})
    assert answer["moment_arms"]["front"]["shoulder"]["sign_change"]
    assert not answer["moment_arms"]["back"]["shoulder"]["sign_change"]
    assert any("changes sign" in line for line in answer["findings"])


def test_muscles_with_errors_are_left_out_of_the_evaluation(session: EditSession) -> None:
    changed = document()
    del changed["muscles"][0]["points"][1:]
    changed["muscles"][1]["wraps"] = [{"surface": "none", "segment": 0}]
    changed["muscles"].append({**document()["muscles"][0], "name": "third"})
    answer = session.evaluate({"document": changed, "pose": [0.0]})
    assert [m["name"] for m in answer["muscles"]] == ["third"]
    assert [line.split(":")[0] for line in answer["findings"][:2]] == ["error", "error"]
    assert "upper" in answer["poses"]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"pose": [0.0, 1.0]}, "pose: must be a list of 1 numbers"),
        ({"pose": [math.nan]}, "pose: must contain finite numbers"),
        ({"pose": ["a"]}, "pose: must contain finite numbers"),
        ({"document": None}, "document: must hold an object"),
        ({"document": {"muscles": [{"name": 1}]}}, "must be of type str"),
    ],
)
def test_invalid_request_is_one_line(
    session: EditSession, change: dict[str, Any], message: str
) -> None:
    error = session.evaluate({"document": document(), "pose": [0.0]} | change)["error"]
    assert message in error
    assert "\n" not in error


def test_saving_shows_the_difference_and_writes(session: EditSession, arm: Path) -> None:
    table = arm.with_name("muscles.csv")
    request = {"document": document(), "digest": session.data(None)["digest"], "write": False}
    shown = session.save(request)
    assert not table.exists()
    assert "+via,front,0,link,base,0.05,0.0,0.0,10.0,100.0,ideal," in shown["diff"]
    written = session.save(request | {"write": True})
    assert (written["error"], written["conflict"], written["path"]) == (None, None, str(table))
    assert [m.name for m in read_robot(arm).muscles] == ["front", "back"]
    again = EditSession(arm).data(None)
    assert again["digest"] == written["digest"]
    assert EditSession(arm).save({"document": again["document"], "digest": ""})["diff"] == ""
    before = table.read_bytes()
    moved = copy.deepcopy(again["document"])
    moved["muscles"][0]["points"][0]["position"][0] = 0.06
    for changed in (moved, again["document"]):
        digest = EditSession(arm).data(None)["digest"]
        assert session.save({"document": changed, "digest": digest, "write": True})["error"] is None
    assert table.read_bytes() == before


def test_file_changed_meanwhile_is_not_overwritten(session: EditSession, arm: Path) -> None:
    arm.with_name("muscles.csv").write_text(TABLE)
    answer = session.save({"document": document(), "digest": "", "write": True})
    assert "changed on disk" in answer["conflict"]
    assert arm.with_name("muscles.csv").read_text() == TABLE


@pytest.mark.parametrize("name", ["../up", "a\nb", " a", "", '"quoted", =1+1 <script>', "ü/\\:"])
def test_hostile_names_stay_in_the_table(session: EditSession, arm: Path, name: str) -> None:
    changed = document()
    changed["muscles"][0]["name"] = name
    answer = session.save({"document": changed, "digest": "", "write": True})
    if name.strip() != name or not name.isprintable() or not name:
        assert "correct it before saving" in answer["error"]
        assert sorted(p.name for p in arm.parent.iterdir()) == ["arm.urdf"]
    else:
        assert answer["error"] is None
        assert read_robot(arm).muscles[0].name == name
        assert sorted(p.name for p in arm.parent.iterdir()) == ["arm.urdf", "muscles.csv"]


def test_table_of_one_of_several_robots_has_its_name(arm: Path) -> None:
    arm.with_name("other.urdf").write_text(URDF)
    assert EditSession(arm).table == arm.with_name("arm.muscles.csv")


def test_muscles_replace_motors_by_effort(arm: Path) -> None:
    arm.write_text(URDF.replace('effort="0"', 'effort="9"'))
    assert [motor.name for motor in read_robot(arm).motors] == ["shoulder"]
    session = EditSession(arm, report=lambda line: None)
    assert session.robot.motors == ()
    assert session.summary == f"0 muscles; changes are saved to {arm.with_name('muscles.csv')}"
    session.save({"document": document(), "digest": "", "write": True})
    assert read_robot(arm).motors == ()


def test_data_of_the_page_contains_laws(session: EditSession) -> None:
    data = session.data("secret")
    assert data["token"] == "secret"
    assert data["digest"] == ""
    force = data["laws"]["mujoco_muscle"][0]
    assert set(force) == {"name", "unit", "default", "lower", "upper", "description"}
    json.dumps(session.data(None)["document"], allow_nan=False)


def test_muscles_of_roboy_are_evaluated() -> None:
    session = EditSession(EXAMPLES / "roboy_left_arm/robot")
    pose = [c.initial for c in session.robot.coordinates]
    answer = session.evaluate({"document": session.data(None)["document"], "pose": pose})
    assert len(answer["muscles"]) == 11
    assert not [line for line in answer["findings"] if line.startswith("error")]


class Client:
    """Client of the server of a page, with the headers of its own page."""

    def __init__(self, address: str) -> None:
        self.host = urlsplit(address).netloc

    def send(
        self,
        path: str,
        body: object,
        method: str = "POST",
        **headers: str,
    ) -> tuple[int, Any]:
        own = {"Content-Type": "application/json", "Origin": f"http://{self.host}"}
        connection = http.client.HTTPConnection(self.host, timeout=10.0)
        text = body if isinstance(body, str) else json.dumps(body)
        connection.request(method, path, text, own | headers)
        answer = connection.getresponse()
        data = answer.read()
        return answer.status, json.loads(data) if answer.status == 200 else None


def test_server_only_answers_its_own_page(session: EditSession, arm: Path) -> None:
    token = new_token()
    actions = {"/evaluate": session.evaluate, "/save": session.save}
    good = {"document": document(), "digest": "", "write": True, "token": token}
    with page_server("<p>page</p>", None, actions, token) as server:
        client = Client(server.address)
        assert client.send("/save", good | {"token": "wrong"})[0] == 403
        assert client.send("/save", {k: v for k, v in good.items() if k != "token"})[0] == 403
        assert client.send("/save", good | {"token": None})[0] == 403
        assert client.send("/save", good, Origin="http://evil.example")[0] == 403
        assert client.send("/save", good, Host="evil.example")[0] == 403
        assert client.send("/save", "{")[0] == 400
        assert client.send("/save", "[" * 100_000)[0] == 400
        assert client.send("/save", good, **{"Content-Type": "text/plain"})[0] == 400
        assert client.send("/../muscles.csv", good)[0] == 404
        assert client.send("/arm.urdf", "", "GET")[0] == 404
        assert client.send("/", "", "GET")[0] == 403
        assert not arm.with_name("muscles.csv").exists()
        status, answer = client.send("/evaluate", good | {"pose": [0.0]})
        assert (status, len(answer["muscles"])) == (200, 2)
        assert client.send("/save", good)[0] == 200
    assert arm.with_name("muscles.csv").exists()


def test_reloaded_page_shows_the_file_on_disk(session: EditSession, arm: Path) -> None:
    def page() -> str:
        session.reload()
        return json.dumps(session.data(None))

    with page_server(page) as server:
        client = Client(server.address)
        arm.with_name("muscles.csv").write_text(TABLE)
        found = client.send("/", "", "GET")[1]
        assert [m["name"] for m in found["document"]["muscles"]] == ["front", "back"]
        assert session.save({**found, "write": True})["conflict"] is None
        arm.with_name("muscles.csv").write_text("name\n")
        assert client.send("/", "", "GET")[0] == 500


def test_urdf_with_new_muscles_tracks_its_first_experiment(
    session: EditSession, arm: Path, tmp_path: Path
) -> None:
    session.save({"document": document(), "digest": "", "write": True})
    init(arm, tmp_path / "experiment.toml")
    changes = {"run.duration": 0.2, "run.coupling": "direct"}
    result = run(Experiment.load(tmp_path, changes), tmp_path / "results")
    assert result.summary["tracking"]["max"] < 1e-4


def test_command_writes_a_page(
    arm: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    page = tmp_path / "edit.html"
    assert main(["edit", str(arm), "--html", str(page)]) == 0
    assert capsys.readouterr().out == f"{page}\n"
    assert '"token": null' in page.read_text()
    assert main(["edit", str(arm), "--json"]) == 2
    assert "--json: needs --html" in capsys.readouterr().err
