"""The form of experiment.toml: every table, every key, its meaning, unit and default."""

from __future__ import annotations

import math
from typing import Any, get_args

from addin_sdfusion.robot.model.tension_laws import PRESETS, TENSION_LAWS
from addin_sdfusion.robot.model.tension_parameters import Parameter
from addin_sdfusion.robot.model.trajectory import Spline
from cardsflow_fmu.config.schema import (
    ANYTHING,
    Form,
    by_name,
    choice,
    either,
    flag,
    named,
    number,
    numbers,
    positive,
    rows,
    table,
    text,
    whole,
)
from cardsflow_fmu.cosim.coupling import SCHEMES

from .controller_types import TYPES
from .experiment import MOST_SUBSTEPS, Engine
from .hardware_schema import HARDWARE
from .table_forms import TABLE_FORMS

SHAPES = ("sphere", "box", "capsule", "cylinder", "mesh")
INTEGRATORS = ("euler", "rk4")
FRICTION_LAWS = ("pyramid", "cone")
LINK_GEOMETRIES = ("meshes", "capsules", "none")
EXACT = "exact"
"""Stands for an infinite weight, which no number in a file does."""
CHANGED_KINDS = ("links", "joints", "coordinates", "muscles", "task_frames", "wrap_surfaces")

_FROM_ZERO, _ABOVE_ZERO = number(least=0), positive()
_FALSE: Form = {"const": False}

_ROBOT: dict[str, Form] = {
    "path": text("a model.sdf, a *_bodies.xml, or their folder, relative to this file"),
    "cable_set": text("the cable set to use; the file's own when left out"),
    "operational_space": text("the set of task coordinates y to use; the file's own if left out"),
    "gravity": numbers(3, "in the world, in m/s²; the file's own when left out"),
    **{
        kind: named(named(ANYTHING), f"changes of the robot's {kind.replace('_', ' ')}, by name")
        for kind in CHANGED_KINDS
    },
}

ROBOT = table("The robot.", _ROBOT, ["path"])

ROBOTS = rows(
    table(
        "One of several robots.",
        {
            "name": text("its name: letters, digits, underscores"),
            "position": numbers(3, "of its world in the common one, in m", [0.0, 0.0, 0.0]),
            "rpy": numbers(3, "roll, pitch and yaw of it, in rad", [0.0, 0.0, 0.0]),
            **_ROBOT,
        },
        ["name", "path"],
    ),
    "Several robots in one plant, in the place of [robot].",
    least=1,
)


def _parameter(parameter: Parameter) -> Form:
    form: dict[str, Any] = {"type": "number"}
    if math.isfinite(parameter.low) and not parameter.open_low:
        form["minimum"] = parameter.low
    unit = "" if parameter.unit == "1" else f", in {parameter.unit}"
    form["description"] = f"{parameter.meaning}{unit}"
    return form


def _parameters() -> dict[str, Form]:
    """The parameters of all laws; a bound holds where all laws that share a name have it."""
    forms: dict[str, Form] = {}
    for law in TENSION_LAWS.values():
        for parameter in law.parameters:
            new = _parameter(parameter)
            old = forms.setdefault(parameter.name, new)
            if old.get("minimum") != new.get("minimum"):
                forms[parameter.name] = {k: v for k, v in old.items() if k != "minimum"}
    return forms


MUSCLES = named(
    table(
        "A muscle, where it is to differ from the robot's.",
        {
            "f_min": number("smallest force, in N", least=0),
            "f_max": number("largest force, in N"),
            "model": either(
                choice("", [*TENSION_LAWS, *PRESETS]),
                table(
                    "A law with parameters.",
                    {
                        "preset": choice("where the parameters come from", PRESETS),
                        "kind": choice("the law; that of the preset or of the robot", TENSION_LAWS),
                        **_parameters(),
                    },
                ),
                meaning="how it pulls: a law or a preset by its name, or a table with parameters",
            ),
        },
    ),
    "Force bounds and models of single muscles, by the muscle's name.",
)

START = table(
    "The state at the start; where it is silent, that of the reference.",
    {
        "q": by_name("joint positions, in rad or m"),
        "qd": by_name("joint velocities, in rad/s or m/s", 0.0),
        "y": by_name("task coordinates, in m or rad: the pose is found by inverse kinematics"),
        "seed": by_name("where the inverse kinematics begin, in rad or m"),
    },
)

