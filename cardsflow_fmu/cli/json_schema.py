"""The JSON Schemas of experiment.toml and study.toml, for editors that complete and check them."""

from __future__ import annotations

from typing import Any

from cardsflow_fmu.config.schema import json_schema
from cardsflow_fmu.config.table import Table

DIALECT = "https://json-schema.org/draft/2020-12/schema"


def schema(kind: str = "experiment") -> dict[str, Any]:
    """The JSON Schema of a file of settings, made of what its reader goes by.

    It knows no robot: names of muscles, links and coordinates are for the reader to check.

    Args:
        kind: `experiment` or `study`.
    """
    return {"$schema": DIALECT, "title": f"{kind}.toml", **json_schema(_tables(kind))}


def _tables(kind: str) -> type[Table]:
    if kind == "study":
        from cardsflow_fmu.studies.definition.tables import StudyTables

        return StudyTables
    from cardsflow_fmu.experiment.settings.file import ExperimentTables

    return ExperimentTables
