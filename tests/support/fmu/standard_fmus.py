"""Model descriptions of external FMUs with the variables of three FMUs of the FMI project."""

from __future__ import annotations

from .external_fmus import scalar

INTEGERS = [f"{sign}Int{bits}" for bits in (8, 16, 32, 64) for sign in ("", "U")]
FEEDTHROUGH = {"2.0": ["Float64", "Int32", "Boolean", "Enumeration"]}
FEEDTHROUGH["3.0"] = ["Float64", "Float32", *INTEGERS, "Boolean", "Enumeration"]
"""Types of the inputs and outputs, by FMI version."""

_ENUMERATION = '<Item name="Option 1" value="1"/><Item name="Option 2" value="2"/>'
_FMI2 = {"Float64": "Real", "Int32": "Integer", "Boolean": "Boolean", "Enumeration": "Enumeration"}
_STATES = (
    (1, "x0", "output"),
    (2, "der(x0)", "local"),
    (3, "x1", "output"),
    (4, "der(x1)", "local"),
)


def _description(
    fmi: str, model: str, token: str, variables: str, structure: str, types: str
) -> str:
    identity = "guid" if fmi == "2.0" else "instantiationToken"
    return (
        f'<fmiModelDescription fmiVersion="{fmi}" modelName="{model}" {identity}="{{{token}}}">'
        f'<CoSimulation modelIdentifier="{model}_fmi{fmi[0]}"/>{types}'
        f"<ModelVariables>{variables}</ModelVariables>"
        f"<ModelStructure>{structure}</ModelStructure></fmiModelDescription>"
    )


def _variable3(kind: str, name: str, reference: int, causality: str, more: str = "") -> str:
    start = "false" if kind == "Boolean" else "1" if kind == "Enumeration" else "0"
    given = f' start="{start}"' if causality in ("input", "parameter") else ""
    declared = ' declaredType="Option"' if kind == "Enumeration" else ""
    return (
        f'<{kind} name="{name}" valueReference="{reference}" causality="{causality}"'
        f"{given}{declared}{more}/>"
    )


def van_der_pol(fmi: str) -> str:
    """Return the description of an oscillator with the parameter mu, and its time in FMI 3.0."""
    if fmi == "2.0":
        variables = "".join(scalar(name, r, causality) for r, name, causality in _STATES)
        variables += scalar("mu", 5, "parameter", start="1")
        structure = '<Outputs><Unknown index="1"/><Unknown index="3"/></Outputs>'
    else:
        variables = _variable3("Float64", "time", 0, "independent")
        variables += "".join(_variable3("Float64", name, r, c) for r, name, c in _STATES)
        variables += _variable3("Float64", "mu", 5, "parameter")
        structure = '<Output valueReference="1"/><Output valueReference="3"/>'
    return _description(fmi, "van_der_pol", "van der Pol", variables, structure, "")


def feedthrough(fmi: str) -> str:
    """Return the description of an FMU with an input and an output of each type."""
    kinds = FEEDTHROUGH[fmi]
    ports = [
        (kind, f"{kind}_{causality}", 2 * k + offset, causality)
        for k, kind in enumerate(kinds)
        for offset, causality in enumerate(("input", "output"))
    ]
    if fmi == "3.0":
        variables = "".join(_variable3(*port) for port in ports)
        variables += '<String name="String_input" valueReference="50" causality="input">'
        variables += '<Start value="Set me!"/></String>'
        types = f'<EnumerationType name="Option">{_ENUMERATION}</EnumerationType>'
        structure = "".join(
            f'<Output valueReference="{r}"/>' for _, _, r, c in ports if c == "output"
        )
        return _description(
            fmi, "feedthrough", "feedthrough", variables, structure,
            f"<TypeDefinitions>{types}</TypeDefinitions>",
        )  # fmt: skip
    variables = "".join(_variable2(*port) for port in ports)
    types = f'<SimpleType name="Option"><Enumeration>{_ENUMERATION}</Enumeration></SimpleType>'
    outputs = "".join(f'<Unknown index="{2 * k + 2}"/>' for k in range(len(kinds)))
    return _description(
        fmi, "feedthrough", "feedthrough", variables, f"<Outputs>{outputs}</Outputs>",
        f"<TypeDefinitions>{types}</TypeDefinitions>",
    )  # fmt: skip


def _variable2(kind: str, name: str, reference: int, causality: str) -> str:
    start = "false" if kind == "Boolean" else "1" if kind == "Enumeration" else "0"
    given = f' start="{start}"' if causality == "input" else ""
    declared = ' declaredType="Option"' if kind == "Enumeration" else ""
    variability = "continuous" if kind == "Float64" else "discrete"
    return (
        f'<ScalarVariable name="{name}" valueReference="{reference}" causality="{causality}" '
        f'variability="{variability}"><{_FMI2[kind]}{declared}{given}/></ScalarVariable>'
    )


def state_space() -> str:
    """Return the description of a linear system whose sizes are structural parameters m, n, r."""
    references = {"m": 1, "n": 2, "r": 3}
    variables = "".join(
        f'<UInt64 name="{name}" valueReference="{r}" causality="structuralParameter" '
        f'variability="fixed" start="3" min="0" max="5"/>'
        for name, r in references.items()
    )
    unit = "1 0 0 0 1 0 0 0 1"
    arrays = [("A", "nn", unit), ("B", "nm", unit), ("C", "rn", unit), ("D", "rm", unit)]
    arrays += [("x0", "n", "0 0 0"), ("u", "m", "1 2 3"), ("y", "r", ""), ("x", "n", "")]
    causes = {"u": "input", "y": "output", "x": "local"}
    for k, (name, sizes, start) in enumerate(arrays):
        dimensions = "".join(f'<Dimension valueReference="{references[s]}"/>' for s in sizes)
        given = f' start="{start}"' if start else ""
        variables += (
            f'<Float64 name="{name}" valueReference="{4 + k}"{given} '
            f'causality="{causes.get(name, "parameter")}">{dimensions}</Float64>'
        )
    structure = '<Output valueReference="10"/>'
    return _description("3.0", "state_space", "state space", variables, structure, "")
