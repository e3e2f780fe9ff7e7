"""Skeleton of an adapter: a macro that writes the snapshot of a FreeCAD assembly, next to it."""

import json
from pathlib import Path

import FreeCAD

MM, DENSITY = 0.001, 2700.0  # unit of lengths in FreeCAD, in m; density of all parts, in kg/m³
document = FreeCAD.ActiveDocument


def vector(v, unit=MM):
    """Return a vector of FreeCAD as numbers."""
    return [unit * v.x, unit * v.y, unit * v.z]


occurrences, bodies = [], []
for part in document.findObjects("App::Part"):
    path = f"{part.Label}:1"
    occurrences.append({"path": path, "parent": "", "component": part.Label})
    for body in part.Group:
        shape = body.Shape.copy()
        shape.Placement = part.getGlobalPlacement() * body.Placement  # into the root frame
        m, c, J = DENSITY * MM**3 * shape.Volume, shape.CenterOfGravity, shape.MatrixOfInertia
        x, y, z = vector(c)
        k = DENSITY * MM**5  # the matrix is about the centre of mass
        moments = [
            k * J.A11 + m * (y * y + z * z),
            k * J.A22 + m * (x * x + z * z),
            k * J.A33 + m * (x * x + y * y),
            k * J.A12 - m * x * y,
            k * J.A23 - m * y * z,
            k * J.A13 - m * x * z,
        ]
        principal = [k * v for v in shape.PrincipalProperties["Moments"]]
        mass = {"mass": m, "com": [x, y, z], "moments": moments, "principal": principal}
        bodies.append({"name": body.Label, "occurrence": path, "mass": mass})

# Fill in joints, points and muscles of your assembly; docs/reference/snapshot.md lists the keys.
joints, points, muscles = [], [], []

design = {
    "name": document.Label,
    "source": {"program": "FreeCAD", "version": ".".join(FreeCAD.Version()[:3])},
    "occurrences": occurrences,
    "bodies": bodies,
    "joints": joints,
    "points": points,
    "muscles": muscles,
}
text = json.dumps({"format": 2, "design": design})
(Path(document.FileName).parent / "design.json").write_text(text)
