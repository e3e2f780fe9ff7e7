"""Makes the tables in docs/ of what the code has: commands, ports, laws, settings, limits.

python docs/make_tables.py
"""

from __future__ import annotations

import argparse
import json
import math
import re
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))

from addin_sdfusion.robot import limits  # noqa: E402
from addin_sdfusion.robot.formats import features  # noqa: E402
from addin_sdfusion.robot.formats.capability import Capabilities, Feature  # noqa: E402
from addin_sdfusion.robot.formats.caspr.capabilities import CASPR  # noqa: E402
from addin_sdfusion.robot.formats.mjcf.capabilities import MJCF, mesh_rows  # noqa: E402
from addin_sdfusion.robot.formats.opensim.capabilities import OPENSIM  # noqa: E402
from addin_sdfusion.robot.formats.sdf.capabilities import SDF  # noqa: E402
from addin_sdfusion.robot.formats.urdf.capabilities import URDF  # noqa: E402
from addin_sdfusion.robot.model.laws import TENSION_LAWS  # noqa: E402
from addin_sdfusion.robot.model.laws.law import Parameter, TensionLaw  # noqa: E402
from addin_sdfusion.robot.model.tension_laws import PRESETS  # noqa: E402
from cardsflow_fmu import Experiment  # noqa: E402
from cardsflow_fmu.cli.common import EXIT_CODES  # noqa: E402
from cardsflow_fmu.cli.init import schema  # noqa: E402
from cardsflow_fmu.cli.main import _parser  # noqa: E402
from cardsflow_fmu.cosim.signals.groups import all_ports  # noqa: E402
from cardsflow_fmu.cosim.signals.hardware import hardware_groups  # noqa: E402
from cardsflow_fmu.cosim.signals.port import Port, identifier  # noqa: E402
from cardsflow_fmu.experiment.settings.controller_types import TYPES  # noqa: E402
from cardsflow_fmu.models.controller import ControllerModel  # noqa: E402
from cardsflow_fmu.models.estimator import EstimatorModel  # noqa: E402
from cardsflow_fmu.models.plant import PlantModel  # noqa: E402
from cardsflow_fmu.models.reference import ReferenceModel  # noqa: E402
from cardsflow_fmu.models.sensors import SensorsModel  # noqa: E402

MADE = "<!-- Made by docs/make_tables.py of the code: change that, not this. -->"


