"""A node of ROS 2 by its own library, rclpy, over the middleware that the user has chosen."""

from __future__ import annotations

import functools
import importlib
import re
import sys
import threading
import time
from array import array
from collections.abc import Hashable, Mapping
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from addin_sdfusion.robot import InputError

from .address import SCHEME, NodeAddress
from .node import End, Received, Topic, Values

Parameter = bool | int | float | str | list[bool] | list[int] | list[float] | list[str]

_DEPTH = 10
_GRAPH_EVERY = 0.05
"""Longest time for which the identity of a publisher is taken from before, in [s]."""
_JOIN_WITHIN = 2.0
_MAX_WAIT = 0.1
"""Longest time for which a wait for messages holds up an interrupt of the program, in [s]."""
_SEQUENCE = re.compile(r"sequence<(\w+)/(\w+)>")


def open_node(address: NodeAddress, parameters: Mapping[str, Parameter] | None = None) -> RosNode:
    """Open a node; it leaves the graph at its end, as a context."""
    return RosNode(address, parameters or {})


class RosNode:
    """A node, as a context that leaves the graph at its end; see `Node`.

    A thread of its own answers requests, so that nobody who publishes or steps waits for ROS.
    Messages are taken by the thread that receives them.

    Args:
        address: Name, namespace and domain of the node.
        parameters: Its parameters, which are read-only.

    Raises:
        InputError: This Python has no rclpy, or the middleware cannot be started.
    """

    def __init__(self, address: NodeAddress, parameters: Mapping[str, Parameter]) -> None:
        rclpy = _rclpy()
        from rclpy.executors import SingleThreadedExecutor
        from rclpy.signals import SignalHandlerOptions

        self._address = address
        self._publishers: dict[Topic, tuple[Any, type[Any]]] = {}
        self._context = rclpy.Context()
        try:
            rclpy.init(
                context=self._context,
                domain_id=address.domain,
                signal_handler_options=SignalHandlerOptions.NO,
            )
            self._node: Any = rclpy.create_node(
                address.node, namespace=address.namespace, context=self._context
            )
        except Exception as error:  # of kinds that differ by middleware
            rclpy.try_shutdown(context=self._context)
            raise InputError(f"ROS 2 does not start: {_line(error)}", key=SCHEME) from None
        self._declare(parameters)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self._node)
        self._thread = threading.Thread(target=self._spin, name="rclpy", daemon=True)
        self._thread.start()

    def knows(self, message_type: str) -> bool:
        """Return whether this installation of ROS has a message type."""
        try:
            _message_class(message_type)
        except InputError:
            return False
        return True

    def advertise(self, topic: Topic) -> None:
        """Announce a topic that will be published.

        Raises:
            InputError: The package of its type is not installed.
        """
        kind = _message_class(topic.type)
        name = self._address.absolute(topic.name)
        self._publishers[topic] = self._node.create_publisher(kind, name, _qos(topic)), kind

    def publish(self, topic: Topic, values: Values) -> None:
        """Send a message of an advertised topic."""
        publisher, kind = self._publishers[topic]
        message = kind()
        _fill(message, values)
        publisher.publish(message)

    def subscribe(self, topic: Topic) -> RosInbox:
        """Receive the messages of a topic from now on.

        Raises:
            InputError: The package of its type is not installed.
        """
        subscription = self._node.create_subscription(
            _message_class(topic.type),
            self._address.absolute(topic.name),
            lambda message: None,
            # best effort matches publishers of either kind
            _qos(topic, reliable=topic.latched),
            callback_group=_not_executed(),
        )
        return RosInbox(self._node, subscription)

    def types(self, topic: Topic, end: End) -> list[str]:
        """Return the types with which other nodes publish a topic or subscribe to it, one each."""
        name = self._address.absolute(topic.name)
        if end == "publisher":
            found = self._node.get_publishers_info_by_topic(name)
            own = [p for p in self._node.publishers if p.topic_name == name]
        else:
            found = self._node.get_subscriptions_info_by_topic(name)
            own = [s for s in self._node.subscriptions if s.topic_name == name]
        types = [info.topic_type for info in found]
        for _ in own:
            if topic.type in types:
                types.remove(topic.type)
        return types

    def close(self) -> None:
        """Leave the graph."""
        self._executor.shutdown(timeout_sec=0.0)
        self._thread.join(_JOIN_WITHIN)
        self._node.destroy_node()
        self._context.try_shutdown()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def _declare(self, parameters: Mapping[str, Parameter]) -> None:
        from rcl_interfaces.msg import ParameterDescriptor

        for name, value in parameters.items():
            self._node.declare_parameter(name, value, ParameterDescriptor(read_only=True))

    def _spin(self) -> None:
        from rclpy.executors import ExternalShutdownException, ShutdownException

        try:
            self._executor.spin()
        except (ExternalShutdownException, ShutdownException):
            return


