"""Live topics over DDS, as a peer in another process sees them with CycloneDDS's own bytes."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from support.recorded import waving, with_columns
from support.robots.robots import PLANAR_2R

from cardsflow_fmu import Experiment
from cardsflow_fmu.middleware.address import node_address
from cardsflow_fmu.ros.publisher import published
from cardsflow_fmu.signals.ports import coordinate_signals

pytestmark = [pytest.mark.extra("ros2-dds"), pytest.mark.slow]

PEER = Path(__file__).parents[2] / "support/ros/dds_peer.py"
LONGEST = 30.0
"""Time to wait for a peer, in [s]."""


def test_a_peer_sees_the_graph_and_the_messages() -> None:
    from rosbags.typesys import Stores, get_typestore

    watched = Experiment.load(PLANAR_2R)
    plain = waving(watched.robot, 1.0)
    names = coordinate_signals("qd", watched.robot)
    run = with_columns(plain, {name: np.cos(plain["time"]) for name in names})
    words = [sys.executable, str(PEER), "7", "/arm/left/joint_states", str(LONGEST)]
    address = node_address("ros2://127.0.0.1/arm/left?rmw=dds&domain=7&node=shown")
    with (
        published(watched, address) as watch,
        subprocess.Popen(words, stdout=subprocess.PIPE, text=True) as peer,
    ):
        k = 10
        end = time.monotonic() + 2 * LONGEST
        while peer.poll() is None and time.monotonic() < end:
            k = 10 + (k + 1) % 30
            watch(run.names, run.rows[:k])
            try:
                peer.wait(0.05)
            except subprocess.TimeoutExpired:
                continue
        peer.kill()
        seen = json.loads(peer.stdout.read()) if peer.stdout else {}
    store = get_typestore(Stores.ROS2_JAZZY)
    kind, user_data, key = seen["endpoints"]["rt/arm/left/joint_states"]
    assert kind == "sensor_msgs::msg::dds_::JointState_"
    assert user_data == f"typehash={store.hash_rihs01('sensor_msgs/msg/JointState')};"
    assert {"rt/clock", "rt/tf", "rt/arm/left/robot_description"} <= set(seen["endpoints"])
    namespace, name, writers = seen["nodes"][-1]
    assert (namespace, name) == ("/arm/left", "shown")
    assert key in writers
    (stamp, joints, position, velocity, _), *_ = seen["messages"]
    row = np.flatnonzero(np.isclose(run["time"], stamp[0] + 1e-9 * stamp[1], atol=1e-9))
    assert joints == [c.name for c in watched.robot.coordinates]
    np.testing.assert_array_equal(position, run.rows[row[0], 1:3])
    np.testing.assert_array_equal(velocity, run.columns(names)[row[0]])
