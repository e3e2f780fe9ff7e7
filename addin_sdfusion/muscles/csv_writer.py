"""Writer for muscle tables in CSV files, for spreadsheets.

Each line contains a point. The line of the first point of a muscle also contains the properties of
the muscle. A muscle without points has a separate line. Positions are in the root frame of the
design. Wrap surfaces are not written, since they are faces of the design.
"""

from __future__ import annotations

import csv
import io

from .csv_reader import COLUMNS
from .table import MuscleTable


def csv_text(table: MuscleTable, delimiter: str = ",") -> str:
    """Return the text of a file with all muscles, task points and markers.

    Args:
        delimiter: Delimiter between cells; a tab for the clipboard.
    """
    stream = io.StringIO()
    # the default line ending is that of RFC 4180
    writer = csv.writer(stream, lineterminator="\r\n", delimiter=delimiter)
    writer.writerow(COLUMNS)
    for row in table.rows:
        points = [p for p in table.points_of(row.name) if not p.lost]
        parameters = " ".join(f"{name}={value!r}" for name, value in row.parameters.items())
        muscle = (row.color, repr(row.f_min), repr(row.f_max), row.model, parameters)
        if not points:
            writer.writerow(("via", row.name, "", "", "", "", "", *muscle, ""))
        for i, p in enumerate(points):
            end = muscle if i == 0 else ("",) * len(muscle)
            writer.writerow(("via", row.name, p.number, p.link, *map(repr, p.position), *end, ""))
    for p in (p for p in table.others if not p.lost):
        where = (p.link, *map(repr, p.position))
        writer.writerow((p.role, p.name, "", *where, *[""] * 5, " ".join(p.axes)))
    return stream.getvalue()
