"""What C has to know of the table of muscle laws: headers that the build makes of it.

`law_parameters.h` has a struct of parameters for every law, and functions of its terms;
`law_table.h` its bounds, rules, states and range of commands, and the list of laws; `law_sources.h`
their C files, for the core with tangents. hatch_build.py writes them to `sim_dart/generated`.
It reads this module by its path, so that it needs the standard library only.
"""

from __future__ import annotations

import ast
import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from addin_sdfusion.robot.model.laws.law import MuscleLawDefinition, Parameter

TABLE = "addin_sdfusion/robot/model/laws"
CSRC = "sim_dart/csrc"
GENERATED = "sim_dart/generated"

_MADE = f"/* Made by hatch_build.py of {TABLE}: change that, not this. */\n"
_DEFINED = re.compile(r"^TENSION_LAW\((\w+)\) =", re.MULTILINE)
_PIECE = re.compile(r"\s?.{1,90}(?=\s|$)\n?")
_OPERATORS: dict[type[ast.AST], str] = {
    ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.USub: "-", ast.Lt: "<",
    ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!=", ast.And: "&&",
    ast.Or: "||",
}  # fmt: skip
_FUNCTIONS = {"min": "smaller", "max": "larger", "sqrt": "sqrt"}


class LawTableError(ValueError):
    """The table of laws and the C files do not fit together."""


def headers(laws: Mapping[str, MuscleLawDefinition], names: str, root: Path) -> dict[str, str]:
    """Return the headers.

    Args:
        laws: The table.
        names: What a core answers that is asked for its laws.
        root: The source tree.

    Returns:
        Their texts, by their paths below the root.

    Raises:
        LawTableError: A law has no C file, a C file no law, or a formula is none.
    """
    files = _law_files(laws, root)
    texts = {
        "law_parameters.h": _parameters_header(laws.values(), names),
        "law_table.h": _table_header(laws.values()),
        "law_sources.h": _MADE + "".join(f'#include "../csrc/{name}"\n' for name in files),
    }
    return {f"{GENERATED}/{name}": text for name, text in texts.items()}


def _law_files(laws: Mapping[str, MuscleLawDefinition], root: Path) -> list[str]:
    """Return the C files of the laws and of what they share, below `CSRC`."""
    folder = root / CSRC / "laws"
    files = sorted(path for path in folder.rglob("*.c") if path != folder / "laws.c")
    texts = (path.read_text(encoding="utf-8") for path in files)
    defined = {kind for text in texts for kind in _DEFINED.findall(text)}
    for kind in sorted(laws.keys() - defined):
        raise LawTableError(f"{CSRC}/laws: no C file has TENSION_LAW({kind}) of {TABLE}")
    for kind in sorted(defined - laws.keys()):
        raise LawTableError(f"{TABLE}: no module has the law {kind!r} of {CSRC}/laws")
    return [path.relative_to(root / CSRC).as_posix() for path in files]


def _names(law: MuscleLawDefinition) -> list[str]:
    return [parameter.name for parameter in law.parameters]


def _parameters_header(laws: Iterable[MuscleLawDefinition], names: str) -> str:
    laws = list(laws)
    most = max(len(law.states) for law in laws)
    lines = [
        f"    {_quoted(piece)}"
        for line in names.splitlines(keepends=True)
        for piece in _PIECE.findall(line)
    ]
    kinds = "".join(f"    KIND_{law.kind},\n" for law in laws)
    parts = [
        _MADE,
        "#ifndef CARDSFLOW_LAW_PARAMETERS_H\n#define CARDSFLOW_LAW_PARAMETERS_H\n",
        '#include "../csrc/math/elementary.h"\n',
        "/* Which law a muscle of a blob has. */",
        f"enum law_kind {{\n{kinds}    LAW_KINDS\n}};\n",
        "/* The most states of a law. */",
        f"#define MAX_LAW_STATES {most}\n",
        "/* Every law with its parameters: what core_laws answers. */",
        "#define LAW_NAMES " + " \\\n".join(["", *lines]).lstrip() + "\n",
        *(part for law in laws for part in _parameters(law)),
        "#endif\n",
    ]
    return "\n".join(parts)


