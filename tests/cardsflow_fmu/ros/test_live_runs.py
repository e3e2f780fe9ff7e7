"""Live topics as independent peers over zenoh see them: the graph, the messages, late comers."""

from __future__ import annotations

import json
import struct
import time
from collections import defaultdict
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
from cardsflow_fmu.middleware.address import node_address
from support.command_line import CommandLine
from support.recorded import waving, with_columns
from support.robots.robots import PLANAR_2R
from support.ros.router import router_on_loopback

from addin_sdfusion.robot import InputError
from cardsflow_fmu import Experiment
from cardsflow_fmu.ros.publisher import RunPublisher, published
from cardsflow_fmu.ros.scene_topics import Shown
from cardsflow_fmu.signals.ports import coordinate_signals

pytestmark = pytest.mark.extra("ros2-zenoh")

JOINT_STATE = "sensor_msgs/msg/JointState"
LONGEST = 20.0
"""Time to wait for a condition, in [s]."""


def until(condition: Callable[[], Any]) -> Any:
    """The first result that is true."""
    end = time.monotonic() + LONGEST
    while not (found := condition()):
        assert time.monotonic() < end, "in vain"
        time.sleep(0.01)
    return found


@pytest.fixture(scope="module")
def router() -> Iterator[tuple[Any, int]]:
    """A router as rmw_zenoh's, and its port."""
    with router_on_loopback() as there:
        yield there


def experiment() -> Experiment:
    """The paper's two-link arm."""
    return Experiment.load(PLANAR_2R)


def rows_of(run: Experiment) -> Any:
    """A made-up motion with velocities."""
    plain = waving(run.robot, 1.0)
    names = coordinate_signals("qd", run.robot)
    return with_columns(plain, {name: np.cos(plain["time"]) for name in names})


class Peer:
    """What a peer without our code receives, by the topic's name; decoded by rosbags alone."""

    def __init__(self, session: Any, domain: int) -> None:
        self.received: dict[str, list[tuple[str, bytes, bytes]]] = defaultdict(list)
        self.session, self._domain = session, domain
        self._subscriber = session.declare_subscriber(f"{domain}/**", self._take)

    def _take(self, sample: Any) -> None:
        _, *topic, kind, hashed = str(sample.key_expr).split("/")
        content = (f"{kind}/{hashed}", bytes(sample.payload), bytes(sample.attachment))
        self.received["/" + "/".join(topic)].append(content)

    def graph(self) -> list[str]:
        """The liveliness tokens of the domain."""
        answers = self.session.liveliness().get(f"@ros2_lv/{self._domain}/**")
        return [str(answer.ok.key_expr) for answer in answers]


def test_a_peer_sees_the_graph_and_every_message(router: tuple[Any, int]) -> None:
    from rosbags.typesys import Stores, get_typestore

    store, (session, port) = get_typestore(Stores.ROS2_JAZZY), router
    address = node_address(f"ros2://127.0.0.1:{port}/arm/left?domain=7&node=shown")
    watched, run = experiment(), rows_of(experiment())
    peer_ = Peer(session, 7)
    with published(watched, address) as watch:
        watch(run.names, run.rows[:30])
        until(lambda: "/arm/left/cables" in peer_.received)
        watch(run.names, run.rows[:50])
        until(lambda: len(peer_.received["/arm/left/joint_states"]) > 1)
        tokens = peer_.graph()
    until(lambda: not peer_.graph())
    nodes = [token.split("/") for token in tokens if "/NN/" in token]
    assert [node[-2:] for node in nodes] == [["%arm%left", "shown"]]
    topics = {token.split("/")[9].replace("%", "/"): token for token in tokens if "/MP/" in token}
    assert set(peer_.received) <= set(topics)
    assert {"/clock", "/tf", "/arm/left/robot_description"} <= set(topics)
    assert topics["/arm/left/robot_description"].endswith("/:1:,1:,:,:,,")
    assert topics["/clock"].endswith("/::,10:,:,:,,")
    for row, (key, content, attachment) in zip(
        (29, 49), peer_.received["/arm/left/joint_states"], strict=True
    ):
        hashed = store.hash_rihs01(JOINT_STATE)
        assert key == f"sensor_msgs::msg::dds_::JointState_/{hashed}"
        message = store.deserialize_cdr(content, JOINT_STATE)
        np.testing.assert_array_equal(message.position, run.rows[row, 1:3])
        assert message.name == [c.name for c in watched.robot.coordinates]
        number, when, length, identity = struct.unpack("<qqB16s", attachment)
        assert (number, length) == (1 if row == 29 else 2, 16)
        assert abs(time.time_ns() - when) < LONGEST * 1e9
    import xxhash

    text = topics["/arm/left/joint_states"].encode()
    assert identity == xxhash.xxh3_128_digest(text)[::-1]
    clock = store.deserialize_cdr(peer_.received["/clock"][-1][1], "rosgraph_msgs/msg/Clock").clock
    assert clock.sec + clock.nanosec * 1e-9 == pytest.approx(run["time"][49])


def test_who_comes_late_gets_the_description(router: tuple[Any, int]) -> None:
    import zenoh

    session, port = router
    got: list[Any] = []
    with published(experiment(), node_address(f"ros2://127.0.0.1:{port}?domain=8")):
        zenoh.ext.declare_advanced_subscriber(
            session,
            "8/robot_description/**",
            got.append,
            history=zenoh.ext.HistoryConfig(detect_late_publishers=True),
        )
        until(lambda: got)
    assert b"<robot name" in bytes(got[0].payload)


def test_a_run_is_published_in_real_time(
    router: tuple[Any, int], cardsflow: CommandLine, tmp_path: Any
) -> None:
    session, port = router
    peer_ = Peer(session, 9)
    words = ("--set", "run.duration=0.5", "--direct", "--json", "-o", tmp_path / "out")
    code, out, err = cardsflow(
        "run", PLANAR_2R, "--publish", f"ros2://127.0.0.1:{port}?domain=9", *words
    )
    assert code == 0, err
    assert f"published as node /cardsflow in domain 9, over the router tcp/127.0.0.1:{port}" in err
    assert json.loads(out)["status"] == "complete"
    until(lambda: len(peer_.received["/clock"]) >= 3)
    assert json.loads(out)["real_time_factor"] < 1.1


def test_without_a_router_nothing_runs(cardsflow: CommandLine, tmp_path: Any) -> None:
    uri = "ros2://127.0.0.1:1"
    line = cardsflow.refused("run", PLANAR_2R, "--publish", uri, "-o", tmp_path / "out")
    assert "no router answers at tcp/127.0.0.1:1" in line
    assert not (tmp_path / "out").exists()


def test_what_goes_wrong_in_publishing_ends_no_run() -> None:
    class Broken:
        def advertise(self, topic: Any) -> None:
            """Take note."""

        def publish(self, topic: Any, content: bytes) -> None:
            if topic.name == "/joint_states":
                raise InputError("gone")

    run = rows_of(experiment())
    publisher = RunPublisher(Shown.of(experiment()), Broken())
    publisher.watch(run.names, run.rows)
    publisher.stop()
    publisher.run()
    assert str(publisher.failure) == "gone"
