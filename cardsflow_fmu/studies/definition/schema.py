"""The form of study.toml: every table, every key, its meaning, unit and default."""

from __future__ import annotations

from typing import get_args

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
    rows,
    table,
    text,
    whole,
)

from .study import METHODS, SAMPLERS, Engine
from .variations import RELATIVE

ENGINES = get_args(Engine)
TABLES = ("csv", "parquet")

_WAYS: dict[str, Form] = {
    "values": rows(ANYTHING, "these values", least=1),
    "grid": table(
        "evenly spaced values",
        {"from": number(), "to": number(), "count": whole("", least=1)},
        ["from", "to", "count"],
    ),
    "uniform": numbers(2, "drawn between two numbers"),
    "loguniform": numbers(2, "drawn between two numbers, evenly in their logarithm"),
    "normal": numbers(2, "drawn about a mean, by a standard deviation"),
    "box": table("a vector drawn in a box", {"from": numbers(3), "to": numbers(3)}, ["from", "to"]),
    "seed": {"const": True, "description": "a seed of its own for every run"},
}

_VARIATION = table(
    "Something that is varied; one of the ways to give values is needed.",
    {
        "path": either(
            text(), rows(text(), least=1), meaning="full key in the experiment; * for all names"
        ),
        "name": text("in tables and figures; the path when left out"),
        "together": flag("whether all names that * stands for take the same value", False),
        "relative": choice("values are relative to what the experiment has", RELATIVE),
        **_WAYS,
    },
    ["path"],
)

_CONSTRAINT = table("", {"metric": text(), "at_least": number(), "at_most": number()}, ["metric"])

STUDY = table(
    "A study of CARDSFlow: an experiment, varied and run many times.",
    {
        "experiment": text("an experiment.toml, or the folder that holds one"),
        "settings": named(ANYTHING, "changes to the experiment that all runs share"),
        "engine": choice(
            "plain Python objects, FMUs, or a loop in C: equal results", ENGINES, "direct"
        ),
        "seed": whole("where all random numbers come from", 0, least=0),
        "sampler": choice("how the variations are combined", SAMPLERS),
        "count": whole("number of samples", least=1),
        "metrics": rows(text(), "what is looked at", least=1),
        "output": text("folder for the results, relative to this file"),
        "tables": rows(choice("", TABLES), "kinds of the table", least=1),
        "vary": rows(_VARIATION, "what is varied"),
        "optimise": table(
            "A search for the best instead of a sampling.",
            {
                "method": choice("the algorithm", METHODS, METHODS[0]),
                "objective": text("the metric that is made small, or large"),
                "maximise": flag("whether large is good", False),
                "population": whole("robots in a generation", 16, least=5),
                "generations": whole("most generations", 30, least=1),
                "seeds": rows(whole("", least=0), "one independent search each", least=1),
                "constraints": rows(_CONSTRAINT, "what a robot must meet"),
            },
            ["objective"],
        ),
        "workspace": table(
            "Joint positions between which the workspace is looked at.",
            {
                "lower": by_name("in rad or m; the joint limits when left out"),
                "upper": by_name("in rad or m; the joint limits when left out"),
                "points": whole("poses along each coordinate", 5, least=1),
            },
        ),
    },
    ["experiment"],
)
