"""ROS 2 node that uses rclpy, with the middleware that the user has configured."""

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
_GRAPH_PERIOD = 0.05
"""Maximum age of the stored identity of a publisher, in [s]."""
_JOIN_TIMEOUT = 2.0
_MAX_WAIT = 0.1
"""Maximum time for which a wait for messages delays an interrupt of the program, in [s]."""
_SEQUENCE = re.compile(r"sequence<(\w+)/(\w+)>")


def open_node(address: NodeAddress, parameters: Mapping[str, Parameter] | None = None) -> RosNode:
    """Open a node, which is also a context manager that closes the node."""
    return RosNode(address, parameters or {})


class RosNode:
    """ROS node, as a context manager that closes the node; see `Node`.

    A separate thread answers service requests, so that publishing and simulation steps do not wait
    for ROS. The thread that calls `receive` reads messages from the middleware.

    Raises:
        InputError: This Python has no rclpy, or the middleware cannot be started.
    """

    def __init__(self, address: NodeAddress, parameters: Mapping[str, Parameter]) -> None:
        rclpy = _import_rclpy()
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
        except Exception as error:  # the exception type depends on the middleware
            rclpy.try_shutdown(context=self._context)
            problem = f"ROS 2 cannot be started: {_error_line(error)}"
            raise InputError(problem, key=SCHEME) from None
        self._declare(parameters)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self._node)
        self._thread = threading.Thread(target=self._spin, name="rclpy", daemon=True)
        self._thread.start()

    def has_type(self, message_type: str) -> bool:
        """Return whether a message type is installed."""
        try:
            _message_class(message_type)
        except InputError:
            return False
        return True

    def advertise(self, topic: Topic) -> None:
        """Create a publisher for a topic."""
        kind = _message_class(topic.type)
        name = self._address.absolute(topic.name)
        self._publishers[topic] = self._node.create_publisher(kind, name, _qos(topic)), kind

    def publish(self, topic: Topic, values: Values) -> None:
        """Publish a message on an advertised topic."""
        publisher, kind = self._publishers[topic]
        message = kind()
        _fill(message, values)
        publisher.publish(message)

    def subscribe(self, topic: Topic) -> RosInbox:
        """Subscribe to a topic and return its queue of messages."""
        subscription = self._node.create_subscription(
            _message_class(topic.type),
            self._address.absolute(topic.name),
            lambda message: None,
            # A best-effort subscription is compatible with reliable and best-effort publishers.
            _qos(topic, reliable=topic.latched),
            callback_group=_excluded_group(),
        )
        return RosInbox(self._node, subscription)

    def types(self, topic: Topic, end: End) -> list[str]:
        """Return the message types of the publishers or subscribers of a topic in other nodes."""
        name = self._address.absolute(topic.name)
        if end == "publisher":
            infos = self._node.get_publishers_info_by_topic(name)
            endpoints = [p for p in self._node.publishers if p.topic_name == name]
        else:
            infos = self._node.get_subscriptions_info_by_topic(name)
            endpoints = [s for s in self._node.subscriptions if s.topic_name == name]
        types = [info.topic_type for info in infos]
        for _ in endpoints:
            if topic.type in types:
                types.remove(topic.type)
        return types

    def close(self) -> None:
        """Close the node."""
        self._executor.shutdown(timeout_sec=0.0)
        self._thread.join(_JOIN_TIMEOUT)
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
    """Queue of received messages; see `Inbox`.

    An executor of rclpy creates a wait set of all its entities for each message, which takes longer
    than the transport of the message. Therefore `receive` uses a wait set with only the
    subscription.

    Args:
        subscription: Subscription of the node that no executor processes.
    """

    def __init__(self, node: Any, subscription: Any) -> None:
        from rclpy.impl.implementation_singleton import rclpy_implementation

        self._node, self._subscription = node, subscription
        self._wait_set = rclpy_implementation.WaitSet(1, 0, 0, 0, 0, 0, node.context.handle)
        self._publisher: Hashable = None
        self._graph_time = -_GRAPH_PERIOD

    def receive(self, until: float) -> Received | None:
        """Return the next message; see `Inbox.receive`."""
        subscription, wait_set = self._subscription, self._wait_set
        handle = subscription.handle
        with handle:
            while (sample := handle.take_message(subscription.msg_type, subscription.raw)) is None:
                left = until - time.monotonic()
                if left <= 0.0:
                    return None
                wait_set.clear_entities()
                wait_set.add_subscription(handle)
                wait_set.wait(int(1e9 * min(left, _MAX_WAIT)))
        message, info = sample
        return Received(message, self._sole_publisher(), int(info["source_timestamp"] or 0))

    def _sole_publisher(self) -> Hashable:
        """Return the identity of the topic's publisher, or None if there are several.

        rclpy does not report the publisher of a message, so that the ROS graph is queried.
        """
        if self._subscription.handle.get_publisher_count() > 1:
            self._graph_time = -_GRAPH_PERIOD
            return None
        now = time.monotonic()
        if now - self._graph_time >= _GRAPH_PERIOD:
            infos = self._node.get_publishers_info_by_topic(self._subscription.topic_name)
            self._publisher = tuple(infos[0].endpoint_gid) if len(infos) == 1 else None
            self._graph_time = now
        return self._publisher


