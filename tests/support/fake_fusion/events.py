"""Events, their arguments and the handlers that an add-in derives.

Fusion does not keep handlers alive: an event holds them weakly, so one that nobody keeps is silent.
"""

# ruff: noqa: N815 -- the API's names

from __future__ import annotations

import weakref
from typing import Any

from .base import Base, api, new
from .state import world


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
SelectionEventHandler = _handler("SelectionEventHandler")
KeyboardEventHandler = _handler("KeyboardEventHandler")
ApplicationCommandEventHandler = _handler("ApplicationCommandEventHandler")
DocumentEventHandler = _handler("DocumentEventHandler")
CustomEventHandler = _handler("CustomEventHandler")
HTMLEventHandler = _handler("HTMLEventHandler")
UserInterfaceGeneralEventHandler = _handler("UserInterfaceGeneralEventHandler")
ActiveSelectionEventHandler = _handler("ActiveSelectionEventHandler")


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

    @property
    def name(self) -> str:
        return self._name

    @property
    def sender(self) -> Any:
        return self._sender


def _event(name: str, handler: type) -> type:
    def add(self: Any, handler: Base) -> bool:
        if not isinstance(handler, self._handler):
            wanted = self._handler.__name__
            raise TypeError(f"in method {name}.add: {type(handler).__name__} is no {wanted}")
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
SelectionEvent = _event("SelectionEvent", SelectionEventHandler)
KeyboardEvent = _event("KeyboardEvent", KeyboardEventHandler)
ApplicationCommandEvent = _event("ApplicationCommandEvent", ApplicationCommandEventHandler)
DocumentEvent = _event("DocumentEvent", DocumentEventHandler)
CustomEvent = _event("CustomEvent", CustomEventHandler)
HTMLEvent = _event("HTMLEvent", HTMLEventHandler)
UserInterfaceGeneralEvent = _event("UserInterfaceGeneralEvent", UserInterfaceGeneralEventHandler)
ActiveSelectionEvent = _event("ActiveSelectionEvent", ActiveSelectionEventHandler)


def event(cls: type, name: str, sender: Any, listeners: Listeners) -> Any:
    """The API's object of an event."""
    return new(cls, name=name, sender=sender, listeners=listeners)


@api("adsk.core")
class EventArgs(Base):
    """`_event` is what fires."""

    @property
    def firingEvent(self) -> Any:
        return self._event


@api("adsk.core")
class CommandCreatedEventArgs(EventArgs):
    @property
    def command(self) -> Any:
        return self._command


@api("adsk.core")
class CommandEventArgs(EventArgs):
    _executeFailed = False
    _executeFailedMessage = ""
    _isValidResult = False
    _terminationReason = 0

    @property
    def command(self) -> Any:
        return self._command

    @property
    def executeFailed(self) -> bool:
        return self._executeFailed

    @executeFailed.setter
    def executeFailed(self, value: bool) -> None:
        self._executeFailed = value

    @property
    def executeFailedMessage(self) -> str:
        return self._executeFailedMessage

    @executeFailedMessage.setter
    def executeFailedMessage(self, value: str) -> None:
        self._executeFailedMessage = value

    @property
    def isValidResult(self) -> bool:
        return self._isValidResult

    @isValidResult.setter
    def isValidResult(self, value: bool) -> None:
        self._isValidResult = value

    @property
    def terminationReason(self) -> int:
        return self._terminationReason


@api("adsk.core")
class InputChangedEventArgs(EventArgs):
    @property
    def input(self) -> Any:
        return self._input

    @property
    def inputs(self) -> Any:
        """Those beside the changed one: of its tab or group, not of the whole command."""
        return self._input.commandInputs


@api("adsk.core")
class ValidateInputsEventArgs(EventArgs):
    _areInputsValid = True

    @property
    def inputs(self) -> Any:
        return self._command.commandInputs

    @property
    def areInputsValid(self) -> bool:
        return self._areInputsValid

    @areInputsValid.setter
    def areInputsValid(self, value: bool) -> None:
        self._areInputsValid = value


@api("adsk.core")
class Selection(Base):
    """An entity and where it was clicked."""

    @property
    def entity(self) -> Any:
        return self._entity

    @property
    def point(self) -> Any:
        return self._point


@api("adsk.core")
class SelectionEventArgs(EventArgs):
    _isSelectable = True

    @property
    def activeInput(self) -> Any:
        return self._input

    @property
    def selection(self) -> Any:
        return self._selection

    @property
    def isSelectable(self) -> bool:
        return self._isSelectable

    @isSelectable.setter
    def isSelectable(self, value: bool) -> None:
        self._isSelectable = value


@api("adsk.core")
class KeyboardEventArgs(EventArgs):
    @property
    def keyCode(self) -> int:
        return self._code

    @property
    def modifierMask(self) -> int:
        return self._modifiers


@api("adsk.core")
class ApplicationCommandEventArgs(EventArgs):
    @property
    def commandId(self) -> str:
        return self._id

    @property
    def terminationReason(self) -> int:
        return self._reason


@api("adsk.core")
class DocumentEventArgs(EventArgs):
    @property
    def document(self) -> Any:
        return self._document


@api("adsk.core")
class CustomEventArgs(EventArgs):
    @property
    def additionalInfo(self) -> str:
        return self._info


@api("adsk.core")
class HTMLEventArgs(EventArgs):
    _returnData = ""

    @property
    def action(self) -> str:
        return self._action

    @property
    def data(self) -> str:
        return self._text

    @property
    def returnData(self) -> str:
        return self._returnData

    @returnData.setter
    def returnData(self, value: str) -> None:
        self._returnData = value


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
