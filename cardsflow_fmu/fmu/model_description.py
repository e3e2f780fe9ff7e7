"""Writer of modelDescription.xml of FMI 2.0 or FMI 3.0, with checks."""

from __future__ import annotations

import re

from addin_sdfusion.robot import InputError, UnknownNameError
from cardsflow_fmu.cosim.signals.ports import Port
from cardsflow_fmu.cosim.signals.units import SI_UNITS

from . import fmi2, fmi3
from .description import FmiVersion, FmuDescription, xml_bytes

_PART = r"([A-Za-z_][A-Za-z0-9_]*|'([^'\\\x00-\x1f\x7f-\U0010ffff]|\\['\"?\\abfnrtv])+')"
_INDICES = r"(\[[0-9]+(,[0-9]+)*\])?"
_NAME = rf"{_PART}{_INDICES}(\.{_PART}{_INDICES})*"
_STRUCTURED_NAME = re.compile(rf"{_NAME}|der\({_NAME}\)")
_IDENTIFIER = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
_NOT_IN_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
_CONTINUOUS_OR_DISCRETE = ("continuous", "discrete")


def model_description(fmu: FmuDescription, guid: str, fmi: FmiVersion = "2.0") -> bytes:
    """Return the contents of modelDescription.xml.

    Raises:
        InputError: FMI does not allow a name, a unit or a combination of attributes.
    """
    _check(fmu)
    return xml_bytes((fmi2 if fmi == "2.0" else fmi3).describe(fmu, guid))


def _check(fmu: FmuDescription) -> None:
    if not _IDENTIFIER.fullmatch(fmu.model_name):
        raise InputError(
            f"an FMU's model name must consist of letters, digits and _, not {fmu.model_name!r}"
        )
    if not fmu.variables:
        raise InputError(f"the FMU {fmu.model_name} must have at least one variable")
    if not 0 < fmu.step < float("inf"):
        raise InputError(f"an FMU's step must be a positive time in s, not {fmu.step!r}")
    for names in ([p.name for p in fmu.ports], [v.name for v in fmu.variables]):
        if len(set(names)) < len(names):
            twice = sorted({name for name in names if names.count(name) > 1})
            raise InputError(f"several variables have the same name: {', '.join(twice)}")
    for text in (fmu.description, *fmu.about.values()):
        _check_text(text)
    for port in fmu.ports:
        _check_port(port)


def _check_port(port: Port) -> None:
    if not _STRUCTURED_NAME.fullmatch(port.name):
        raise InputError(f"{port.name!r} is not a structured FMI variable name")
    _check_text(port.description)
    if port.unit and port.unit not in SI_UNITS:
        raise UnknownNameError(f"unit of {port.name}:", port.unit, SI_UNITS)
    is_signal = port.variability in _CONTINUOUS_OR_DISCRETE
    if is_signal == (port.causality == "parameter"):
        raise InputError(f"{port.name}: a {port.causality} cannot be {port.variability}")
    if port.boolean and port.variability == "continuous":
        raise InputError(f"{port.name}: a boolean variable cannot be continuous")
    if port.boolean and port.start not in (0, 1):
        raise InputError(
            f"{port.name}: the start value of a boolean variable must be 0 or 1, not {port.start!r}"
        )
    if port.start - port.start != 0:
        raise InputError(f"{port.name}: the start value {port.start!r} is not finite")
    if port.causality in ("input", "parameter") and not port.lower <= port.start <= port.upper:
        limits = f"{port.lower!r} to {port.upper!r}"
        raise InputError(f"{port.name}: the start value {port.start!r} is outside {limits}")


def _check_text(text: str) -> None:
    if _NOT_IN_XML.search(text):
        raise InputError(f"{text!r} contains characters that XML does not allow")
