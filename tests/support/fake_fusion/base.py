"""Base classes of the fake, which check names, argument types, threads and deleted objects.

An API class is a normal class with the decorator `@api("adsk.core")`. Its public functions and
properties belong to the API; names with an underscore are private to the fake. Annotations of
parameters are checked when a member is called.
"""

# ruff: noqa: N818 -- the API's names

from __future__ import annotations

import inspect
import sys
import threading
import types
import typing
from collections.abc import Callable
from functools import cache
from typing import Any

from .state import world

CLASSES: dict[str, dict[str, type]] = {"adsk.core": {}, "adsk.fusion": {}}
"""Classes of the fake by namespace and name."""

_MAIN = threading.main_thread().ident


class Base:
    """Base of all API classes, which cannot be instantiated directly."""

    def __new__(cls, *_: Any, **__: Any) -> Any:
        """Raise the error of Fusion, whose API has no constructors."""
        raise AttributeError(f"No constructor defined for {cls.__name__}")

    def __getattr__(self, name: str) -> Any:
        raise AttributeError(f"{type(self).__name__} has no member {name!r}")

    def __setattr__(self, name: str, value: Any) -> None:
        if not name.startswith("_"):
            member = _member(type(self), name)
            if not isinstance(member, property):
                raise AttributeError(f"{type(self).__name__} has no member {name!r} to write")
            if member.fset is None:
                raise AttributeError(f"{type(self).__name__}.{name} is read-only")
        object.__setattr__(self, name, value)

    __hash__ = None  # type: ignore[assignment]  # objects of Fusion are not hashable

    def __eq__(self, other: object) -> bool:
        return self is other

    def __bool__(self) -> bool:
        return True

    def _is_gone(self) -> bool:
        return False

    isValid = property(lambda self: not self._is_gone())
    objectType = property(lambda self: type(self).classType())

    @classmethod
    def classType(cls) -> str:
        return f"{_api_class(cls)._namespace.replace('.', '::')}::{_api_class(cls).__name__}"

    @classmethod
    def cast(cls, arg: Any) -> Any:
        """Return the object if it is an instance of this class, else None."""
        return arg if isinstance(arg, cls) else None


@cache
def _member(cls: type, name: str) -> Any:
    return inspect.getattr_static(cls, name, None)


def new(cls: type, **fields: Any) -> Any:
    """Create an API object.

    Args:
        cls: Class of the object.
        fields: Private fields, without the underscore.
    """
    made = object.__new__(cls)
    held = made.__dict__
    for name, value in fields.items():
        held["_" + name] = value
    return made


def by_name(name: str, **fields: Any) -> Any:
    """Create an API object of a class given by name."""
    core, fusion = CLASSES["adsk.core"], CLASSES["adsk.fusion"]
    return new(core.get(name) or fusion[name], **fields)


def stored(path: str, kind: str) -> property:
    """Return a property that is stored in a private field, such as "data.visible".

    Args:
        path: The field, without the underscore.
        kind: Type of the values; other types are rejected.
    """
    *holders, name = f"_{path}".split(".")

    def write(self: Any, value: Any) -> None:
        setattr(_held(self, holders), name, value)

    write.__annotations__["value"] = kind
    return property(lambda self: getattr(_held(self, holders), name), write)


def edited(path: str, kind: str, member: str) -> property:
    """Return a property of the model, whose edits require a transaction."""
    *holders, name = f"_{path}".split(".")

    def write(self: Any, value: Any) -> None:
        held = float(value) if kind == "float" else value
        world().set(_held(self, holders), name, held, f"{type(self).__name__}.{member}")

    write.__annotations__["value"] = kind
    return property(lambda self: getattr(_held(self, holders), name), write)


def _held(made: Any, holders: list[str]) -> Any:
    for holder in holders:
        made = getattr(made, holder)
    return made


def api(namespace: str) -> Callable[[type], type]:
    """Register an API class, whose public members check thread, validity and arguments."""

    def register(cls: type) -> type:
        cls._namespace = namespace
        for name, member in _public_members(cls).items():
            setattr(cls, name, _guarded(cls, name, member))
        CLASSES[namespace][cls.__name__] = cls
        return cls

    return register


def _public_members(cls: type) -> dict[str, Any]:
    """Return the public members of a class and of its bases that are not API classes."""
    found: dict[str, Any] = {}
    for base in cls.__mro__:
        if base is Base or (base is not cls and "_namespace" in vars(base)):
            break
        for name, member in vars(base).items():
            if not name.startswith("_"):
                found.setdefault(name, member)
    return found


