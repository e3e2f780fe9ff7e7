"""Shared parts of the XML writers: exact numbers, elements, documents."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from xml.etree import ElementTree


def written(value: float) -> float:
    """Return the value, or 0 if it is below 2.2e-308, which readers in C++ reject."""
    return 0.0 if 0.0 < abs(value) < sys.float_info.min else float(value)


def numbers(values: Iterable[float]) -> str:
    """Return numbers as text, separated by one space; reading them restores the same bits."""
    return " ".join(repr(written(value)) for value in values)


def element(
    parent: ElementTree.Element | None, tag: str, text: str | float | None = None, **attributes: str
) -> ElementTree.Element:
    """Return a new element, appended to its parent."""
    new = ElementTree.Element(tag, attributes)
    if text is not None:
        new.text = text if isinstance(text, str) else numbers([text])
    if parent is not None:
        parent.append(new)
    return new


def document(root: ElementTree.Element, doctype: str = "") -> str:
    """Return the text of an XML file with this root element."""
    ElementTree.indent(root)
    head = '<?xml version="1.0" encoding="utf-8"?>\n'
    if doctype:
        head += f"<!DOCTYPE {doctype}>\n"
    return head + ElementTree.tostring(root, encoding="unicode") + "\n"
