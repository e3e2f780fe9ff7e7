"""Valid files of robots and meshes in a folder."""

from __future__ import annotations

import contextlib
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

from addin_sdfusion.robot import (
    CardsflowError,
    read_robot,
    write_sdf,
)
from addin_sdfusion.robot.formats.convert import convert
from addin_sdfusion.robot.formats.urdf.write import write_urdf

from ..robots.robots import EXAMPLES, PLANAR_2R
from ..third_party_models import INCLUDED, MJCF, OPTIONS, OSIM


def mesh(suffix: str) -> Callable[[Path], None]:
    def make(folder: Path) -> None:
        import trimesh

        robot = (EXAMPLES / "pick_up/robot/model.sdf").read_text()
        (folder / "meshes").mkdir()
        (folder / "model.sdf").write_text(robot.replace("pad.stl", f"pad{suffix}"))
        if suffix == ".stl":
            data: Any = trimesh.creation.box((0.1, 0.1, 0.1)).export(file_type="stl_ascii")
        elif suffix == ".dae":
            data = _COLLADA
        else:
            data = trimesh.creation.box((0.1, 0.1, 0.1)).export(file_type=suffix[1:])
        (folder / "meshes" / f"pad{suffix}").write_bytes(
            data if isinstance(data, bytes) else data.encode()
        )

    return make


_COLLADA = """<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit meter="0.001" name="millimeter"/><up_axis>Z_UP</up_axis></asset>
<library_geometries><geometry id="g" name="g"><mesh>
<source id="p"><float_array id="pa" count="12">0 0 0 1 0 0 0 1 0 0 0 1</float_array>
<technique_common><accessor source="#pa" count="4" stride="3"><param name="X" type="float"/>
<param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="4"><input semantic="VERTEX" source="#v" offset="0"/>
<p>0 2 1 0 1 3 1 2 3 2 0 3</p></triangles></mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node id="n"><matrix>1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1
</matrix><instance_geometry url="#g"/></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>
"""


def read_hull(folder: Path) -> None:
    """Read the meshes of a world like the engine."""
    from sim_dart.dart.meshes import convex_hull

    for file in sorted((folder / "meshes").iterdir()):
        with contextlib.suppress(CardsflowError):
            convex_hull(file)


def gltf(folder: Path) -> None:
    """Write a glTF scene with positions and indices in a second file."""
    import trimesh

    mesh(".glb")(folder)
    (folder / "meshes/pad.glb").unlink()
    robot = folder / "model.sdf"
    robot.write_text(robot.read_text().replace("pad.glb", "pad.gltf"))
    scene = trimesh.Scene(trimesh.creation.box((0.1, 0.1, 0.1)))
    files = trimesh.exchange.gltf.export_gltf(scene)
    for name, content in files.items():
        (folder / "meshes" / name.replace("model.gltf", "pad.gltf")).write_bytes(content)


def sdf(folder: Path) -> None:
    write_sdf(read_robot(PLANAR_2R / "robot"), folder)


def robot_of(name: str) -> Callable[[Path], None]:
    def make(folder: Path) -> None:
        shutil.copytree(EXAMPLES / name / "robot", folder, dirs_exist_ok=True)

    return make


def urdf(folder: Path) -> None:
    write_urdf(read_robot(PLANAR_2R / "robot"), folder)


def table(folder: Path) -> None:
    """Write a robot with a muscle table next to it."""
    robot = read_robot(EXAMPLES / "hill_arm/robot")
    write_urdf(robot.with_muscles(()), folder)
    convert(robot, "muscles.csv", folder)


def osim(folder: Path) -> None:
    (folder / "leg.osim").write_text(OSIM)


def mjcf(folder: Path) -> None:
    """Write a model of three files."""
    for name, text in (("model", MJCF), ("arm", INCLUDED), ("options", OPTIONS)):
        (folder / f"{name}.xml").write_text(text)


def step_file(folder: Path) -> None:
    from ..designs.step_hands import JOINTS, MATERIALS, MUSCLES, WRAPS, write_hands

    write_hands(folder / "hands.step")
    tables = {"joints": JOINTS, "muscles": MUSCLES, "materials": MATERIALS, "wraps": WRAPS}
    for name, text in tables.items():
        (folder / f"{name}.csv").write_text(text, encoding="utf-8")


def snapshot(folder: Path) -> None:
    shutil.copy(EXAMPLES / "from_cad/two_link_arm.json", folder / "design.json")
