"""Addresses of ROS 2 nodes."""

from __future__ import annotations

import re

import pytest

from addin_sdfusion.robot import CardsflowError
from cardsflow_fmu.ros_interface.address import NodeAddress, node_address


def test_addresses_have_defaults_and_options() -> None:
    assert node_address("ros2://") == NodeAddress()
    given = node_address("ros2://Arm/left?domain=3&node=n&timeout=0.1&controller=tendons")
    assert given == NodeAddress("/Arm/left", "n", 3, 0.1, "tendons")
    assert str(given) == "/Arm/left/n in domain 3"
    assert str(NodeAddress()) == "/cardsflow"
    assert given.absolute("/x") == "/Arm/left/x"
    assert given.absolute("/clock") == "/clock"


@pytest.mark.parametrize(
    ("uri", "what"),
    [
        ("ros1://a", "invalid ROS 2 address"),
        ("ros2://[a", "invalid address"),
        ("ros2://a?domain=233", "domain must be from 0 to 232"),
        ("ros2://a?quality=1", "no option 'quality'"),
        ("ros2://a?timeout=nan", "must be a positive time in s"),
        ("ros2://a/b-c", "invalid ROS name 'b-c'"),
        ("ros2://127.0.0.1", "invalid ROS name"),
        ("ros2://?controller=", "invalid ROS name"),
        ("ros2://localhost:7447", "remove 'localhost:7447'; the form is ros2://NAMESPACE"),
        ("ros2://localhost/left", "remove 'localhost'"),
        ("ros2://?rmw=dds", "remove rmw: set the environment variable"),
        ("ros2://?reliability=best_effort", "remove reliability"),
        ("ros2://?depth=1", "remove depth"),
    ],
)
def test_invalid_addresses_are_rejected(uri: str, what: str) -> None:
    with pytest.raises(CardsflowError, match=re.escape(what)):
        node_address(uri)