class RosInbox:
    """The messages of a topic; see `Inbox`.

    An executor of rclpy makes a set of all that it waits for again for every message, which takes
    longer than the message's way. So `receive` has a set of its own, with the subscription alone.

    Args:
        node: Node of rclpy.
        subscription: Subscription of it that no executor takes messages of.
    """

    def __init__(self, node: Any, subscription: Any) -> None:
        from rclpy.impl.implementation_singleton import rclpy_implementation

        self._node, self._subscription = node, subscription
        self._waits = rclpy_implementation.WaitSet(1, 0, 0, 0, 0, 0, node.context.handle)
        self._publisher: Hashable = None
        self._looked = -_GRAPH_EVERY

    def receive(self, until: float) -> Received | None:
        """Return the next message; see `Inbox.receive`."""
        subscription, waits = self._subscription, self._waits
        handle = subscription.handle
        with handle:
            while (taken := handle.take_message(subscription.msg_type, subscription.raw)) is None:
                left = until - time.monotonic()
                if left <= 0.0:
                    return None
                waits.clear_entities()
                waits.add_subscription(handle)
                waits.wait(int(1e9 * min(left, _MAX_WAIT)))
        message, info = taken
        return Received(message, self._sole_publisher(), int(info["source_timestamp"] or 0))

    def _sole_publisher(self) -> Hashable:
        """Identity of the topic's publisher; None if there are several.

        rclpy does not tell the publisher of a message, so it is taken from the graph.
        """
        if self._subscription.handle.get_publisher_count() > 1:
            self._looked = -_GRAPH_EVERY
            return None
        now = time.monotonic()
        if now - self._looked >= _GRAPH_EVERY:
            found = self._node.get_publishers_info_by_topic(self._subscription.topic_name)
            self._publisher = tuple(found[0].endpoint_gid) if len(found) == 1 else None
            self._looked = now
        return self._publisher


def _rclpy() -> Any:
    """Return the module rclpy, imported only where a node is opened."""
    try:
        return importlib.import_module("rclpy")
    except ImportError as error:
        version = ".".join(map(str, sys.version_info[:2]))
        if isinstance(error, ModuleNotFoundError) and error.name == "rclpy":
            what = f"this Python {version} ({sys.executable}) does not have it"
        else:
            what = f"it does not load ({str(error).splitlines()[0]})"
        raise InputError(
            f"topics of ROS 2 need rclpy: {what}; source the setup.bash of a distribution and run "
            "cardsflow with that distribution's Python, or install the wheels ros-jazzy-rclpy and "
            "ros-jazzy-rmw-fastrtps-cpp for Python 3.11; see docs/how_to/ros.md",
            key=SCHEME,
        ) from None


@functools.cache
def _message_class(name: str) -> type[Any]:
    """Return the class of a message type: `std_msgs/msg/String` -> `std_msgs.msg.String`."""
    package, kind, own = name.split("/")
    try:
        return getattr(importlib.import_module(f"{package}.{kind}"), own)  # type: ignore[no-any-return]
    except (ImportError, AttributeError):
        what = f"this ROS 2 has no messages {name}: install the package {package}"
        raise InputError(what, key=SCHEME) from None


def _not_executed() -> Any:
    """Return a group for subscriptions that no executor takes messages of."""
    from rclpy.callback_groups import CallbackGroup

    class NotExecuted(CallbackGroup):  # type: ignore[misc]  # rclpy is not there for mypy
        def can_execute(self, entity: object) -> bool:
            return False

    return NotExecuted()


def _qos(topic: Topic, *, reliable: bool = True) -> Any:
    from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

    return QoSProfile(
        depth=1 if topic.latched else _DEPTH,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if topic.latched else DurabilityPolicy.VOLATILE,
        reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
    )


def _fill(message: Any, values: Values) -> None:
    """Set the fields of a message of rclpy."""
    kind: Any = type(message)
    for field, value in values.items():
        if isinstance(value, Mapping):
            _fill(getattr(message, field), value)
            continue
        element = _elements(kind).get(field)
        if element is not None:
            setattr(message, field, [_filled(element, one) for one in value])
        elif isinstance(value, np.ndarray):
            setattr(message, field, array("d", np.ascontiguousarray(value, np.float64).tobytes()))
        else:
            setattr(message, field, list(value) if isinstance(value, tuple) else value)


@functools.cache
def _elements(kind: type[Any]) -> dict[str, type[Any]]:
    """Return the messages that a message has sequences of, by their fields."""
    fields = kind.get_fields_and_field_types().items()
    found = {field: _SEQUENCE.match(of) for field, of in fields}
    return {f: _message_class(f"{of[1]}/msg/{of[2]}") for f, of in found.items() if of is not None}


def _filled(kind: type[Any], values: Values | NDArray[np.float64]) -> Any:
    """Return a new message; a point may be an array of its coordinates."""
    if isinstance(values, np.ndarray):
        x, y, z = values.tolist()
        return kind(x=x, y=y, z=z)
    message = kind()
    _fill(message, values)
    return message


def _line(error: BaseException) -> str:
    return " ".join(str(error).split()) or type(error).__name__
