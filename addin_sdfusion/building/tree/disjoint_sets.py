"""Disjoint sets of names (union-find)."""

from __future__ import annotations

from collections.abc import Iterable


class DisjointSets:
    """Disjoint sets of names; initially every name is in a separate set."""

    def __init__(self, names: Iterable[str]) -> None:
        self._above = {name: name for name in names}

    def find(self, name: str) -> str:
        """Return the representative of the set of a name."""
        root = name
        while self._above[root] != root:
            root = self._above[root]
        while self._above[name] != root:
            self._above[name], name = root, self._above[name]
        return root

    def join(self, one: str, two: str) -> bool:
        """Merge the sets of two names; return whether they were different sets."""
        one, two = self.find(one), self.find(two)
        self._above[max(one, two)] = min(one, two)
        return one != two

    def groups(self) -> list[list[str]]:
        """Return the sets."""
        by_root: dict[str, list[str]] = {}
        for name in self._above:
            by_root.setdefault(self.find(name), []).append(name)
        return list(by_root.values())