def _parameters(law: MuscleLawDefinition) -> Iterator[str]:
    """The struct of a law, as its numbers lie in a blob, and functions of its terms."""
    if not law.parameters:
        return
    fields = "".join(
        f"    real {p.name}; /* {p.meaning}; [{p.unit}], {p.bounds} */\n" for p in law.parameters
    ).replace("(*)", "")
    yield f"/* {law.kind}: {law.meaning} */"
    yield f"typedef struct {{\n{fields}}} {law.kind}_parameters;\n"
    for term in law.terms:
        head = f"static inline real {law.kind}_{term.name}(const {law.kind}_parameters *p)"
        yield f"{head}\n{{\n    return {_in_c(term.formula, law)};\n}}\n"


def _table_header(laws: Iterable[MuscleLawDefinition]) -> str:
    laws = list(laws)
    bounds = list(_bounds(laws))
    return "\n".join(
        [
            _MADE,
            "#if !defined(CARDSFLOW_TANGENT) /* a handle with tangents is a copy of a plain one */",
            *(f"extern const tension_law LAW_{law.kind};" for law in laws),
            "",
            "#define REQUIRE(condition, text) \\\n    if (!(condition)) return text\n",
            *(text for law in laws for text in _functions(law).values()),
            "#endif\n",
            *_bounds_table(laws),
            "static const law_entry LAW_TABLE[] = {",
            *(f"    {{\n{_entry(law, bounds)}    }}," for law in laws),
            "};\n",
        ]
    )


def _bounds(laws: Iterable[MuscleLawDefinition]) -> dict[tuple[float, float, bool], str]:
    """Return the different bounds of all parameters, with their words."""
    return {_bounds_of(p): p.bounds for law in laws for p in law.parameters}


def _bounds_of(p: Parameter) -> tuple[float, float, bool]:
    return p.low, p.high, p.open_low


def _bounds_table(laws: Iterable[MuscleLawDefinition]) -> Iterator[str]:
    yield "static const law_bounds BOUNDS[] = {"
    for (low, high, is_open), words in _bounds(laws).items():
        yield f"    {{{_number(low)}, {_number(high)}, {int(is_open)}, {_quoted(words)}}},"
    yield "};\n"


def _entry(law: MuscleLawDefinition, bounds: Sequence[tuple[float, float, bool]]) -> str:
    values = {
        "name": _quoted(law.kind),
        "law": f"&LAW_{law.kind}",
        "parameters": len(law.parameters),
        "driven": int(law.command is not None),
        "pushes": int(law.pushes),
    }
    if law.parameters:
        rows = ", ".join(str(bounds.index(_bounds_of(p))) for p in law.parameters)
        names = ", ".join(_quoted(p.name) for p in law.parameters)
        values["bounds"] = f"WHEN_OPENED(((const uint8_t[]){{{rows}}}))"
        values["names"] = f"WHEN_OPENED(((const char *const[]){{{names}}}))"
    values |= {name: f"WHEN_OPENED({law.kind}_{name})" for name in _functions(law)}
    return "".join(f"        .{name} = {value},\n" for name, value in values.items())


def _functions(law: MuscleLawDefinition) -> dict[str, str]:
    """Return the functions of a law that are made of the table, by what they are."""
    command = law.command
    low, high = (0.0, 0.0) if command is None else (command.low, command.high)
    limits = f"    k[LAW_LOW] = {_limit(low, law)}, k[LAW_HIGH] = {_limit(high, law)};\n"
    found = {"range": _function(law, "void", "range", "const void *parameters, real *k", limits)}
    if law.states:
        always = sum(not state.where for state in law.states)
        more = [f"({_in_c(state.where, law)})" for state in law.states if state.where]
        count = f"    return {' + '.join([str(always), *more])};\n"
        found["states"] = _function(law, "int", "states", "const void *parameters", count)
    if law.conditions:
        lines = "".join(
            f"    REQUIRE({_in_c(rule.condition, law)},\n            {_quoted(rule.text)});\n"
            for rule in law.conditions
        )
        body = f"{lines}    return NULL;\n"
        found["broken_rule"] = _function(
            law, "const char *", "broken_rule", "const void *parameters", body
        )
    return found