_POINT = table(
    "A point of the reference; q or y in all of them.",
    {
        "time": number("in s; 0 in the first point"),
        "q": by_name("joint positions, in rad or m"),
        "qd": by_name("joint velocities, in rad/s or m/s", 0.0),
        "qdd": by_name("joint accelerations, in rad/s² or m/s²", 0.0),
        "y": by_name("task coordinates, in m or rad"),
        "yd": by_name("their rates, in m/s or rad/s", 0.0),
        "ydd": by_name("their accelerations, in m/s² or rad/s²", 0.0),
        "blend_time": positive("of a parabolic blend, in s"),
    },
    ["time"],
)

REFERENCE = table(
    "What is to be followed: points, a trajectory by its name, or a flower.",
    {
        "name": text("of the points", "reference"),
        "spline": choice("the way between points", get_args(Spline)),
        "points": rows(_POINT, "points in the order of their times", least=2),
        "trajectory": text("the name of a trajectory of CASPR"),
        "file": text("where it stands; the one beside the robot when left out"),
        "flower": table(
            "A rose curve r = radius * cos(petals * phi) about a centre.",
            {
                "centre": numbers(3, "in m"),
                "axes": rows(numbers(3), "the two unit vectors of its plane"),
                "radius": positive("in m"),
                "petals": whole("number of petals", 5, least=1),
                "duration": positive("in s", 30.0),
            },
            ["centre", "radius"],
        ),
        "approach": table(
            "A straight way, from rest to rest, to where the reference begins.",
            {
                "duration": positive("in s"),
                "start": rows(number(), "where it begins, q or y; the start pose when left out"),
            },
            ["duration"],
        ),
    },
)

_WEIGHT = either(positive(), {"const": EXACT})

CONTROLLER = table(
    "The controller.",
    {
        "type": choice("the control law", TYPES),
        "kp": by_name("gain of position errors, in 1/s²", of=_ABOVE_ZERO),
        "kd": by_name("gain of velocity errors, in 1/s", of=_FROM_ZERO),
        "ki": by_name("gain of the errors' integrals, in 1/s³", 0.0, of=_FROM_ZERO),
        "period": positive("time between two ticks, in s: a whole multiple of run.step"),
        "solver": text("what solves the QP: dual_newton, or a back end of qpsolvers"),
        "weights": by_name("of squared forces, in 1/N²", of=_ABOVE_ZERO),
        "observer": number("bandwidth of the disturbance observer, in rad/s", 0.0, least=0),
        "delay": whole("ticks until forces take effect", 0, least=0, most=1),
        "predict": flag("whether the controller makes up for the delay", True),
        "muscle_horizon": number("how far ahead commands of muscles aim, in s", 0.0, least=0),
        "engine": choice("what computes the dynamics; auto is the core", get_args(Engine), "auto"),
        "posture": either(
            _FALSE,
            table(
                "",
                {
                    "kp": by_name("in 1/s²", of=_FROM_ZERO),
                    "kd": by_name("in 1/s", of=_FROM_ZERO),
                    "q0": by_name("the preferred posture, in rad or m; that of the start"),
                },
            ),
            meaning="what a redundant robot does beside its tasks; false for nothing",
        ),
        "task_weights": by_name('how much a task counts; "exact" to meet it exactly', of=_WEIGHT),
        "priorities": by_name("rank of a task, 1 first", 1.0, of=number(least=1)),
        "acceleration_weights": by_name("of squared accelerations", 1.0, of=_ABOVE_ZERO),
        "force_rate_weights": by_name("of squared changes of force", 0.0, of=_FROM_ZERO),
        "pretension": by_name("force that is preferred, in N", 0.0, of=_FROM_ZERO),
        "limit_bandwidth": either(
            _FALSE, positive(), meaning="how joint limits are kept, in rad/s; false for not at all"
        ),
    },
    ["kp", "kd"],
)

DISTURBANCE = table(
    "Forces on task points from outside.",
    {
        "force": named(numbers(3), "force on a task frame that is a point, in N, by its name"),
        "begin": number("in s", 0.0),
        "end": number("in s; never when left out"),
        "known": flag("whether the controller is told", False),
    },
)

_SURFACE: dict[str, Form] = {
    "friction": number("that of [world] when left out"),
    "restitution": number("0 for no bounce, 1 for one without loss"),
}

