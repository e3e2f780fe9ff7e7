"""The JSON Schemas of experiment.toml and study.toml, for editors that complete and check them."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from cardsflow_fmu.config.schema import Form
from cardsflow_fmu.experiment.schema import EXPERIMENT

DIALECT = "https://json-schema.org/draft/2020-12/schema"


def schema(kind: str = "experiment") -> dict[str, Any]:
    """The JSON Schema of a file of settings, made of what its reader goes by.

    It knows no robot: names of muscles, links and coordinates are for the reader to check.

    Args:
        kind: `experiment` or `study`.
    """
    whole = {"$schema": DIALECT, "title": f"{kind}.toml"}
    if kind == "study":
        from cardsflow_fmu.studies.definition.schema import STUDY

        return whole | _plain(STUDY)
    one = {"oneOf": [{"required": ["robot"]}, {"required": ["robots"]}]}
    return whole | _plain(EXPERIMENT) | one


def _plain(form: Form) -> dict[str, Any]:
    """A form as JSON holds it: lists for tuples, tables of its own."""
    plain: Mapping[str, Any] = json.loads(json.dumps(form))
    return dict(plain)
