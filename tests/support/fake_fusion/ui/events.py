"""Events, their arguments, and base classes of handlers.

An event holds only weak references to its handlers, like Fusion. A handler without another
reference is not called.
"""

from __future__ import annotations

import weakref
from typing import Any

from ..base import Base, api, new, stored
from ..model.entity import current
from ..state import world


@api("adsk.core")
class EventHandler(Base):
    """Base class of handlers, the only classes that can be subclassed and instantiated."""

    __hash__ = object.__hash__

    def __new__(cls, *_: Any, **__: Any) -> Any:
        return object.__new__(cls)

    def __setattr__(self, name: str, value: Any) -> None:
        object.__setattr__(self, name, value)


def _handler(name: str) -> type:
    def notify(self: Any, eventArgs: Base) -> None:
        """Handle the event; subclasses override this method."""

    made = type(name, (EventHandler,), {"notify": notify, "__module__": __name__})
    return api("adsk.core")(made)


CommandCreatedEventHandler = _handler("CommandCreatedEventHandler")
CommandEventHandler = _handler("CommandEventHandler")
InputChangedEventHandler = _handler("InputChangedEventHandler")
ValidateInputsEventHandler = _handler("ValidateInputsEventHandler")


class Listeners:
    """Handlers of one event; they exist longer than the API object of the event."""

    def __init__(self) -> None:
        self.handlers: list[weakref.ref] = []

    def alive(self) -> list[Any]:
        """Return the handlers that still exist."""
        return [h for h in (ref() for ref in self.handlers) if h is not None]


@api("adsk.core")
class Event(Base):
    """Event; `_listeners` exist longer than the wrapper."""

    name = property(lambda self: self._name)
    sender = property(lambda self: self._sender)


def _event(name: str, handler: type) -> type:
    def add(self: Any, handler: Base) -> bool:
        if not isinstance(handler, self._handler):
            expected = self._handler.__name__
            raise TypeError(f"in method {name}.add: {type(handler).__name__} is not a {expected}")
        self._listeners.handlers.append(weakref.ref(handler))
        return True

    def remove(self: Any, handler: Base) -> bool:
        found = [ref for ref in self._listeners.handlers if ref() is handler]
        for ref in found:
            self._listeners.handlers.remove(ref)
        return bool(found)

    body = {"add": add, "remove": remove, "_handler": handler, "__module__": __name__}
    return api("adsk.core")(type(name, (Event,), body))


CommandCreatedEvent = _event("CommandCreatedEvent", CommandCreatedEventHandler)
CommandEvent = _event("CommandEvent", CommandEventHandler)
InputChangedEvent = _event("InputChangedEvent", InputChangedEventHandler)
ValidateInputsEvent = _event("ValidateInputsEvent", ValidateInputsEventHandler)


def event(cls: type, name: str, sender: Any, listeners: Listeners) -> Any:
    """Return the API object of an event."""
    return new(cls, name=name, sender=sender, listeners=listeners)


@api("adsk.core")
class EventArgs(Base):
    """Arguments of an event; `_event` is the event."""


@api("adsk.core")
class CommandCreatedEventArgs(EventArgs):
    command = property(lambda self: self._command)


@api("adsk.core")
class CommandEventArgs(EventArgs):
    _executeFailed = False
    _executeFailedMessage = ""

    command = property(lambda self: self._command)
    executeFailed = stored("executeFailed", "bool")
    executeFailedMessage = stored("executeFailedMessage", "str")


@api("adsk.core")
class InputChangedEventArgs(EventArgs):
    input = property(lambda self: self._input)


@api("adsk.core")
class ValidateInputsEventArgs(EventArgs):
    _areInputsValid = True

    areInputsValid = stored("areInputsValid", "bool")


@api("adsk.core")
class Selection(Base):
    """A selected entity and the clicked position."""

    entity = property(lambda self: current(self._entity))
    point = property(lambda self: self._point)


def fire(firing: Any, args_class: type, **fields: Any) -> Any:
    """Call every handler of an event and return the arguments, which handlers may have changed.

    Exceptions of handlers reach the test; Fusion would show a traceback to the user.
    """
    args = new(args_class, event=firing, **fields)
    outer, world().why = world().why, firing._name
    try:
        for handler in firing._listeners.alive():
            handler.notify(args)
    finally:
        world().why = outer
    return args