def _function(law: MuscleLawDefinition, answer: str, name: str, takes: str, body: str) -> str:
    taken = (
        f"    const {law.kind}_parameters *p = parameters;\n"
        if "p->" in body or "(p)" in body
        else ""
    )
    unused = "" if taken else "    (void)parameters;\n"
    between = "" if answer.endswith("*") else " "
    head = f"static {answer}{between}{law.kind}_{name}({takes})"
    return f"{head}\n{{\n{taken or unused}{body}}}\n"


def _limit(limit: float | str, law: MuscleLawDefinition) -> str:
    return _in_c(limit, law) if isinstance(limit, str) else _number(limit)


def _quoted(text: str) -> str:
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n") + '"'


def _number(value: float) -> str:
    if math.isinf(value):
        return "INFINITY" if value > 0 else "-INFINITY"
    short = f"{value:g}"
    return short if float(short) == value else repr(value)


def _in_c(formula: str, law: MuscleLawDefinition) -> str:
    """Return a formula of the table in C, with `p` the law's parameters."""
    try:
        return str(_Translator(law).visit(ast.parse(formula, mode="eval").body))
    except (SyntaxError, LookupError) as error:
        raise LawTableError(f"{TABLE}: {law.kind}: {formula!r} is not a formula: {error}") from None


class _Translator(ast.NodeVisitor):
    """Makes C of a formula: sums and products in brackets, comparisons of values."""

    def __init__(self, law: MuscleLawDefinition) -> None:
        self._law = law

    def generic_visit(self, node: ast.AST) -> str:
        raise LookupError(f"it has {type(node).__name__}")

    def visit_Constant(self, node: ast.Constant) -> str:
        return repr(float(str(node.value)))  # whole numbers would be divided as such

    def visit_Name(self, node: ast.Name) -> str:
        if node.id in _names(self._law):
            return f"p->{node.id}"
        if node.id in [term.name for term in self._law.terms]:
            return f"{self._law.kind}_{node.id}(p)"
        raise LookupError(f"{node.id} is neither parameter nor term")

    def visit_UnaryOp(self, node: ast.UnaryOp) -> str:
        return f"{_OPERATORS[type(node.op)]}{self.visit(node.operand)}"

    def visit_BinOp(self, node: ast.BinOp) -> str:
        return f"({self.visit(node.left)} {_OPERATORS[type(node.op)]} {self.visit(node.right)})"

    def visit_BoolOp(self, node: ast.BoolOp) -> str:
        return f" {_OPERATORS[type(node.op)]} ".join(f"({self.visit(v)})" for v in node.values)

    def visit_Compare(self, node: ast.Compare) -> str:
        sides = ((n, self.visit(n)) for n in (node.left, *node.comparators))
        numbers = [t if isinstance(n, ast.Constant) else f"value_of({t})" for n, t in sides]
        pairs = zip(numbers, node.ops, numbers[1:], strict=False)
        return " && ".join(f"{a} {_OPERATORS[type(op)]} {b}" for a, op, b in pairs)

    def visit_IfExp(self, node: ast.IfExp) -> str:
        test, yes, no = map(self.visit, (node.test, node.body, node.orelse))
        return f"({test} ? {yes} : {no})"

    def visit_Call(self, node: ast.Call) -> str:
        assert isinstance(node.func, ast.Name)
        return f"{_FUNCTIONS[node.func.id]}({', '.join(map(self.visit, node.args))})"
