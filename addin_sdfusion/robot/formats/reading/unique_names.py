"""Renaming of elements whose name is already used in a file."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import replace

from ...finding import Subject
from .xml import Node

Named = Callable[[str], Subject]


def with_unique_names(nodes: Sequence[Node], subject: Named) -> list[Node]:
    """Return the elements, with `_2`, `_3`, ... appended to repeated names.

    References to the name still mean the first element.

    Args:
        nodes: Elements of one kind.
        subject: Function that returns the object with a given name, for warnings.
    """
    names = [node.attribute("name", "") for node in nodes]
    names_in_use, counts = set(names), Counter[str]()
    for node, name in zip(nodes, names, strict=True):
        counts[name] += 1
        if not name or counts[name] == 1:
            continue
        while (new := f"{name}_{counts[name]}") in names_in_use:
            counts[name] += 1
        names_in_use.add(new)
        node.element.set("name", new)
        about = subject(new)
        problem = f"the name {name!r} is used by an earlier element; this one is renamed to {new!r}"
        replace(node, subject=about).warning(f"duplicate-{about.kind.replace('_', '-')}", problem)
    return list(nodes)
