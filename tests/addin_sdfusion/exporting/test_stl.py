from __future__ import annotations

import io
import struct
from array import array

import numpy as np
import pytest
import trimesh

from addin_sdfusion.exporting.stl import HEADER, stl_bytes
from addin_sdfusion.robot import InputError


def written(mesh):
    data = stl_bytes(array("d", mesh.vertices.ravel()), array("i", mesh.faces.ravel().tolist()))
    return trimesh.load(io.BytesIO(data), file_type="stl")


@pytest.mark.parametrize(
    "mesh",
    [
        trimesh.creation.box(extents=(0.1, 0.2, 0.3)),
        trimesh.creation.icosphere(subdivisions=3, radius=0.05),
        trimesh.creation.annulus(0.01, 0.02, 0.5),
    ],
    ids=["box", "sphere", "tube"],
)
def test_another_program_reads_the_same_body(mesh):
    again = written(mesh)
    assert again.is_watertight
    assert again.is_winding_consistent
    assert again.volume == pytest.approx(mesh.volume, rel=1e-6)
    np.testing.assert_allclose(again.bounds, mesh.bounds, rtol=6e-8)
    np.testing.assert_allclose(
        sorted(again.area_faces), sorted(mesh.area_faces), rtol=1e-4, atol=1e-12
    )


def test_normals_point_outside():
    data = stl_bytes([0.0, 0, 0, 1, 0, 0, 0, 1, 0], [0, 1, 2])
    assert struct.unpack_from("<3f", data, 84) == (0.0, 0.0, 1.0)


def test_coordinates_are_the_nearest_floats_of_32_bits():
    third = 1 / 3
    data = stl_bytes([third, 0, 0, 1, 0, 0, 0, 1, 0], [0, 1, 2])
    assert struct.unpack_from("<f", data, 84 + 12)[0] == float(np.float32(third))


def test_collapsed_triangles_are_not_written_and_the_surface_stays_closed():
    sphere = trimesh.creation.icosphere(subdivisions=2)
    near = sphere.vertices.copy()
    a, b = sphere.edges_unique[0]
    near[a] = near[b] * (1 + 1e-12)  # one edge has zero length in 32-bit floats
    mesh = trimesh.Trimesh(near, sphere.faces, process=False)
    again = written(mesh)
    assert len(again.faces) == len(sphere.faces) - 2
    assert again.is_watertight


def test_a_degenerate_triangle_between_others_has_a_zero_normal():
    data = stl_bytes([0.0, 0, 0, 1, 0, 0, 2, 0, 0], [0, 1, 2])
    assert struct.unpack_from("<I3f", data, 80) == (1, 0.0, 0.0, 0.0)


def test_header_has_no_date_and_differs_from_ascii_stl():
    assert len(HEADER) == 80
    assert not HEADER.startswith(b"solid")
    assert stl_bytes([], []) == HEADER + bytes(4)


def test_meshes_beyond_32_bit_floats_are_rejected():
    with pytest.raises(InputError, match="exceeds the range"):
        stl_bytes([1e39, 0, 0, 1, 0, 0, 0, 1, 0], [0, 1, 2])
