"""Events, their arguments and the handlers that an add-in derives.

Fusion does not keep handlers alive: an event holds them weakly, so one that nobody keeps is silent.
"""

from __future__ import annotations

import weakref
from typing import Any

from ..base import Base, api, new, stored
from ..state import world


@api("adsk.core")
class EventHandler(Base):
    """Base of the handlers; these alone may be derived from and made by calling."""

    __hash__ = object.__hash__

    def __new__(cls, *_: Any, **__: Any) -> Any:
        return object.__new__(cls)

    def __setattr__(self, name: str, value: Any) -> None:
        object.__setattr__(self, name, value)


def _handler(name: str) -> type:
    def notify(self: Any, eventArgs: Base) -> None:
        """To be overridden."""

    made = type(name, (EventHandler,), {"notify": notify, "__module__": __name__})
    return api("adsk.core")(made)


CommandCreatedEventHandler = _handler("CommandCreatedEventHandler")
CommandEventHandler = _handler("CommandEventHandler")
InputChangedEventHandler = _handler("InputChangedEventHandler")
ValidateInputsEventHandler = _handler("ValidateInputsEventHandler")


class Listeners:
    """What listens to one event; the API's event objects come and go."""

    def __init__(self) -> None:
        self.handlers: list[weakref.ref] = []

    def alive(self) -> list[Any]:
        """The handlers that somebody keeps."""
        return [h for h in (ref() for ref in self.handlers) if h is not None]


@api("adsk.core")
class Event(Base):
    """`_listeners` outlive the wrapper."""

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
    """The API's object of an event."""
    return new(cls, name=name, sender=sender, listeners=listeners)


@api("adsk.core")
class EventArgs(Base):
    """`_event` is what fires."""


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
    """An entity and where it was clicked."""

    entity = property(lambda self: self._entity)
    point = property(lambda self: self._point)


def fire(firing: Any, args_class: type, **fields: Any) -> Any:
    """Call every handler of an event; gives the arguments back as the handlers left them.

    What a handler raises goes through to the test: in Fusion the user would see a trace.
    """
    args = new(args_class, event=firing, **fields)
    outer, world().why = world().why, firing._name
    try:
        for handler in firing._listeners.alive():
            handler.notify(args)
    finally:
        world().why = outer
    return args