def _import_rclpy() -> Any:
    """Return the module rclpy. It is imported late, since it is optional."""
    try:
        return importlib.import_module("rclpy")
    except ImportError as error:
        version = ".".join(map(str, sys.version_info[:2]))
        if isinstance(error, ModuleNotFoundError) and error.name == "rclpy":
            problem = f"it is not installed for this Python {version} ({sys.executable})"
        else:
            problem = f"it cannot be loaded ({str(error).splitlines()[0]})"
        raise InputError(
            f"ROS 2 topics require rclpy: {problem}; source the setup.bash of a ROS distribution "
            "and run cardsflow with the Python of that distribution, or install the wheels "
            "ros-jazzy-rclpy and ros-jazzy-rmw-fastrtps-cpp for Python 3.11; "
            "see docs/how_to/ros.md",
            key=SCHEME,
        ) from None


@functools.cache
def _message_class(name: str) -> type[Any]:
    """Return the class of a message type: `std_msgs/msg/String` -> `std_msgs.msg.String`."""
    package, kind, type_name = name.split("/")
    try:
        module = importlib.import_module(f"{package}.{kind}")
        return getattr(module, type_name)  # type: ignore[no-any-return]
    except (ImportError, AttributeError):
        problem = f"the message type {name} is not installed in this ROS 2: install {package}"
        raise InputError(problem, key=SCHEME) from None


def _excluded_group() -> Any:
    """Return a callback group whose subscriptions executors do not process."""
    from rclpy.callback_groups import CallbackGroup

    class ExcludedGroup(CallbackGroup):  # type: ignore[misc]  # mypy runs without rclpy
        def can_execute(self, entity: object) -> bool:
            return False

    return ExcludedGroup()


def _qos(topic: Topic, *, reliable: bool = True) -> Any:
    from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

    return QoSProfile(
        depth=1 if topic.latched else _DEPTH,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if topic.latched else DurabilityPolicy.VOLATILE,
        reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
    )


def _fill(message: Any, values: Values) -> None:
    """Set the fields of an rclpy message."""
    kind: Any = type(message)
    for field, value in values.items():
        if isinstance(value, Mapping):
            _fill(getattr(message, field), value)
            continue
        element = _elements(kind).get(field)
        if element is not None:
            setattr(message, field, [_new_message(element, item) for item in value])
        elif isinstance(value, np.ndarray):
            setattr(message, field, array("d", np.ascontiguousarray(value, np.float64).tobytes()))
        else:
            setattr(message, field, list(value) if isinstance(value, tuple) else value)


@functools.cache
def _elements(kind: type[Any]) -> dict[str, type[Any]]:
    """Return the message types of the elements of sequences in a message, by field."""
    fields = kind.get_fields_and_field_types().items()
    types = {field: _SEQUENCE.match(of) for field, of in fields}
    return {f: _message_class(f"{of[1]}/msg/{of[2]}") for f, of in types.items() if of is not None}


def _new_message(kind: type[Any], values: Values | NDArray[np.float64]) -> Any:
    """Return a new message. For a point, the values may be an array of its coordinates."""
    if isinstance(values, np.ndarray):
        x, y, z = values.tolist()
        return kind(x=x, y=y, z=z)
    message = kind()
    _fill(message, values)
    return message


def _error_line(error: BaseException) -> str:
    return " ".join(str(error).split()) or type(error).__name__
