"""Names that a file uses twice, for different parts: the later ones get others."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import replace

from ...finding import Subject
from .xml import Node

Named = Callable[[str], Subject]


def distinct(nodes: Sequence[Node], subject: Named) -> list[Node]:
    """Return the elements, those with a name that an earlier one has called `_2`, `_3` and so on.

    What refers to the name continues to mean the first one.

    Args:
        nodes: Elements of one kind.
        subject: The object that a name means, for the warnings.
    """
    names = [node.attribute("name", "") for node in nodes]
    taken, used = set(names), Counter[str]()
    for node, name in zip(nodes, names, strict=True):
        used[name] += 1
        if not name or used[name] == 1:
            continue
        while (new := f"{name}_{used[name]}") in taken:
            used[name] += 1
        taken.add(new)
        node.element.set("name", new)
        about = subject(new)
        problem = (
            f"an earlier one is also called {name!r} and keeps the name; this one becomes {new!r}"
        )
        replace(node, subject=about).warning(f"duplicate-{about.kind.replace('_', '-')}", problem)
    return list(nodes)
