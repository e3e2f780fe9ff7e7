"""Page documentation/index.html of an FMU, which describes its variables and its use."""

from __future__ import annotations

import math
from html import escape

from cardsflow_fmu.cosim.signals.port import Port
from cardsflow_fmu.cosim.signals.variables import Variable
from cardsflow_fmu.version import __version__

from .description import FmuDescription

_HEADS = ("variable", "size", "unit", "variability", "start", "range", "description")
_TITLES = {"input": "Inputs", "output": "Outputs", "parameter": "Parameters"}
_TITLES["local"] = "State derivatives and event indicators"
_STYLE = (
    "body{font:15px/1.5 sans-serif;max-width:60em;margin:2em auto;padding:0 1em}"
    "table{border-collapse:collapse}td,th{border:1px solid #bbb;padding:.2em .6em;text-align:left}"
    "td:first-child{font-family:monospace}"
)


def documentation_page(fmu: FmuDescription) -> bytes:
    """Return the contents of index.html."""
    title = escape(f"{fmu.model_name}: {fmu.description}")
    parts = [
        "<!DOCTYPE html>",
        f'<html lang="en"><head><meta charset="utf-8"><title>{title}</title>',
        f"<style>{_STYLE}</style></head><body>",
        f"<h1>{title}</h1>",
        *(f"<p>{escape(line)}</p>" for line in _notes(fmu)),
    ]
    for causality, heading in _TITLES.items():
        variables = [v for v in fmu.variables if v.port.causality == causality]
        if variables:
            parts += [f"<h2>{heading}</h2>", *_table(variables)]
    parts.append("</body></html>")
    return "\n".join(parts).encode() + b"\n"


_CONTINUOUS = (
    "All values are in SI units. Outputs and derivatives follow from states and inputs.",
    "States are positions, velocities, states of muscles, and work if energies are outputs.",
    "Joint limits are state events: a coordinate that reaches a limit stops by an inelastic "
    "impulse, and is held there while the limit pushes. Loops that integration has opened by more "
    "than 1e-8 m are closed by a step event.",
    "Directional derivatives are exact: of outputs, state derivatives and event indicators with "
    "respect to inputs and states; in initialization mode with respect to inputs and parameters.",
    "The state can be saved, restored and serialised.",
)


def _notes(fmu: FmuDescription) -> list[str]:
    if fmu.is_continuous:
        return [
            f"Created by CARDSFlow {__version__} for model exchange. The model is compiled. "
            "The FMU requires no other software.",
            *_CONTINUOUS,
        ]
    multiple = (
        "Communication steps may have any length."
        if fmu.any_step
        else f"Communication steps are {fmu.step!r} s"
        + (
            f", or whole multiples of {fmu.internal_step!r} s. A step of another length is "
            "discarded: the state does not change, and the next step may have a possible length."
            if fmu.internal_step is not None
            else "; other lengths may be rejected."
        )
    )
    derivatives = (
        "Directional derivatives are derivatives of the outputs after a step of the preferred "
        "length, with respect to inputs and tunable parameters at its beginning, and to positions "
        "and velocities of a plant. In initialization mode, they are derivatives of the outputs at "
        "the start with respect to inputs and parameters. They are exact, also with respect to "
        "states of muscles. At a limit of a command's range, such as a cable force of 0, the "
        "derivative is one-sided, towards the inside of the range."
        if fmu.has_derivatives
        else "There are no directional derivatives."
    )
    model = (
        "The model is implemented in Python. The FMU requires a Python interpreter with "
        f"the package cardsflow {__version__}: that of the importing tool, or that of a worker "
        "process."
        if fmu.needs_tool
        else "The model is compiled. The FMU requires no other software."
    )
    return [
        f"Created by CARDSFlow {__version__}. {model}",
        "All values are in SI units. Outputs change only in steps, not when inputs are set.",
        multiple,
        derivatives,
        "The state can be saved, restored and serialised. Restoring it gives bit-identical results."
        if fmu.has_state
        else "The state cannot be saved or restored, because it is the state of hardware.",
    ]


def _table(variables: list[Variable]) -> list[str]:
    heads = "".join(f"<th>{head}</th>" for head in _HEADS)
    return ["<table>", f"<tr>{heads}</tr>", *map(_row, variables), "</table>"]


def _row(variable: Variable) -> str:
    ports = variable.ports
    has_start = variable.port.causality in ("input", "parameter")
    units = list(dict.fromkeys(port.unit or "-" for port in ports))
    cells = (
        variable.name,
        str(len(ports)) if variable.is_array else "",
        ", ".join(units) if variable.is_array or units != ["-"] else "",
        variable.port.variability,
        ", ".join(f"{port.start:g}" for port in ports) if has_start else "",
        ", ".join(dict.fromkeys(map(_range, ports))) if any(map(_range, ports)) else "",
        variable.description,
    )
    return "<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in cells) + "</tr>"


def _range(port: Port) -> str:
    """Return the range of a variable; empty if it is unlimited."""
    if math.inf in (-port.lower, port.upper):
        if -port.lower == port.upper:
            return ""
        return f"≥ {port.lower:g}" if port.upper == math.inf else f"≤ {port.upper:g}"
    return f"{port.lower:g} to {port.upper:g}"