def table(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table in Markdown."""
    lines = [heads, ["---"] * len(heads), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def commands_page() -> str:
    """Every command with its arguments and options."""
    parts = [
        MADE,
        "# Commands",
        f"```text\n{EXIT_CODES}\n```",
        "Every command except `addin` accepts `--quiet` (print no progress, notes and warnings) "
        "and `--debug` (print the traceback of an error). Colours are used only on a terminal; the "
        "environment variable `NO_COLOR` turns them off.",
        "Commands replace files that CARDSFlow wrote, and no other files. `--overwrite` also "
        "replaces other files. `init` needs `--overwrite` for every existing file, because an "
        "experiment.toml is meant to be edited. `import-cad` and the add-in keep the files of a "
        "robot folder that were edited.",
    ]
    for name, parser in _commands("cardsflow", _parser()):
        parts += [f"## {name}", str(parser.description)]
        shown = [a for a in parser._actions if a.dest not in ("help", "debug", "quiet")]
        shown = [a for a in shown if a.help != argparse.SUPPRESS]
        parts += [table(["", ""], map(_option, shown))]
        if parser.epilog:
            parts.append(f"For example `{parser.epilog.partition(chr(10))[2].strip()}`.")
    return "\n\n".join(parts) + "\n"


def _commands(
    prefix: str, parser: argparse.ArgumentParser
) -> Iterator[tuple[str, argparse.ArgumentParser]]:
    """Commands, and those of groups of commands, by their full names."""
    inner = [a for a in parser._actions if isinstance(a, argparse._SubParsersAction)]
    if not inner:
        yield prefix, parser
    for action in inner:
        for name, child in action.choices.items():
            yield from _commands(f"{prefix} {name}", child)


def _option(action: argparse.Action) -> tuple[str, str]:
    value = action.metavar or (
        "|".join(map(str, action.choices)) if action.choices else action.dest.upper()
    )
    words = [f"{word}" for word in action.option_strings] or [str(value)]
    takes = f" {value}" if action.option_strings and action.nargs != 0 else ""
    text = (action.help or "").replace("|", "\\|").replace("%%", "%")
    return f"`{', '.join(words)}{takes}`".replace("|", "\\|"), text


EXAMPLES = {
    "planar_2r": {"robot.joints.joint_2.motor": True},
    "roboy_left_arm": {},
    "hill_arm": {},
    "pneumatic_elbow": {"plant.energy": True},
    "pick_up": {"plant.wrenches": ["forearm"], "world.friction_law": "cone"},
}
"""Experiments that have all kinds of ports between them."""


ESTIMATED: dict[str, Any] = {
    "robot.joints.joint_2.motor": True,
    "estimator": {"encoder_noise": {"joint_1": 1e-3}, "imus": [{"link": "link_2"}]},
}
"""The same of an estimator."""


def ports_page() -> str:
    """The ports of all models, with placeholders for names."""
    experiments = [
        Experiment.load(ROOT / "examples" / name, settings) for name, settings in EXAMPLES.items()
    ]
    estimated = Experiment.load(ROOT / "examples" / "planar_2r", ESTIMATED)
    parts = [
        MADE,
        "# Ports of the FMUs",
        "Variables are named after what they belong to, by the designer's names: `<joint>` a "
        "coordinate, `<muscle>` a muscle, `<point>.<axis>` a task coordinate, `<link>` a link. "
        "What is no letter, digit or underscore in a name becomes `_`. With `--fmi 3.0` the "
        "variables that share all but the name are one array: `q[2]`.",
        "All units are SI; of a prismatic joint m in place of rad, N in place of N.m.",
        "`plant.fmu`, `controller.fmu` and `reference.fmu` are wired by equal names, the "
        "plant's `q` to the controller's `q`; "
        "[`[wiring]`](experiments.md#wiring-and-fmus) of an experiment changes that.",
        _ports("plant.fmu", experiments, PlantModel.table),
        "`u.<muscle>` stands in the place of `f.<muscle>` where a muscle has a [law](laws.md); "
        "its states, such as `activation`, are those of its law.",
        "Commands that nobody gives are those that the controller has before its first tick: "
        "`f_min` of every cable; where muscles have laws, what holds the robot at `q_start`; no "
        "torque of motors. Native and Python models have the same.",
        "`tau.<joint>` is there where a joint has a [motor](robots.md#motors-of-joints), here and "
        "in the other tables.",
        _ports("controller.fmu", experiments, ControllerModel.table),
        _ports("reference.fmu", experiments, ReferenceModel.table),
        _ports("sensors.fmu", [estimated], SensorsModel.table),
        _ports("estimator.fmu", [estimated], EstimatorModel.table),
        "Both exist if the experiment has an [estimator](../how_to/estimation.md). The controller "
        "then has the inputs `w_hat.<joint>` and `valid` in addition, and its `q`, `qd` come from "
        "`q_hat`, `qd_hat`. With hardware, the outputs of `hardware.fmu` of the same names are the "
        "measurements. `q.<joint>` exists for coordinates with an encoder, `<link>` stands for "
        "links with an IMU (inertial measurement unit).",
        _ports("hardware.fmu", experiments[:2], _hardware),
        "Beside these it has all ports of `plant.fmu`: it takes the plant's place.",
    ]
    return "\n\n".join(parts) + "\n"


def _hardware(experiment: Experiment) -> list[Port]:
    robot, begin = experiment.robot, experiment.start
    plant = {port.name for port in PlantModel.table(experiment)}
    ports = all_ports(hardware_groups(robot, begin.q, begin.qd, experiment.plant.step))
    return [port for port in ports if port.name not in plant]


def _ports(
    title: str, experiments: Sequence[Experiment], ports_of: Callable[[Experiment], list[Port]]
) -> str:
    """The ports of one model over all experiments, each pattern once."""
    rows: dict[tuple[str, str], _Row] = {}
    for experiment in experiments:
        for port in ports_of(experiment):
            pattern, text = _pattern(port, experiment)
            stem, _, axis = pattern.rpartition(".")
            is_axis = bool(stem) and re.fullmatch(r"[ftq]?[wxyz]", axis) is not None
            key = (stem, port.description[:6]) if is_axis else (pattern, "")
            row = rows.setdefault(key, _Row(port, text))
            row.units[port.unit or ("0 or 1" if port.boolean else "1")] = None
            row.axes |= {axis: None} if is_axis else {}
    order = ("input", "output", "parameter")
    lines = [
        (_named(stem, row), p.causality, p.variability, " or ".join(row.units), row.text)
        for (stem, _), row in sorted(rows.items(), key=lambda r: order.index(r[1].port.causality))
        for p in [row.port]
    ]
    head = table(["name", "causality", "variability", "unit", "what"], lines)
    return f"## {title}\n\n{head}"


@dataclass
class _Row:
    """A line of a table of ports: a port in the place of several, its units, its axes in order."""

    port: Port
    text: str
    units: dict[str, None] = field(default_factory=dict)
    axes: dict[str, None] = field(default_factory=dict)


def _named(stem: str, row: _Row) -> str:
    """A port's name in code, with all its axes: `y.hand.x, .y, .z`."""
    first, *more = list(row.axes) or [""]
    return f"`{', .'.join([f'{stem}.{first}' if first else stem, *more])}`"


def _pattern(port: Port, experiment: Experiment) -> tuple[str, str]:
    """A port's name and description with placeholders for names."""
    prefix, _, rest = port.name.partition(".")
    for kind, names in _names(experiment).items():
        for name in sorted(names, key=len, reverse=True):
            ending = rest.removeprefix(identifier(name))
            if ending == rest or ending[:1] not in ("", "."):
                continue
            if prefix == "u":
                what = "Command of muscle `<muscle>`: excitation, pressure, voltage or free length"
                return "u.<muscle>", what
            if kind == "<point>" and prefix != "w":
                kind, ending, name = "<point>.<axis>", "", rest
            text = port.description.replace(name, f"`{kind}`", 1)
            return f"{prefix}.{kind}{ending}", text.replace(f"`{ending}", "`") if ending else text
    return port.name, re.sub(r"( the world's)? x$", r" each axis", port.description)


def _names(experiment: Experiment) -> dict[str, list[str]]:
    robot, scene = experiment.robot, experiment.scene
    objects = [thing.name for thing in scene.moving_objects] if scene else []
    return {
        "<joint>": [c.name for c in robot.coordinates],
        "<muscle>": [muscle.name for muscle in robot.muscles],
        "<point>": [frame.name for frame in robot.task_frames],
        "<object>": objects,
        "<link>": [link.name for link in robot.links],
    }


def laws_page() -> str:
    """The tension laws with all their parameters."""
    parts = [
        MADE,
        "# Tension laws of muscles",
        "What a muscle pulls with follows from its command, its path length `l` and the rate `l'` "
        "of that by its law. It is given in the robot's files (`<cable_model kind=...>` in "
        "[cardsflow.xml](robots.md#muscles)) or in the experiment (`[muscles.<name>] model`, "
        "[here](experiments.md#muscles)). The equations are in `sim_dart/csrc/laws`.",
    ]
    for law in TENSION_LAWS.values():
        parts += [f"## {law.kind}", _law_text(law)]
        if law.parameters:
            parts.append(table(["parameter", "unit", "default", "range", "what"],
                               map(_parameter, law.parameters)))  # fmt: skip
        if law.rules:
            parts.append(_rules(law))
    presets = ", ".join(f"`{name}` ({model.kind})" for name, model in PRESETS.items())
    parts += ["## Presets", f"Published sets of parameters, by name: {presets}."]
    return "\n\n".join(parts) + "\n"


def _law_text(law: TensionLaw) -> str:
    command = law.command
    words = [
        f"{law.meaning[0].upper()}{law.meaning[1:]}. {law.source}.",
        f"Command: {command.name.replace('_', ' ')} [{command.unit}]."
        if command
        else "It takes no command.",
    ]
    if law.states:
        states = (
            f"`{s.name}` [{s.unit}]" + (f" where `{s.where}`" if s.where else "")
            for s in law.states
        )
        words.append(f"States: {', '.join(states)}.")
    return " ".join(words)


def _rules(law: TensionLaw) -> str:
    """What must hold between its parameters."""
    rules = "".join(
        f"\n- `{r.condition}`" + (f": {r.why}" if r.why else "") for r in law.conditions
    )
    terms = "; ".join(f"`{term.name} = {term.formula}`" for term in law.terms)
    return f"These must hold:\n{rules}" + (f"\n\nwith {terms}." if terms else "")


def _parameter(parameter: Parameter) -> tuple[str, ...]:
    default = "must be given" if parameter.default is None else f"{parameter.default:.6g}"
    low = f"{'above' if parameter.open_low else 'from'} {parameter.low:g}"
    high = f"to {parameter.high:g}"
    bounds = [
        *([low] if math.isfinite(parameter.low) else []),
        *([high] if math.isfinite(parameter.high) else []),
    ]
    return (
        f"`{parameter.name}`",
        parameter.unit,
        default,
        " ".join(bounds) or "any",
        parameter.meaning.replace("|", "\\|"),
    )


def control_laws() -> str:
    """The types of controllers."""
    rows = (
        (
            f"`{name}`",
            "q" if law.space == "joint" else "y",
            "N·m/rad" if law.torque_gains else "1/s²",
            law.meaning,
        )
        for name, law in TYPES.items()
    )
    return table(["type", "follows", "unit of kp", "law"], rows)


def settings_page(page: str, schema: Mapping[str, Any]) -> str:
    """A page with its tables of settings, each behind a comment that says which.

    Args:
        page: Path of the page below `docs`.
        schema: The JSON Schema that holds them.
    """

    def made(found: re.Match[str]) -> str:
        form = schema
        for part in found["path"].split(".") if found["path"] != "study" else ():
            form = _inside(form, part)
        return f"{found['begin']}\n{_settings(form)}\n{found['end']}"

    text = (ROOT / "docs" / page).read_text(encoding="utf-8")
    laws = r"(?<=<!-- control laws -->\n).*?(?=<!-- end of control laws -->)"
    text = re.sub(laws, lambda _: control_laws() + "\n", text, flags=re.DOTALL)
    pattern = r"(?P<begin><!-- settings: (?P<path>\S+) -->)\n.*?(?P<end><!-- end of settings -->)"
    return re.sub(pattern, made, text, flags=re.DOTALL)


def _inside(form: Mapping[str, Any], key: str) -> Mapping[str, Any]:
    """The form of a table under a key, of its rows where it is a list, or by any name for `*`."""
    table = next(own for own in form.get("anyOf", [form]) if own.get("type") == "object")
    inner = table["additionalProperties"] if key == "*" else table["properties"][key]
    return next((own["items"] for own in [inner] if own.get("type") == "array"), inner)


def _settings(form: Mapping[str, Any]) -> str:
    """The keys of a table of settings."""
    own = next(own for own in form.get("anyOf", [form]) if "properties" in own)
    required = own.get("required", [])
    rows = [
        (
            f"`{key}`",
            _values(inner),
            "must be given" if key in required else _default(inner),
            inner["description"].replace("|", "\\|"),
        )
        for key, inner in own["properties"].items()
    ]
    return table(["key", "value", "default", "what"], rows)


def _default(form: Mapping[str, Any]) -> str:
    return f"`{json.dumps(form['default'])}`" if "default" in form else ""


def _values(form: Mapping[str, Any]) -> str:
    """What a key may hold, in words."""
    if {"enum": ["inf", "-inf"]} in form.get("anyOf", []):
        return "number"
    if "anyOf" in form:
        item, *others = form["anyOf"]
        by_name = {"type": "object", "additionalProperties": item}
        if by_name in others:
            words = [f"{_values(item)}, or one by name"]
            others = [own for own in others if own != by_name and own.get("items") != item]
        else:
            words = [_values(item)]
        return " or ".join([*words, *map(_values, others)])
    if "const" in form or "enum" in form:
        names = form.get("enum", [form.get("const")])
        return ", ".join(f"`{json.dumps(name)}`" for name in names)
    kind = form.get("type", "anything")
    if kind == "array":
        several = f"{form['minItems']} " if form.get("maxItems") else ""
        rows = form.get("items", {}).get("type", "value")
        words = {"object": "table", "array": "list", "string": "text", "integer": "whole number"}
        return f"{several}{words.get(rows, rows)}s"
    if kind == "object":
        return "table"
    words = {"integer": "whole number", "string": "text", "boolean": "true or false"}
    bounds = {"exclusiveMinimum": "above", "minimum": "from", "maximum": "to"}
    limits = [f"{word} {form[key]:.7g}" for key, word in bounds.items() if key in form]
    return " ".join([words.get(kind, kind), *limits])


LIMITS: tuple[tuple[str, int, Mapping[str, int]], ...] = (
    (
        "a robot, a world",
        limits.XML,
        {
            "elements in all files": limits.XML_ELEMENTS,
            "wraps of a muscle": limits.WRAPS,
            "coordinates whose drives are looked at": limits.DRIVEN_COORDINATES,
            "such muscles": limits.DRIVEN_MUSCLES,
            "bodies that can touch": limits.BODIES,
            "numbers in a mass matrix or Jacobian": limits.MATRIX,
        },
    ),
    ("CASPR's trajectories", limits.TRAJECTORY, {}),
    (
        "a mesh",
        limits.MESH,
        {"numbers": limits.MESH_NUMBERS, "parts of a scene": limits.MESH_NODES},
    ),
    ("a mesh as text", limits.MESH_TEXT, {}),
    ("an experiment, a study", limits.SETTINGS, {}),
    ("a design's snapshot", limits.SNAPSHOT, {"values": limits.SNAPSHOT_VALUES}),
    ("a design's program, its tables", limits.DESIGN, {}),
    ("a STEP file", limits.STEP, {}),
    (
        "an FMU, an .ssp, an experiment.zip",
        limits.ARCHIVE,
        {"files": limits.ARCHIVE_ENTRIES, "MiB unpacked": limits.UNPACKED // limits.MIB},
    ),
    ("an FMU's description", limits.DESCRIPTION, {"variables": limits.COLUMNS}),
    ("a table", limits.TABLE, {"columns": limits.COLUMNS, "numbers": limits.VALUES}),
    ("a motion", limits.MOTION, {"rows": limits.MOTION_ROWS, "numbers": limits.MOTION_VALUES}),
    ("a recording", limits.RECORDING, {"messages": limits.RECORDS}),
    ("other JSON", limits.JSON, {}),
)
"""What is read, the most bytes that its file may have, and the most of what is in it."""


def security_page() -> str:
    """The page with its table of limits."""
    rows = [
        (
            what,
            f"{size // limits.MIB} MiB",
            "; ".join(f"{most} {name}" for name, most in others.items()),
        )
        for what, size, others in LIMITS
    ]
    text = (ROOT / "docs/explanation/security.md").read_text(encoding="utf-8")
    begin, end = "<!-- limits -->", "<!-- end of limits -->"
    made = f"{begin}\n{table(['file', 'at most', 'in it'], rows)}\n{end}"
    return re.sub(f"{begin}.*{end}", made, text, flags=re.DOTALL)


FORMATS = (SDF, URDF, CASPR, Capabilities(MJCF.title, (*MJCF.rows, *mesh_rows({}))), OPENSIM)


def robots_page() -> str:
    """The page with its table of what formats do with the features of robots."""
    rows = [
        (feature.name, *(_fates(capabilities, feature) for capabilities in FORMATS))
        for feature in features.CATALOGUE
    ]
    heads = ["feature", *(capabilities.title for capabilities in FORMATS)]
    text = (ROOT / "docs/reference/robots.md").read_text(encoding="utf-8")
    begin, end = "<!-- features -->", "<!-- end of features -->"
    made = f"{begin}\n{table(heads, rows)}\n{end}"
    return re.sub(f"{begin}.*{end}", lambda _: made, text, flags=re.DOTALL)


def _fates(capabilities: Capabilities, feature: Feature) -> str:
    """What becomes of a feature, with the cases of which it does."""
    cases: dict[str, list[str]] = {}
    for row in capabilities.rows:
        if feature.name in [known.name for known in row.features]:
            cases.setdefault(row.fate, []).append(row.only)
    words = []
    for fate, only in cases.items():
        some = "; ".join(dict.fromkeys(filter(None, only))) if all(only) else ""
        words.append(f"{fate} ({some})" if some else fate)
    return ", ".join(words)


SETTINGS_PAGES = {
    "reference/experiments.md": "experiment",
    "reference/snapshot.md": "snapshot",
    "how_to/studies.md": "study",
}
"""Pages with tables of settings, and the kind of their schema."""

PAGES = {
    "reference/commands.md": commands_page,
    "reference/ports.md": ports_page,
    "reference/laws.md": laws_page,
    "explanation/security.md": security_page,
    "reference/robots.md": robots_page,
} | {page: partial(settings_page, page, schema(kind)) for page, kind in SETTINGS_PAGES.items()}

if __name__ == "__main__":
    for file, page in PAGES.items():
        (ROOT / "docs" / file).write_text(page(), encoding="utf-8")
        print(ROOT / "docs" / file)