def enumeration(namespace: str, name: str, values: dict[str, int]) -> type:
    """Create an enumeration of the API: a class with plain integers."""
    made = type(name, (), {**values, "_namespace": namespace, "_values": values})
    CLASSES[namespace][name] = made
    return made


def check_thread(what: str) -> None:
    """Reject calls outside the main thread, which would crash Fusion.

    Raises:
        RuntimeError: The current thread is not the main thread.
    """
    if threading.get_ident() != _MAIN:
        raise RuntimeError(f"2 : InternalValidationError : {what} called from a worker thread")


def _api_class(cls: type) -> type:
    """Return the API class of a class, which may be a subclass for event handlers."""
    return next(c for c in cls.__mro__ if "_namespace" in vars(c))


def _guarded(cls: type, name: str, member: Any) -> Any:
    where = f"{cls.__name__}.{name}"
    if isinstance(member, property):
        fget = _call(where, member.fget, bound=True)
        fset = None if member.fset is None else _call(where, member.fset, bound=True)
        return property(fget, fset, doc=member.__doc__)
    if isinstance(member, (staticmethod, classmethod)):
        bound = isinstance(member, classmethod)
        return type(member)(_call(where, member.__func__, bound=bound, alive=False))
    if inspect.isfunction(member):
        return _call(where, member, bound=True)
    return member


def _call(where: str, function: Callable, *, bound: bool, alive: bool = True) -> Callable:
    """Return a function with checks of thread, validity and types of positional arguments."""
    checks: list | None = None
    parameters = list(inspect.signature(function).parameters.values())[bound:]
    required = sum(p.default is p.empty for p in parameters)
    if any(p.kind is p.VAR_POSITIONAL for p in parameters):
        parameters = []
    looks_at_life = alive and not where.endswith(".isValid")
    any_thread = where == "Application.get"

    def guarded(*args: Any) -> Any:
        nonlocal checks
        if threading.get_ident() != _MAIN and not any_thread:
            check_thread(where)
        running = world()
        running.calls[where] += 1
        if looks_at_life and args[0]._is_gone():
            raise RuntimeError(f"2 : InternalValidationError : {where} of a deleted object")
        if where in running.missing:
            raise AttributeError(f"{where}: this version of Fusion has no such member")
        if parameters:
            values = args[1:] if bound else args
            if checks is None:
                checks = [_check(function, p) for p in parameters]
            if not required <= len(values) <= len(parameters):
                raise TypeError(f"{where} takes {len(parameters)} arguments, not {len(values)}")
            for value, check, parameter in zip(values, checks, parameters, strict=False):
                if not check(value):
                    raise TypeError(
                        f"in method {where}, argument {parameter.name!r} must be "
                        f"{parameter.annotation}, not {type(value).__name__} {value!r}"
                    )
        try:
            return function(*args)
        except AttributeError as error:  # otherwise __getattr__ would hide a mistake of the fake
            if str(error).startswith("No constructor") or " no such member" in str(error):
                raise
            raise FakeMistake(f"in {where}: {error}") from error

    guarded.__name__ = function.__name__
    guarded.__doc__ = function.__doc__
    return guarded


class FakeMistake(Exception):
    """A mistake of the fake or a test, not an error of Fusion."""


def _check(function: Callable, parameter: inspect.Parameter) -> Callable[[Any], bool]:
    """Return a test of values against an annotation, which is a text with names of API classes."""
    text = parameter.annotation
    if text is parameter.empty:
        return lambda _: True
    names = {**vars(sys.modules[function.__module__]), **_every_class()}
    hint = eval(text, names) if isinstance(text, str) else text
    return _fits(hint)


def _every_class() -> dict[str, type]:
    return {**CLASSES["adsk.core"], **CLASSES["adsk.fusion"]}


def _fits(hint: Any) -> Callable[[Any], bool]:
    if isinstance(hint, types.UnionType) or typing.get_origin(hint) is typing.Union:
        options = [_fits(option) for option in typing.get_args(hint)]
        return lambda value: any(option(value) for option in options)
    if hint is None or hint is type(None):
        return lambda value: value is None
    if hint is Any or hint is object:
        return lambda _: True
    if hint is float:
        return lambda value: isinstance(value, (int, float)) and not isinstance(value, bool)
    if hint is int:
        return lambda value: isinstance(value, int) and not isinstance(value, bool)
    if typing.get_origin(hint) is list:
        (item,) = typing.get_args(hint)
        fits = _fits(item)
        return lambda value: isinstance(value, (list, tuple)) and all(map(fits, value))
    return lambda value: isinstance(value, hint)
