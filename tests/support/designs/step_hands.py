"""STEP file with an assembly, and its tables."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from scipy.spatial.transform import Rotation

from cardsflow_fmu.cad.kernel import kernel

TURNS = {
    "hand": ((100.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
    "twin": ((-100.0, 50.0, 0.0), (0.4, -1.1, 2.0)),
    "index": ((10.0, 0.0, 30.0), (0.5, 0.0, 0.0)),
    "thumb": ((0.0, 5.0, 30.0), (0.3, -0.7, 0.2)),
    "foot": ((0.0, 0.0, -50.0), (0.0, 0.0, 0.0)),
}
"""Translation in [mm] and rotation vector of every occurrence."""


def location(place: str) -> Any:
    t, turn = TURNS[place]
    gp = kernel("gp")
    trsf, x = gp.gp_Trsf(), Rotation.from_rotvec(turn).as_quat()
    trsf.SetTransformation(gp.gp_Quaternion(*map(float, x)), gp.gp_Vec(*t))
    return kernel("TopLoc").TopLoc_Location(trsf)


def text(name: str) -> Any:
    return kernel("TCollection").TCollection_ExtendedString(name, True)


def write_hands(file: Path) -> None:
    """Write two hands of a palm and two fingers each, and a foot that is another palm."""
    document = kernel("TDocStd").TDocStd_Document(text("XDE"))
    tools = kernel("XCAFDoc").XCAFDoc_DocumentTool
    shapes, colors = tools.ShapeTool_s(document.Main()), tools.ColorTool_s(document.Main())
    make = kernel("BRepPrimAPI")

    def named(label: Any, name: str) -> Any:
        kernel("TDataStd").TDataStd_Name.Set_s(label, text(name))
        return label

    root, hand = named(shapes.NewShape(), "robot"), named(shapes.NewShape(), "händ")
    palm = named(shapes.AddShape(make.BRepPrimAPI_MakeBox(10.0, 20.0, 30.0).Shape(), False), "palm")
    finger = make.BRepPrimAPI_MakeCylinder(5.0, 40.0).Shape()
    finger = named(shapes.AddShape(finger, False), "finger")
    colour = kernel("Quantity")
    red = colour.Quantity_Color(1.0, 0.5, 0.0, colour.Quantity_TypeOfColor.Quantity_TOC_sRGB)
    colors.SetColor(finger, red, kernel("XCAFDoc").XCAFDoc_ColorType.XCAFDoc_ColorSurf)
    shapes.AddComponent(hand, palm, kernel("TopLoc").TopLoc_Location())
    for place in ("index", "thumb"):
        named(shapes.AddComponent(hand, finger, location(place)), place)
    for place in ("hand", "twin"):
        shapes.AddComponent(root, hand, location(place))
    shapes.AddComponent(root, palm, location("foot"))
    shapes.UpdateAssemblies()
    writer = kernel("STEPCAFControl").STEPCAFControl_Writer()
    writer.Transfer(document, kernel("STEPControl").STEPControl_StepModelType.STEPControl_AsIs)
    writer.Write(str(file))


JOINTS = """name,type,parent,child,x [mm],y [mm],z [mm],axis x,axis y,axis z,lower,upper,damping,\
velocity
base,fixed,world,palm:1,,,,,,,,,,
wrist,revolute,palm:1,händ,10,0,5,0,1,0,-90 deg,90 deg,0.1,180 deg/s
curl,revolute,händ:1+palm:1,händ:1+finger:1,0,0,0,1,0,0,,,,30 rpm
slip,slider,palm:1,händ_2,,,,0,0,1,-5 mm,5 mm,,20 mm/s
"""
MUSCLES = """role,name,number,link,x [mm],y [mm],z [mm],f_min,f_max
via,m,0,palm,0,0,0,5,50
via,m,1,finger,110,0,40,,
task,tip,,finger,120,0,60,,
"""
WRAPS = """name,part,x [mm],y [mm],z [mm],muscle,after,side,turns,inside
knuckle,händ:1+finger:1,113.5,3.2,47.6,m,0,+,1,
"""
MATERIALS = """part,material,density [kg/m3],mass
world,steel,7850,
händ:1+finger:2,,,20 g
"""
