"""Elements, numbers and units in SSP files."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from lxml import etree

from addin_sdfusion.robot import InputError
from addin_sdfusion.robot.finding import Subject
from addin_sdfusion.robot.formats.reading.xml import Notes
from addin_sdfusion.robot.formats.reading.xml import parse as parse_xml
from cardsflow_fmu.cosim.signals.units import BASES, KNOWN_UNITS, Unit


def parse(file: Path) -> Any:
    """Parse an XML file without entities and external references; return its root.

    Raises:
        InputError: The file is not well-formed XML, or not UTF-8.
    """
    notes = Notes()
    root = parse_xml(file, Subject("file", file.name), notes)
    for finding in notes.findings:
        raise InputError(finding.message, file=file)
    return root.element


def local(element: Any) -> str:
    """Return the name of an element without namespace."""
    return str(etree.QName(element).localname)


def decimal(element: Any, name: str, file: Path, *, default: float | None = None) -> float:
    """Return an attribute that is a finite number.

    Raises:
        InputError: The attribute is missing without default, or is not a finite number.
    """
    text = element.get(name)
    if text is None and default is not None:
        return default
    try:
        number = float(text or "")
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        problem = f"{name} must be a finite number, not {text!r}"
        raise InputError(problem, file=file, line=element.sourceline)
    return number


def read_units(root: Any, file: Path) -> dict[str, Unit]:
    """Return the units that a file defines, and all known units.

    Raises:
        InputError: A definition is invalid.
    """
    units = dict(KNOWN_UNITS)
    for base in root.iterfind("{*}Units/{*}Unit/{*}BaseUnit"):
        name = base.getparent().get("name") or ""
        factor = decimal(base, "factor", file, default=1.0)
        offset = decimal(base, "offset", file, default=0.0)
        units[name] = Unit(name, _exponents(base, file), factor, offset)
    return units


def _exponents(base: Any, file: Path) -> tuple[int, ...]:
    exponents = [decimal(base, letter, file, default=0.0) for letter in BASES]
    if not all(exponent.is_integer() for exponent in exponents):
        raise InputError("exponents of units must be integers", file=file, line=base.sourceline)
    return tuple(map(int, exponents))
