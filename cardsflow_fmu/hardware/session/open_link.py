"""Selection of the link type by the scheme of an address."""

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
    """Create the link for an address. No data is sent before the link's `open` is called.

    Args:
        uri: An address of one of the forms in `ADDRESSES`.
        key: Pre-shared key for signing frames, or None for unsigned frames.
        bind: Address of this machine to send from. If empty, the system chooses it.
        make_device: Function that creates the device of loopback: and emulated: links.
        faults: Faults of the line of emulated: links, or None.
        make_topics: Function that creates the topics of ros2: links.

    Raises:
        InputError: The address is invalid, or the link does not support an argument.
    """
    scheme = uri.partition(":")[0]
    if scheme == "udp":
        return UdpLink(uri, key=key, bind=bind)
    if scheme == "serial":
        return SerialLink(uri, key=key)
    if scheme == ROS:
        if make_topics is None:
            raise InputError(f"{uri!r} requires the names of the robot's joints and muscles")
        if key is not None:
            problem = "ROS messages are not signed: remove the key, or use a udp:// address"
            raise InputError(problem, key="hardware.key_file")
        address = node_address(uri)
        return RosLink(uri, address, make_topics(address))
    if uri not in ("loopback:", "emulated:"):
        raise InputError(f"invalid hardware address {uri!r}; supported: {ADDRESSES}")
    if make_device is None:
        raise InputError(f"{scheme}: requires a device in this process")
    if scheme == "loopback":
        return LoopbackLink(make_device, key=key)
    return EmulatedLink(EmulatedWorld(make_device(), faults or Faults()), key=key)
