"""Forms: what a table of settings may hold, as the reader takes it and as JSON Schema tells it.

A form is a fragment of JSON Schema. `Table` lets nothing be read that its form does not have, so
what an editor is told of a file is what its reader knows of it.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

Form = Mapping[str, Any]

ANYTHING: Form = {}


def _told(form: dict[str, Any], meaning: str, default: Any) -> Form:
    if meaning:
        form["description"] = meaning
    if default is not None:
        form["default"] = default
    return form


def number(meaning: str = "", default: Any = None, *, least: float | None = None) -> Form:
    """A finite number, at least `least`."""
    bounds = {} if least is None else {"minimum": least}
    return _told({"type": "number"} | bounds, meaning, default)


def positive(meaning: str = "", default: Any = None) -> Form:
    """A finite number above 0."""
    return _told({"type": "number", "exclusiveMinimum": 0}, meaning, default)


def whole(meaning: str, default: Any = None, *, least: int, most: int | None = None) -> Form:
    """A whole number, from `least` to `most`."""
    bounds = {"minimum": least} | ({} if most is None else {"maximum": most})
    return _told({"type": "integer"} | bounds, meaning, default)


def flag(meaning: str, default: Any = None) -> Form:
    """True or false."""
    return _told({"type": "boolean"}, meaning, default)


def text(meaning: str = "", default: Any = None) -> Form:
    """A text that is not empty."""
    return _told({"type": "string", "minLength": 1}, meaning, default)


def choice(meaning: str, names: Iterable[str], default: Any = None) -> Form:
    """One of several texts."""
    return _told({"enum": list(names)}, meaning, default)


def numbers(count: int, meaning: str = "", default: Any = None) -> Form:
    """A list of so many finite numbers."""
    form = {"type": "array", "items": number(), "minItems": count, "maxItems": count}
    return _told(form, meaning, default)


def rows(item: Form, meaning: str = "", default: Any = None, *, least: int = 0) -> Form:
    """A list of things of the same form."""
    return _told({"type": "array", "items": item, "minItems": least}, meaning, default)


def by_name(meaning: str, default: Any = None, *, of: Form | None = None) -> Form:
    """A number for each of several names: one for all, a list in order, or a table by name."""
    one = number() if of is None else of
    return either(one, rows(one), named(one), meaning=meaning, default=default)


def either(*forms: Form, meaning: str = "", default: Any = None) -> Form:
    """One of several forms."""
    return _told({"anyOf": list(forms)}, meaning, default)


def named(item: Form, meaning: str = "") -> Form:
    """A table whose keys are names: of muscles, coordinates, links."""
    return _told({"type": "object", "additionalProperties": item}, meaning, None)


def table(meaning: str, keys: Mapping[str, Form], required: Iterable[str] = ()) -> Form:
    """A table of these keys and no others."""
    form: dict[str, Any] = {
        "type": "object",
        "properties": dict(keys),
        "additionalProperties": False,
    }
    needed = list(required)
    if needed:
        form["required"] = needed
    return _told(form, meaning, None)


def form_at(form: Form, key: str) -> Form | None:
    """The form of what stands under a key of a table; None if the table has no such key.

    Args:
        form: Of the table, or of what may be a table.
        key: The key.
    """
    for own in form.get("anyOf", (form,)):
        if not own:
            return ANYTHING
        if own.get("type") == "object":
            found = own.get("properties", {}).get(key, own.get("additionalProperties", ANYTHING))
            return None if found is False else found
    return ANYTHING


def keys_of(form: Form) -> list[str]:
    """The keys that a table of a form may have; none where they are names."""
    return [key for own in form.get("anyOf", (form,)) for key in own.get("properties", {})]


def item_of(form: Form) -> Form:
    """The form of what stands in a list."""
    lists = [own for own in form.get("anyOf", (form,)) if own.get("type") == "array"]
    return lists[0].get("items", ANYTHING) if lists else ANYTHING
