from __future__ import annotations

import json
import math
import struct

import pytest
import trimesh

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
def test_what_trimesh_writes_is_a_mesh(suffix: str, form: str) -> None:
    assert mesh_problem(suffix, exported(form)) is None


def test_a_collada_file_and_a_whole_gltf_are_meshes() -> None:
    assert mesh_problem(".dae", COLLADA.format("", "<triangles/>").encode()) is None
    scene = {"asset": {"version": "2.0"}, "meshes": [{}], "buffers": [{"uri": "data:,"}]}
    assert mesh_problem(".gltf", json.dumps(scene).encode()) is None


@pytest.mark.parametrize("suffix", [".stl", ".obj", ".ply", ".glb", ".gltf", ".off", ".dae"])
@pytest.mark.parametrize("data", [b"", b"\0" * 200, PRIVATE, b"\xff" * 84, b"solid \n" + PRIVATE])
def test_other_content_is_no_mesh(suffix: str, data: bytes) -> None:
    problem = mesh_problem(suffix, data)
    assert problem is not None
    assert "PASSWORD" not in problem


@pytest.mark.parametrize("suffix", ["", ".txt", ".zip", ".3mf", ".pem", ".npz"])
def test_other_names_are_no_meshes(suffix: str) -> None:
    assert "is no type of meshes" in str(mesh_problem(suffix, exported("stl")))


@pytest.mark.parametrize("part", ["buffers", "images"])
@pytest.mark.parametrize("uri", ["../../secret.bin", "http://example.org/x", "file:///etc/passwd"])
def test_a_mesh_that_needs_other_files_is_refused(part: str, uri: str) -> None:
    scene = {"asset": {"version": "2.0"}, "meshes": [{}], part: [{"uri": uri}]}
    assert "needs another file" in str(mesh_problem(".gltf", json.dumps(scene).encode()))


@pytest.mark.parametrize(
    "doctype",
    [
        '<!DOCTYPE a [<!ENTITY e SYSTEM "file:///etc/passwd">]>',
        '<!DOCTYPE a [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;">]>',
    ],
)
def test_xml_entities_are_refused(doctype: str) -> None:
    data = COLLADA.format(doctype, "<triangles/>").encode()
    assert "entities" in str(mesh_problem(".dae", data))


def _binary_stl(*corners: float, facets: int = 1) -> bytes:
    one = struct.pack("<12fH", math.nan, 0.0, 1.0, *corners, 0)  # a normal that is none is common
    return b"\0" * 80 + struct.pack("<I", facets) + one


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("k", range(9))
def test_corners_that_are_no_numbers_are_refused(bad: float, k: int) -> None:
    corners = [1e30, 0.0, 0.0, -1.0, 2.0, 0.0, 1e-40, 1.0, -1e37]
    assert mesh_problem(".stl", _binary_stl(*corners)) is None
    corners[k] = bad
    assert mesh_problem(".stl", _binary_stl(*corners)) == (
        "it has corners that are no finite numbers"
    )


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
def test_corners_that_are_no_numbers_are_refused_in_text(suffix: str, text: str) -> None:
    assert mesh_problem(suffix, text.format("1e-3").encode()) is None
    for bad in ("nan", "-inf", "NaN"):
        problem = mesh_problem(suffix, text.format(bad).encode())
        assert problem == "it has corners that are no finite numbers"


def test_a_binary_stl_that_ends_early_says_how_much_is_there() -> None:
    problem = mesh_problem(".stl", _binary_stl(*range(9), facets=100))
    assert problem == "it is no mesh of type .stl: its head says 100 facets, and 1 are there"
