"""Reference results in an FMU, described by the manifest of the layered standard FMI-LS-REF.

The standard is a draft: version 1.0.0-alpha.1 of https://github.com/modelica/fmi-ls-ref. It
specifies folder, manifest and the role `result` of files, but not the format of results.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from typing import NamedTuple

from cardsflow_fmu.utils.arrays import FloatArray
from cardsflow_fmu.utils.csv_table import csv_text

from .description import xml_bytes

FOLDER = "extra/org.fmi-standard.fmi-ls-ref"
_SPACE = "http://fmi-standard.org/fmi-ls-manifest"
_ABOUT = {
    "fmi-ls-name": "org.fmi-standard.fmi-ls-ref",
    "fmi-ls-version": "1.0.0-alpha.1",
    "fmi-ls-description": "Layered Standard providing information on related files included in "
    "an FMU.",
}


class ReferenceResults(NamedTuple):
    """Outputs of a model with constant inputs and parameters, their start values.

    Attributes:
        names: Names of the columns; the first is `time`.
        rows: Values, shape (rows, len(names)); the first row is the start.
        step: Communication step, in [s].
        failure: Error at the next step, or empty.
    """

    names: list[str]
    rows: FloatArray
    step: float
    failure: str


def related_files(model_name: str, results: ReferenceResults) -> dict[str, bytes]:
    """Return the table of reference results and its manifest, by path in the FMU."""
    ET.register_namespace("fmi-ls", _SPACE)
    root = ET.Element("fmiReferences", {f"{{{_SPACE}}}{key}": text for key, text in _ABOUT.items()})
    file = f"{model_name}_ref.csv"
    content = (
        "Outputs at the communication points of a simulation from 0 s with constant inputs and "
        f"parameters, their start values, and steps of {results.step!r} s"
    )
    if results.failure:
        content += f"; the next step fails: {results.failure}"
    ET.SubElement(root, "Related", type="text/csv", source=file, role="result", description=content)
    return {
        f"{FOLDER}/fmi-ls-manifest.xml": xml_bytes(root),
        f"{FOLDER}/{file}": csv_text(results.names, results.rows).encode(),
    }
