from __future__ import annotations

import json
import math
import struct
from typing import Any

import pytest
import trimesh

from addin_sdfusion.robot import limits
from addin_sdfusion.robot.mesh_content import mesh_problem

BOX = trimesh.creation.box((0.1, 0.2, 0.3))
FORMS = [
    (".stl", "stl"),
    (".STL", "stl_ascii"),
    (".obj", "obj"),
    (".ply", "ply"),
    (".glb", "glb"),
    (".off", "off"),
]
COLLADA = """<?xml version="1.0"?>{}<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema">
<library_geometries><geometry><mesh>{}</mesh></geometry></library_geometries></COLLADA>"""
PRIVATE = b"root:x:0:0:root:/root:/bin/bash\nPASSWORD=v 1 2 3\n"


def exported(form: str) -> bytes:
    data = BOX.export(file_type=form)
    return data.encode() if isinstance(data, str) else data


@pytest.mark.parametrize(("suffix", "form"), FORMS)
def test_output_of_trimesh_is_a_mesh(suffix: str, form: str) -> None:
    assert mesh_problem(suffix, exported(form)) is None


def test_collada_and_embedded_gltf_files_are_meshes() -> None:
    assert mesh_problem(".dae", COLLADA.format("", "<triangles/>").encode()) is None
    scene = {"asset": {"version": "2.0"}, "meshes": [{}], "buffers": [{"uri": "data:,"}]}
    assert mesh_problem(".gltf", json.dumps(scene).encode()) is None


@pytest.mark.parametrize("suffix", [".stl", ".obj", ".ply", ".glb", ".gltf", ".off", ".dae"])
@pytest.mark.parametrize("data", [b"", b"\0" * 200, PRIVATE, b"\xff" * 84, b"solid \n" + PRIVATE])
def test_other_content_is_rejected(suffix: str, data: bytes) -> None:
    problem = mesh_problem(suffix, data)
    assert problem is not None
    assert "PASSWORD" not in problem


@pytest.mark.parametrize("suffix", ["", ".txt", ".zip", ".3mf", ".pem", ".npz"])
def test_other_file_names_are_rejected(suffix: str) -> None:
    assert "is not a mesh type" in str(mesh_problem(suffix, exported("stl")))


@pytest.mark.parametrize("part", ["buffers", "images"])
@pytest.mark.parametrize("uri", ["../../secret.bin", "http://example.org/x", "file:///etc/passwd"])
def test_mesh_that_needs_other_files_is_rejected(part: str, uri: str) -> None:
    scene = {"asset": {"version": "2.0"}, "meshes": [{}], part: [{"uri": uri}]}
    assert "requires another file" in str(mesh_problem(".gltf", json.dumps(scene).encode()))


@pytest.mark.parametrize(
    "doctype",
    [
        '<!DOCTYPE a [<!ENTITY e SYSTEM "file:///etc/passwd">]>',
        '<!DOCTYPE a [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;">]>',
    ],
)
def test_xml_entities_are_rejected(doctype: str) -> None:
    data = COLLADA.format(doctype, "<triangles/>").encode()
    assert "entities" in str(mesh_problem(".dae", data))


def _binary_stl(*corners: float, facets: int = 1) -> bytes:
    one = struct.pack("<12fH", math.nan, 0.0, 1.0, *corners, 0)  # normals may be invalid
    return b"\0" * 80 + struct.pack("<I", facets) + one


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("k", range(9))
def test_non_finite_vertices_are_rejected(bad: float, k: int) -> None:
    corners = [1e30, 0.0, 0.0, -1.0, 2.0, 0.0, 1e-40, 1.0, -1e37]
    assert mesh_problem(".stl", _binary_stl(*corners)) is None
    corners[k] = bad
    assert mesh_problem(".stl", _binary_stl(*corners)) == ("it has vertices that are not finite")


@pytest.mark.parametrize(
    ("suffix", "text"),
    [
        (".obj", "o infinite_nanny\nv 0 {} 0\nv 1 0 0\nv 0 1 0\nvn nan 0 0\nf 1 2 3\n"),
        (
            ".stl",
            "solid inf\nfacet normal nan 0 1\nouter loop\nvertex 0 0 {}\nvertex 1 0 0\n"
            "vertex 0 1 0\nendloop\nendfacet\nendsolid inf\n",
        ),
    ],
)
def test_non_finite_vertices_in_text_are_rejected(suffix: str, text: str) -> None:
    assert mesh_problem(suffix, text.format("1e-3").encode()) is None
    for bad in ("nan", "-inf", "NaN"):
        problem = mesh_problem(suffix, text.format(bad).encode())
        assert problem == "it has vertices that are not finite"


