"""Writer of the table of muscles as a CSV file, for spreadsheets.

One line a point. What belongs to the muscle is in the line of its first point; a muscle without
points has a line of its own. Positions are in the design's root frame. Wrap surfaces are faces and
not in the file.
"""

from __future__ import annotations

import csv
import io

from ..snapshot import MuscleSnapshot
from .csv_reader import COLUMNS
from .table import MuscleTable


def csv_text(table: MuscleTable, delimiter: str = ",") -> str:
    """Return the text of a file with all muscles, task points and markers.

    Args:
        table: The table.
        delimiter: Between cells: a tab for the clipboard.
    """
    stream = io.StringIO()
    # lines end as RFC 4180 and spreadsheets have it
    writer = csv.writer(stream, lineterminator="\r\n", delimiter=delimiter)
    writer.writerow(COLUMNS)
    for row in table.rows:
        points = table.points_of(row.name)
        muscle = (row.color, repr(row.f_min), repr(row.f_max), row.model, _parameters(row))
        if not points:
            writer.writerow(("via", row.name, "", "", "", "", "", *muscle, ""))
        for i, p in enumerate(points):
            end = muscle if i == 0 else ("",) * len(muscle)
            writer.writerow(("via", row.name, p.number, p.link, *map(repr, p.position), *end, ""))
    for p in table.others:
        where = (p.link, *map(repr, p.position))
        writer.writerow((p.role, p.name, "", *where, *[""] * 5, " ".join(p.axes)))
    return stream.getvalue()


def _parameters(row: MuscleSnapshot) -> str:
    return " ".join(f"{name}={value!r}" for name, value in row.parameters.items())
