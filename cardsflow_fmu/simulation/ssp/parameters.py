"""Parameter bindings of a system or a component: inline, or from an .ssv file."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from lxml import etree

from addin_sdfusion.robot import InputError, UnknownNameError
from cardsflow_fmu.cosim.signals.units import Unit

from .system import Parameter
from .xml import decimal, local, parse, read_units

_SET_TYPE = "application/x-ssp-parameter-set"


def read_parameters(element: Any, folder: Path, file: Path) -> list[Parameter]:
    """Return the start values of an element; the last value of a variable is used.

    Raises:
        InputError: A parameter is invalid or unsupported.
    """
    values: dict[str, Parameter] = {}
    for binding in element.iterfind("{*}ParameterBindings/{*}ParameterBinding"):
        values |= {p.name: p for p in _bound_parameters(binding, folder, file)}
    return list(values.values())


def _bound_parameters(binding: Any, folder: Path, file: Path) -> list[Parameter]:
    if binding.find("{*}ParameterMapping") is not None or binding.get("sourceBase", "SSD") != "SSD":
        problem = "parameter mappings and sources inside components are not supported"
        raise InputError(problem, file=file, line=binding.sourceline)
    if binding.get("type", _SET_TYPE) != _SET_TYPE:
        raise InputError("is not a parameter set", file=file, line=binding.sourceline)
    source = binding.get("source")
    if source is None:
        sets = [(s, file) for s in binding.iterfind("{*}ParameterValues/{*}ParameterSet")]
    else:
        path = (folder / source).resolve()
        if folder.resolve() not in path.parents:
            problem = f"{source!r} is outside of the archive"
            raise InputError(problem, file=file, line=binding.sourceline)
        sets = [(parse(path), path)]
    prefix = binding.get("prefix", "")
    return [p for one, place in sets for p in _parameters(one, prefix, place)]


def _parameters(parameter_set: Any, prefix: str, file: Path) -> list[Parameter]:
    units = read_units(parameter_set, file)
    return [
        _parameter(element, prefix, units, file)
        for element in parameter_set.iterfind("{*}Parameters/{*}Parameter")
    ]


def _parameter(element: Any, prefix: str, units: dict[str, Unit], file: Path) -> Parameter:
    name = f"{prefix}{element.get('name', '')}"
    values = list(element.iterchildren(tag=etree.Element))
    kind = local(values[0]) if values else "nothing"
    if kind == "Boolean":
        return Parameter(name, float(values[0].get("value") in ("true", "1")))
    if kind not in ("Real", "Integer"):
        problem = f"parameter {name} is {kind}; only numbers and booleans are supported"
        raise InputError(problem, file=file, line=element.sourceline)
    unit = values[0].get("unit")
    if unit is not None and unit not in units:
        raise UnknownNameError("unit", unit, units, file=file, line=element.sourceline)
    number = decimal(values[0], "value", file)
    return Parameter(name, number, None if unit is None else units[unit])
