"""Stored places: the occurrence that a point or face belongs to, found again after edits.

Users rename components, update external references and move parts. Therefore a place lists, for
each level from the root component to the occurrence, the persistent id of the component, the number
of the occurrence and its token. A place that fits no occurrence or several ones is an error: a
point is never assigned to another occurrence.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any, NamedTuple

from ..robot.finding_builders import listed
from ..snapshot import COPY, Level
from .notes import optional
from .occurrences import Occurrences, component_id

_INSTANCE = re.compile(r":(\d+)(?=\+|$)")

HIDDEN = "it is suppressed or deleted, or cannot be read"
"""Reason why a component has no occurrence."""

Chain = tuple[tuple[str, int], ...]
"""Id of the component and number of the occurrence for each level."""


class Match(NamedTuple):
    """Result of the search for a place.

    Attributes:
        path: Path of the occurrence, or the stored path if it was not found.
        lost: Reason why it was not found; empty if it was found.
        is_moved: Whether the occurrence has another place than stored, or may be another one with
            the same place.
    """

    path: str
    lost: str = ""
    is_moved: bool = False


class Places:
    """Places of the occurrences of a design."""

    def __init__(self, design: Any, occurrences: Occurrences) -> None:
        self._design = design
        self._occurrences = occurrences
        self._level: dict[str, tuple[str, int]] = {}
        self._chains: dict[str, Chain] = {}
        self._place: dict[str, tuple[Level, ...]] = {}
        self._scopes: dict[str, str] = {}
        self._tokens: dict[str, list[str]] = {"": []}
        for path, occurrence in occurrences.items():
            number = _INSTANCE.findall(path)[-1:] or ["0"]
            self._level[path] = component_id(occurrence.component), int(number[0])

    def of(self, path: str) -> tuple[Level, ...]:
        """Return the place of an occurrence in the open design, to be stored."""
        if path not in self._place:
            self._place[path] = tuple(
                Level(*self._level[p], _token(self._occurrences[p].native))
                for p in self._way(path, "")
            )
        return self._place[path]

    def component(self, path: str) -> str:
        """Return the persistent id of the component of an occurrence."""
        return self._level[path][0]

    def scope(self, path: str) -> str:
        """Return the path of the inserted design that contains an occurrence; empty if none.

        Records of an inserted design are relative to its root component.
        """
        if path not in self._scopes:
            occurrence = self._occurrences[path]
            is_scope = not path or self.is_inserted(path)
            self._scopes[path] = path if is_scope else self.scope(occurrence.parent)
        return self._scopes[path]

    def is_inserted(self, path: str) -> bool:
        """Return whether the component belongs to another document than its parent."""
        if not path:
            return False
        occurrence = self._occurrences[path]
        above = self._occurrences.get(occurrence.parent)
        document, parent_document = (
            optional(lambda: occurrence.component.parentDesign),
            optional(lambda: None if above is None else above.component.parentDesign),
        )
        return document is not None and document != parent_document

    def find(
        self, place: tuple[Level, ...], path: str, scope: str = "", owner: str | None = None
    ) -> Match:
        """Return the occurrence at a stored place.

        Args:
            place: The stored place; if empty, the stored path must be exact.
            path: Stored path, relative to the design that contains the record.
            scope: Path of this design in the open design.
            owner: Persistent id of the component that contains the point; None if the point is
                stored in a design.
        """
        at = "+".join(part for part in (scope, path) if part)
        if not place:
            is_owned = at in self._occurrences and owner in (None, self.component(at))
            return Match(at, "" if is_owned else _absent(at))
        if owner is not None and place[-1].component != owner:
            return Match(at, copied(at))
        stored = tuple((level.component, level.instance) for level in place)
        exact = [p for p in self._below(scope) if self._chain(p, scope) == stored]
        exact = [p for p in exact if p == at] or exact
        if len(exact) == 1:
            other = self._replaced(place, exact[0], scope)
            if other:
                return Match(at, _replaced_text(at, other))
            return Match(exact[0], is_moved=not scope and self._is_new(place, exact[0]))
        if exact:
            return Match(at, f"{listed(exact)} have the same identifiers")
        moved = self._find_token(place, scope) or self._find_moved(stored, scope)
        return Match(at, _absent(at)) if moved is None else Match(moved, is_moved=True)

    def _find_token(self, place: tuple[Level, ...], scope: str) -> str | None:
        """Return the occurrence that a token identifies, or a child of it."""
        for k in range(len(place), 0, -1):
            paths = self._with_token(place[k - 1].token)
            below = [(level.component, level.instance) for level in place[k:]]
            if len(paths) == 1 and self.component(paths[0]) == place[k - 1].component:
                fitting = [
                    p
                    for p in self._below(paths[0])
                    if list(self._chain(p, paths[0])) == below and self._is_below(p, scope)
                ]
                return fitting[0] if len(fitting) == 1 else None
        return None

    def _replaced(self, place: tuple[Level, ...], path: str, scope: str) -> str:
        """Return the occurrence that was stored, if another one now has its component and number.

        A new occurrence gets the number of one that was deleted or has another configuration.
        """
        for level, at in zip(place, self._way(path, scope), strict=True):
            paths = self._with_token(level.token)
            if len(paths) == 1 and paths[0] != at and self._has_own_token(at):
                return paths[0]
        return ""

    def _has_own_token(self, path: str) -> bool:
        """Return whether the token of an occurrence finds it, and no other one."""
        return self._with_token(_token(self._occurrences[path].native)) == [path]

    def _is_new(self, place: tuple[Level, ...], path: str) -> bool:
        """Return whether a stored token finds no occurrence, although tokens find occurrences."""
        return any(
            level.token and not self._with_token(level.token) and self._has_own_token(at)
            for level, at in zip(place, self._way(path, ""), strict=True)
        )

    def _with_token(self, token: str) -> list[str]:
        """Return the paths of the occurrences that a token identifies."""
        if token not in self._tokens:
            entities = optional(lambda: list(self._design.findEntityByToken(token))) or ()
            paths = {optional(lambda: str(e.fullPathName)) for e in entities}  # noqa: B023
            self._tokens[token] = [p for p in paths if p in self._occurrences]
        return self._tokens[token]

    def _find_moved(self, stored: Chain, scope: str) -> str | None:
        """Return the only occurrence of a component, if it has the same number elsewhere."""
        same = [p for p in self._below(scope) if p and self._level[p][0] == stored[-1][0]]
        if len(same) != 1 or self._level[same[0]] != stored[-1]:
            return None
        chain = self._chain(same[0], scope)
        is_other_instance = [c for c, _ in chain] == [c for c, _ in stored]
        return None if is_other_instance else same[0]

    def _below(self, scope: str) -> Iterator[str]:
        """Yield the path of a design and of all occurrences in it."""
        return (path for path in self._occurrences if self._is_below(path, scope))

    def _is_below(self, path: str, scope: str) -> bool:
        return not scope or path == scope or path.startswith(f"{scope}+")

    def _chain(self, path: str, scope: str) -> Chain:
        if scope:
            return tuple(self._level[p] for p in self._way(path, scope))
        if path not in self._chains:
            self._chains[path] = tuple(self._level[p] for p in self._way(path, scope))
        return self._chains[path]

    def _way(self, path: str, scope: str) -> list[str]:
        """Return the paths from below the scope to an occurrence."""
        way: list[str] = []
        while path and path != scope:
            way.insert(0, path)
            path = self._occurrences[path].parent
        return way


def _token(native: Any) -> str:
    return optional(lambda: str(native.entityToken)) or ""


def copied(path: str) -> str:
    """Return the reason why a copy of a point is not used."""
    where = f"{path!r}" if path else "the root component"
    return f"{COPY} of a point of {where}, for example by Paste New"


def _replaced_text(path: str, other: str) -> str:
    return f"{path!r} is another occurrence now; the stored one is {other!r}"


def _absent(path: str) -> str:
    return (
        f"{path!r} is not in the design or cannot be read: it was deleted or suppressed, or its "
        "external reference is unresolved"
    )
