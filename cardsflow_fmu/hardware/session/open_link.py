"""The links that there are, by the scheme of their addresses."""

from __future__ import annotations

from collections.abc import Callable

from addin_sdfusion.robot import InputError
from cardsflow_fmu.experiment.settings.hardware import Faults
from cardsflow_fmu.hardware.device.device import Device
from cardsflow_fmu.hardware.emulator.emulated_link import EmulatedLink, EmulatedWorld
from cardsflow_fmu.hardware.emulator.loopback_link import LoopbackLink
from cardsflow_fmu.hardware.links.link import HardwareLink
from cardsflow_fmu.hardware.links.ros_link import RosLink
from cardsflow_fmu.hardware.links.serial import SerialLink
from cardsflow_fmu.hardware.links.udp import UdpLink
from cardsflow_fmu.hardware.protocol.device_topics import DeviceTopics
from cardsflow_fmu.ros_interface.address import SCHEME as ROS
from cardsflow_fmu.ros_interface.address import NodeAddress, node_address

ADDRESSES = (
    "udp://HOST:PORT, serial:///dev/ttyACM0?baud=2000000, ros2://...?timeout=S, loopback:, "
    "emulated:"
)


def open_link(
    uri: str,
    *,
    key: bytes | None = None,
    bind: str = "",
    make_device: Callable[[], Device] | None = None,
    faults: Faults | None = None,
    make_topics: Callable[[NodeAddress], DeviceTopics] | None = None,
) -> HardwareLink:
    """Make the link of an address; its `open` is the first to send anything.

    Args:
        uri: One of `ADDRESSES`.
        key: The pre-shared key that frames are signed with; unsigned when None.
        bind: Address of this machine to send from; found by the device's when empty.
        make_device: Makes the device of loopback: and emulated:
        faults: Faults of the line of emulated:; none when None.
        make_topics: Makes the messages of ros2:

    Raises:
        InputError: The address cannot be understood, or what it is to do is impossible there.
    """
    scheme = uri.partition(":")[0]
    if scheme == "udp":
        return UdpLink(uri, key=key, bind=bind)
    if scheme == "serial":
        return SerialLink(uri, key=key)
    if scheme == ROS:
        if make_topics is None:
            raise InputError(f"{uri!r} requires the names of a robot")
        if key is not None:
            what = "messages of ROS are not signed: leave out the key, or use our protocol"
            raise InputError(what, key="hardware.key_file")
        address = node_address(uri)
        return RosLink(uri, address, make_topics(address))
    if uri not in ("loopback:", "emulated:"):
        raise InputError(f"no hardware at {uri!r}: an address is one of {ADDRESSES}")
    if make_device is None:
        raise InputError(f"{scheme}: requires a device in this process")
    if scheme == "loopback":
        return LoopbackLink(make_device, key=key)
    return EmulatedLink(EmulatedWorld(make_device(), faults or Faults()), key=key)