def test_truncated_binary_stl_reports_its_size() -> None:
    problem = mesh_problem(".stl", _binary_stl(*range(9), facets=100))
    assert problem == "it is not a .stl mesh: its header specifies 100 facets, but it contains 1"


def gltf(nodes: list[dict[str, Any]], **changes: Any) -> bytes:
    """Return a triangle placed by nodes, with other parts of the scene in `parts`."""
    parts = {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "nodes": nodes,
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [{"bufferView": 0, "count": 3, "type": "VEC3"}],
    }
    return json.dumps(parts | changes).encode()


TRIANGLE = {"attributes": {"POSITION": 0}}
FLAT = [{"mesh": 0}] * (limits.MESH_NODES + 1)
DEEP = [{"children": [k + 1]} for k in range(limits.MESH_DEPTH + 1)]


@pytest.mark.parametrize(
    ("data", "reason"),
    [
        (gltf([{"mesh": 0}]), None),
        (gltf([*DEEP[:-2], {"mesh": 0}]), None),
        (gltf([*DEEP, {"mesh": 0}]), "nested ones"),
        (gltf([{"children": [1]}, {"children": [0]}]), "nested ones"),
        (gltf(FLAT), "nodes"),
        (gltf([{"mesh": 0}], scenes=[{"nodes": [0] * len(FLAT)}]), "parts"),
        (gltf([{"mesh": 0}], meshes=[{"primitives": [TRIANGLE] * len(FLAT)}]), "parts"),
        (gltf([{"mesh": 0}], accessors=[{"bufferView": 0, "count": -1}]), "an invalid count"),
    ],
)
def test_small_gltf_scene_does_not_expand(data: bytes, reason: str | None) -> None:
    """Trimesh takes minutes for 400000 nodes in a file of 6 MB."""
    problem = mesh_problem(".gltf", data)
    assert problem is None if reason is None else reason in str(problem)


def collada(nodes: str, library: str = "", faces: int = 1) -> bytes:
    triangles = "<triangles><p>0 1 2</p></triangles>" * faces
    return (
        f"<COLLADA><library_nodes>{library}</library_nodes><library_geometries>"
        f"<geometry id='g'><mesh>{triangles}</mesh></geometry></library_geometries>"
        f"<library_visual_scenes><visual_scene id='s'>{nodes}</visual_scene>"
        "</library_visual_scenes></COLLADA>"
    ).encode()


PLACED = "<instance_geometry url='#g'/>"


def layers(count: int, each: int) -> str:
    """Return nodes in layers, each node with `count` references to the next layer."""
    placed = [f"<instance_node url='#n{k + 1}'/>" * each for k in range(count)]
    nodes = [f"<node id='n{k}'>{inner}</node>" for k, inner in enumerate([*placed, PLACED])]
    return "".join(nodes)


@pytest.mark.parametrize(
    ("data", "reason"),
    [
        (collada(f"<node>{PLACED * 3}</node>"), None),
        (collada("<node><instance_node url='#n0'/></node>", layers(3, 10)), None),
        (collada("<node><instance_node url='#n0'/></node>", layers(30, 30)), "parts"),
        (collada(f"<node>{PLACED * 60}</node>", faces=100), "parts"),
        (collada(f"<node>{PLACED * 2000}</node>").replace(b"0 1 2", b"1 " * 4000), "numbers"),
        (collada("<node id='a'><instance_node url='#a'/></node>"), "deep"),
        (collada("<node>" * 60 + PLACED + "</node>" * 60), "deep"),
    ],
)  # fmt: skip
def test_small_collada_scene_does_not_expand(data: bytes, reason: str | None) -> None:
    """Nested references multiply: 30 layers of 30 nodes would not end."""
    problem = mesh_problem(".dae", data)
    assert problem is None if reason is None else reason in str(problem)


@pytest.mark.parametrize(
    ("suffix", "part", "end"),
    [
        (".stl", b"solid a\nvertex 0 0 0\nendsolid a\n", b""),
        (".obj", b"o a\n", b"v 0 0 0\nf 1 1 1\n"),
        (".obj", b"usemtl a\n", b"v 0 0 0\nf 1 1 1\n"),
    ],
)
def test_text_with_too_many_parts_is_rejected(suffix: str, part: bytes, end: bytes) -> None:
    assert mesh_problem(suffix, limits.MESH_NODES * part + end) is None
    problem = mesh_problem(suffix, (limits.MESH_NODES + 1) * part + end)
    assert problem == f"it has more than {limits.MESH_NODES} parts"
