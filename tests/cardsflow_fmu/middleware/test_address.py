"""Addresses of nodes of ROS 2."""

from __future__ import annotations

import re

import pytest

from addin_sdfusion.robot import CardsflowError
from cardsflow_fmu.middleware.address import NodeAddress, node_address


@pytest.fixture(autouse=True)
def no_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("ROS_DOMAIN_ID", "RMW_IMPLEMENTATION"):
        monkeypatch.delenv(name, raising=False)


def test_defaults_and_all_parts(monkeypatch: pytest.MonkeyPatch) -> None:
    assert node_address("ros2://") == NodeAddress()
    assert node_address("ros2://").router == "tcp/localhost:7447"
    assert node_address("ros2://[::1]:7/a/b?domain=3&node=n&depth=2&timeout=0.1") == NodeAddress(
        "zenoh", "::1", 7, 3, "/a/b", "n", True, 2, 0.1
    )
    assert node_address("ros2://[::1]:7").router == "tcp/[::1]:7"
    over_dds = node_address("ros2://?rmw=dds&reliability=best_effort")
    assert (over_dds.middleware, over_dds.host, over_dds.reliable) == ("dds", "", False)
    assert over_dds.absolute("/clock") == "/clock"
    monkeypatch.setenv("ROS_DOMAIN_ID", "9")
    monkeypatch.setenv("RMW_IMPLEMENTATION", "rmw_fastrtps_cpp")
    there = node_address("ros2://robot/arm")
    assert (there.middleware, there.domain, there.absolute("/x")) == ("dds", 9, "/arm/x")


@pytest.mark.parametrize(
    ("uri", "what"),
    [
        ("ros1://a", "no address of ROS 2"),
        ("ros2://a:x", "no address"),
        ("ros2://a?domain=233", "domain must be 0 to 232"),
        ("ros2://a?depth=0", "depth must be 1 to 1000"),
        ("ros2://a?quality=1", "no option 'quality'"),
        ("ros2://a?rmw=ice", "no middleware 'ice'"),
        ("ros2://a?reliability=some", "no reliability 'some'"),
        ("ros2://a?timeout=nan", "number of seconds above 0"),
        ("ros2://a:7?rmw=dds", "leave out the port"),
        ("ros2://a/b-c", "no name of ROS"),
    ],
)
def test_what_is_no_address(uri: str, what: str) -> None:
    with pytest.raises(CardsflowError, match=re.escape(what)):
        node_address(uri)
