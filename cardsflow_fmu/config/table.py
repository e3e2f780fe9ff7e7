"""Reading a table of settings: typed, complete, and with errors that name file and key."""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from addin_sdfusion.robot import InputError, UnknownNameError
from cardsflow_fmu.utils.multiples import whole_steps

from .key_path import EVERY_OTHER, PathError
from .schema import ANYTHING, Form, form_at, item_of, keys_of

MOST_STEPS = 10_000_000
_REQUIRED = object()


class Table:
    """A table of settings, read key by key; `close` refuses what was not read.

    Args:
        data: The table.
        file: Where it comes from.
        path: Its own key, such as `controller`; empty for the whole file.
        form: What it may hold; nothing else can be read.
    """

    def __init__(
        self, data: Mapping[str, Any], file: Path, path: str = "", form: Form = ANYTHING
    ) -> None:
        self._data = data
        self._form = form
        self._read: list[str] = []
        self.file = file
        self.path = path

    @property
    def is_empty(self) -> bool:
        """Whether nothing is given, or the table is absent."""
        return not self._data

    def __contains__(self, key: str) -> bool:
        return key in self._data

    def __iter__(self) -> Iterator[str]:
        return iter(self._data)

    def key(self, key: str) -> str:
        """The full key, such as `controller.kp`."""
        return f"{self.path}.{key}" if self.path else key

    def error(self, key: str, what: str) -> InputError:
        """An error about a key of this table."""
        return InputError(what, file=self.file, key=self.key(key))

    def unknown(self, key: str, kind: str, name: str, known: Iterable[str]) -> UnknownNameError:
        """An error about a name that does not exist."""
        return UnknownNameError(kind, name, known, file=self.file, key=self.key(key))

    def close(self) -> None:
        """Refuse keys that nothing has read.

        Raises:
            UnknownNameError: There is one; the message names the nearest known.
        """
        for key in self._data:
            if key not in self._read:
                raise self.unknown(key, "key", key, dict.fromkeys(self._read))

    def _hint(self, key: str) -> str:
        """The key that may have been meant for a missing one."""
        near = difflib.get_close_matches(key, self._data, n=1, cutoff=0.5)
        return f"; is {near[0]!r} meant to be it?" if near else ""

    def value(self, key: str, default: Any = _REQUIRED) -> Any:
        """The raw value."""
        assert form_at(self._form, key) is not None, f"{self.key(key)} has no form"
        self._read.append(key)
        if key in self._data:
            return self._data[key]
        if default is _REQUIRED:
            raise self.error(key, f"missing{self._hint(key)}")
        return default

    def table(self, key: str) -> Table:
        """A table in this one; empty when absent."""
        data = self.value(key, {})
        if not isinstance(data, dict):
            raise self.error(key, f"must be a table, not {data!r}")
        return Table(data, self.file, self.key(key), form_at(self._form, key) or ANYTHING)

    def element(self, key: str, index: int, row: Mapping[str, Any]) -> Table:
        """A table of a list in this one."""
        form = item_of(form_at(self._form, key) or ANYTHING)
        return Table(row, self.file, self.key(f"{key}[{index}]"), form)

    def refuse_unknown(self) -> None:
        """Refuse keys that the form does not have, here and in all tables inside.

        Raises:
            UnknownNameError: There is one; the message names the nearest known.
        """
        for key, value in self._data.items():
            form = form_at(self._form, key)
            if form is None:
                raise self.unknown(key, "key", key, keys_of(self._form))
            if isinstance(value, dict):
                Table(value, self.file, self.key(key), form).refuse_unknown()
            elif isinstance(value, list):
                for index, row in enumerate(value):
                    if isinstance(row, dict):
                        self.element(key, index, row).refuse_unknown()

    def text(self, key: str, default: Any = _REQUIRED) -> str:
        """A text that is not empty where it is given."""
        text = self.value(key, default)
        given = key in self._data
        if not isinstance(text, str) or (given and not text):
            raise self.error(key, f"must be a text, not {text!r}")
        return text

    def choice(self, key: str, kind: str, known: Sequence[str], default: Any = _REQUIRED) -> str:
        """One of several texts."""
        text = self.text(key, default)
        if text not in known:
            raise self.unknown(key, kind, text, known)
        return text

    def number(self, key: str, default: Any = _REQUIRED) -> float:
        """A finite number."""
        return self._finite(key, self.value(key, default))

    def positive(self, key: str, default: Any = _REQUIRED) -> float:
        """A finite number above 0."""
        number = self.number(key, default)
        if number <= 0:
            raise self.error(key, f"must be above 0, not {number!r}")
        return number

    def numbers(self, key: str, count: int, default: Any = _REQUIRED) -> tuple[float, ...]:
        """A list of finite numbers."""
        values = self.value(key, default)
        if not isinstance(values, list | tuple) or len(values) != count:
            raise self.error(key, f"must be a list of {count} numbers, not {values!r}")
        return tuple(self._finite(key, value) for value in values)

    def flag(self, key: str, default: Any = _REQUIRED) -> bool:
        """True or false."""
        value = self.value(key, default)
        if not isinstance(value, bool):
            raise self.error(key, f"must be true or false, not {value!r}")
        return value

    def whole(self, key: str, default: Any = _REQUIRED) -> int:
        """A whole number."""
        number = self.number(key, default)
        if number != int(number):
            raise self.error(key, f"must be a whole number, not {number!r}")
        return int(number)

    def multiple(
        self, key: str, time: float, step: float, what: str, *, blame: str | None = None
    ) -> None:
        """Refuse a time that is no whole multiple of a step, and more steps than memory has rows.

        Args:
            key: Where the time comes from.
            time: In [s].
            step: In [s].
            what: What the step is, for the message.
            blame: The full key that the message names; that of the time when None.
        """
        try:
            steps = whole_steps(time, step, what)
        except InputError as error:
            raise InputError(error.what, file=self.file, key=blame or self.key(key)) from None
        if steps > MOST_STEPS:
            raise self.error(key, f"{steps:g} steps are more than a run can hold (10 million)")

    def by_name(
        self,
        key: str,
        kind: str,
        names: Sequence[str],
        default: Any = _REQUIRED,
        groups: Mapping[str, Sequence[str]] | None = None,
    ) -> tuple[float, ...]:
        """A number for every name: one number for all, a list in order, or a table by name.

        In a table, `*` stands for all names that it leaves out.

        Args:
            key: The key.
            kind: What the names name, for messages.
            names: The names, in order.
            default: A number or sequence for names that a table leaves out.
            groups: Names that stand for several of the names.
        """
        values = self.value(key, default)
        if not isinstance(values, dict):
            if not isinstance(values, list | tuple):
                values = [values] * len(names)
            if len(values) != len(names):
                raise self.error(key, f"must have {len(names)} numbers, one for each {kind}")
            return tuple(self._finite(key, value) for value in values)
        table = Table(values, self.file, self.key(key))
        together = {**(groups or {}), EVERY_OTHER: names}
        spread: dict[str, Any] = {}
        for name, value in values.items():
            members = [name] if name in names else together.get(name)
            if members is None:
                raise table.unknown(name, kind, name, [*(groups or {}), *names])
            if name == EVERY_OTHER:
                spread = dict.fromkeys(members, value) | spread
            else:
                spread |= {member: values.get(member, value) for member in members}
        table = Table(spread, self.file, self.key(key))
        defaults = dict(zip(names, self._defaults(default, len(names)), strict=True))
        return tuple(table.number(name, defaults[name]) for name in names)

    def tables(self, names: Sequence[str], kind: str) -> Iterator[tuple[int, Table]]:
        """The tables of this one, each under one of the names, with the name's index."""
        for name in self._data:
            if name not in names:
                raise self.unknown(name, kind, name, names)
            yield names.index(name), self.table(name)

    @staticmethod
    def _defaults(default: Any, count: int) -> Sequence[Any]:
        if isinstance(default, list | tuple):
            return default
        return [default] * count

    def _finite(self, key: str, value: Any) -> float:
        if isinstance(value, dict):
            raise PathError("is one number, no table", file=self.file, key=self.key(key))
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise self.error(key, f"must be a number, not {value!r}")
        try:
            number = float(value)
        except OverflowError:
            number = math.inf
        if not math.isfinite(number):
            raise self.error(key, f"must be a finite number, not {number!r}")
        return number