_PLACED: dict[str, Form] = {
    "shape": choice("its shape", SHAPES),
    "radius": positive("in m"),
    "length": positive("of a capsule or cylinder, in m"),
    "size": numbers(3, "of a box, in m"),
    "file": text("of a mesh, relative to this file"),
    "scale": either(number(), numbers(3), meaning="of a mesh", default=1.0),
    "position": numbers(3, "of its middle, in m", [0.0, 0.0, 0.0]),
    "rpy": numbers(3, "roll, pitch and yaw, in rad", [0.0, 0.0, 0.0]),
    **_SURFACE,
}

_OBJECT: dict[str, Form] = {
    "name": text("its name"),
    "mass": number("in kg; without one it stands still", 0.0),
    "velocity": numbers(3, "at the start, in m/s", [0.0, 0.0, 0.0]),
    "spin": numbers(3, "at the start, in rad/s", [0.0, 0.0, 0.0]),
    **_PLACED,
}

WORLD = table(
    "What stands around the robot.",
    {
        "ground": either(
            {"type": "boolean"},
            table("", {"height": number("in m", 0.0), **_SURFACE}),
            meaning="whether there is a ground",
            default=False,
        ),
        "friction": number("of whatever says nothing else", 1.0),
        "restitution": number("of whatever says nothing else", 0.0),
        "friction_law": choice("cone: Coulomb's law in every direction", FRICTION_LAWS, "pyramid"),
        "links": choice("what links collide with", LINK_GEOMETRIES, "meshes"),
        "capsule_radius": positive("where links are capsules, in m", 0.02),
        "self_collision": flag("whether links of the robot collide", False),
        "ignore": rows(rows({"type": "string"}), "pairs of names that pass through one another"),
        "contacts": rows({"type": "string"}, "whose contact forces are outputs"),
        "objects": rows(table("", _OBJECT, ["name", "shape"]), "things around the robot"),
        "shapes": rows(
            table("", {"link": text("of which link"), **_PLACED}, ["link", "shape"]),
            "what links collide with besides",
        ),
        "sdf": text("an SDF world whose still objects are taken, relative to this file"),
    },
)

PLANT = table(
    "The simulated robot.",
    {
        "step": positive("internal step, in s; run.step is a whole multiple of it"),
        "mass_scale": by_name("factor on masses that the controller does not know", 1.0),
        "integrator": choice("rk4: of fourth order, without contacts", INTEGRATORS, "euler"),
        "engine": choice("auto: the core where there are no contacts", get_args(Engine), "auto"),
        "substeps": whole(
            "steps of the integrator in an internal step", 1, least=1, most=MOST_SUBSTEPS
        ),
        "energy": flag("whether energies and work are outputs", False),
        "wrenches": rows({"type": "string"}, "links that take forces and torques from outside"),
    },
)

RUN = table(
    "The co-simulation.",
    {
        "step": positive("communication step, in s", 0.001),
        "duration": positive("in s; that of the reference when left out"),
        "output": text("folder for the results, relative to this file", "results"),
        "format": choice("of the table of results", TABLE_FORMS, "csv"),
        "coupling": choice("in what order participants are stepped", SCHEMES, "sampled"),
        "order": rows({"type": "string"}, "of the participants, for gauss_seidel"),
    },
)

_INPUTS = named(either(text(), number()), "another participant's output, or a number, for an input")

WIRING = table(
    "Inputs that are not connected to the output of the same name.",
    {"plant": _INPUTS, "controller": _INPUTS},
)

_FMU = either(
    text(),
    table(
        "",
        {
            "path": text("the .fmu, relative to this file"),
            "inputs": named(text(), "the FMU's variable for each port that it takes"),
            "outputs": named(text(), "the FMU's variable for each port that it gives"),
            "units": named(text(), "of variables, where the FMU does not tell"),
            "parameters": named(number(), "start values, by the FMU's own names"),
        },
        ["path"],
    ),
    meaning="an .fmu, or a table with its path and a name map",
)

FMUS = table(
    "External FMUs in the place of plant, controller, reference or hardware.",
    dict.fromkeys(("plant", "controller", "reference", "hardware"), _FMU),
)

EXPERIMENT = table(
    "An experiment of CARDSFlow: what is simulated, how it is controlled, and for how long.",
    {
        "robot": ROBOT,
        "robots": ROBOTS,
        "muscles": MUSCLES,
        "start": START,
        "reference": REFERENCE,
        "controller": CONTROLLER,
        "disturbance": DISTURBANCE,
        "world": WORLD,
        "plant": PLANT,
        "run": RUN,
        "wiring": WIRING,
        "fmus": FMUS,
        "hardware": HARDWARE,
    },
    ["controller"],
)
