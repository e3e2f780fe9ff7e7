"""Checks of surfaces, wraps and pulleys of blobs in the C core."""

from __future__ import annotations

import numpy as np
import pytest
from support.robots.wrapped import base_pulley, carriage

from addin_sdfusion.robot import WORLD, CardsflowError, Muscle, ViaPoint, Wrap, WrapSurface
from sim_dart.core.blob import compile_blob
from sim_dart.core.library import Core, library, pack_blob

pytestmark = pytest.mark.native


def valid_blob() -> tuple[dict[str, int], dict[str, object]]:
    """Return two muscles over a cylinder; the first also has a pulley and a sphere."""
    names = [line.split() for line in library().core_layout().decode().splitlines()]
    counts = {words[1]: 0 for words in names if words[0] == "count"}
    counts |= {
        "muscles": 2,
        "points": 4,
        "surfaces": 3,
        "wraps": 3,
        "pulleys": 1,
        "bends": 3,
        "robots": 1,
    }
    fields: dict[str, object] = {words[1]: [] for words in names if words[0] in ("real", "int32_t")}
    fields |= {
        "gravity": [0, 0, -9.81],
        "muscle_points": [2, 2],
        "muscle_bends": [3, 0],
        "bend_friction": [0.1, 0, 0.2],
        "presliding": [1, 1],
        "point_frame": [-1] * 4,
        "point_position": np.eye(4, 3),
        "law_kind": [0, 0],
        "surface_kind": [0, 1, 2],
        "surface_frame": [-1, -1, -1],
        "surface_centre": np.zeros((3, 3)),
        "surface_axis": [[0, 0, 1], [0, 1, 0], [0, 1, 0]],
        "surface_across": [[1, 0, 0], [1, 0, 0], [0, 0, 1]],
        "surface_radius": [0.1, 0.2, 0.3],
        "surface_half_axes": [[0, 0], [0, 0], [0.2, 0.1]],
        "surface_half": [0.0, 0.3, 0.0],
        "wrap_point": [0, 0, 2],
        "wrap_surface": [0, 1, 1],
        "wrap_side": [0, 1, -1],
        "wrap_turns": [0, 1, 2],
        "wrap_last": [0, 0, 2],
        "wrap_rule": [0, 0, 0],
        "wrap_guide": [-1, -1, -1],
        "pulley_point": [0],
        "pulley_direction": [[1, 0, 0]],
        "pulley_radius": [0.05],
    }
    return counts, fields


@pytest.mark.parametrize(
    ("field", "value", "message"),
    [
        ("surface_kind", [0, 3, 2], "surface 1: unknown kind 3"),
        ("surface_kind", [0, 0, 2], "surface 1: only a cylinder has ends"),
        ("surface_frame", [-1, 0, -1], "surface 1: unknown frame 0"),
        (
            "surface_centre",
            [[0, 0, 0], [0, np.nan, 0], [0, 0, 0]],
            "surface 1: its position",
        ),
        (
            "surface_axis",
            [[0, 0, 1], [0, 1, 1], [0, 1, 0]],
            "surface 1: its axis is no",
        ),
        (
            "surface_axis",
            [[0, 0, np.nan], [0, 1, 0], [0, 1, 0]],
            "surface 0: its axis is no",
        ),
        ("surface_radius", [0.0, 0.2, 0.3], "surface 0: its size"),
        ("surface_radius", [0.1, np.inf, 0.3], "surface 1: its size"),
        ("surface_half", [0.0, -1.0, 0.0], "surface 1: its size"),
        ("surface_half", [0.0, np.nan, 0.0], "surface 1: its size"),
        ("surface_half", [0.0, 0.3, 0.1], "surface 2: only a cylinder has ends"),
        ("surface_half_axes", [[0.1, 0.1], [0, 0], [0.2, 0.1]], "surface 0: only an ellipsoid"),
        ("surface_half_axes", [[0, 0], [0, 0], [0.0, 0.1]], "surface 2: its half axes"),
        ("surface_half_axes", [[0, 0], [0, 0], [0.2, -0.1]], "surface 2: its half axes"),
        ("surface_half_axes", [[0, 0], [0, 0], [np.nan, 0.1]], "surface 2: its half axes"),
        ("surface_half_axes", [[0, 0], [0, 0], [0.2, np.inf]], "surface 2: its half axes"),
        (
            "surface_half_axes",
            [[0, 0], [0, 0], [0.2, 0.029]],
            "surface 2: .* half axes is more than 10",
        ),
        ("surface_across", [[1, 0, 0], [1, 0, 0], [0, 0, 2]], "surface 2: its x axis"),
        ("surface_across", [[1, 0, 0], [1, 0, 0], [0, 1, 0]], "surface 2: its x axis"),
        ("surface_across", [[1, 0, 0], [1, 0, 0], [0, 0, np.nan]], "surface 2: its x axis"),
        ("wrap_surface", [0, 2, 1], "wrap 1: an ellipsoid has no side"),
        ("wrap_point", [0, 0, 3], "wrap 2: no segment begins at via point 3"),
        ("wrap_point", [-1, 0, 2], "wrap 0: no segment begins at via point -1"),
        ("wrap_rule", [0, 3, 0], "wrap 1: unknown rule 3"),
        ("wrap_last", [0, 1, 2], "wrap 1: it cannot end at via point 1"),
        ("wrap_guide", [-1, -1, 0], "wrap 2: unknown guide 0"),
        ("wrap_point", [0, 1, 2], "wrap 1: via point 1 is the muscle's last"),
        ("wrap_point", [0, 2, 0], "wrap 2 is out of order"),
        ("wrap_surface", [0, 1, 3], "wrap 2: unknown surface 3"),
        ("wrap_surface", [0, -1, 1], "wrap 1: unknown surface -1"),
        ("wrap_side", [0, 3, 1], "wrap 1: unknown side 3"),
        ("wrap_turns", [0, -1, 0], "wrap 1: turns -1"),
        ("wrap_side", [0, 2, 1], "wrap 1: no turns inside a surface"),
        ("muscle_bends", [2, 0], "muscle 0: its cable does not have 2 bends"),
        ("muscle_bends", [-1, 4], "muscle 0: its cable does not have -1 bends"),
        ("muscle_bends", [3, 1], "bends of muscles do not add up"),
        ("muscle_bends", [0, 1], "bends of muscles do not add up"),
        ("bend_friction", [0.1, -0.1, 0], "muscle 0: its friction"),
        ("bend_friction", [0.1, 0, np.nan], "muscle 0: its friction"),
        ("bend_friction", [2.5, 0, 0], "muscle 0: its friction"),
        ("pulley_point", [1], "pulley 0: no muscle begins at via point 1"),
        ("pulley_point", [4], "pulley 0: no muscle begins at via point 4"),
        ("pulley_point", [-1], "pulley 0: no muscle begins at via point -1"),
        ("pulley_direction", [[1, 1, 0]], "pulley 0: its direction is not a unit vector"),
        ("pulley_radius", [0.0], "pulley 0: its radius"),
    ],
)
def test_invalid_field_is_named(field: str, value: object, message: str) -> None:
    counts, fields = valid_blob()
    Core(pack_blob(counts, fields))  # type: ignore[arg-type]
    with pytest.raises(CardsflowError, match=message):
        also = {"wrap_last": value} if field == "wrap_point" else {}
        Core(pack_blob(counts, fields | also | {field: value}))  # type: ignore[arg-type]


def test_too_many_surfaces_in_a_segment_are_rejected() -> None:
    counts, fields = valid_blob()
    counts |= {"wraps": 9}
    fields |= {"wrap_point": [0] * 9, "wrap_surface": [0] * 9}
    fields |= {"wrap_side": [0] * 9, "wrap_turns": [0] * 9, "wrap_last": [0] * 9}
    fields |= {"wrap_rule": [0] * 9, "wrap_guide": [-1] * 9}
    with pytest.raises(CardsflowError, match="wrap 8: more than 8 in one segment"):
        Core(pack_blob(counts, fields))  # type: ignore[arg-type]


def test_largest_number_of_surfaces_in_a_segment_is_solved() -> None:
    """The surfaces are after a pulley, and all at the same position."""
    ends = (ViaPoint(WORLD, (1.0, 0.0, 0.0)), ViaPoint("link_2", (-1.0, 0.01, 0.2)))
    for shape in ("sphere", "cylinder"):
        wraps = tuple(Wrap("round", 0) for _ in range(8))
        muscle = Muscle("m", ends, pulley=base_pulley(0.1, (0, 1, 0)), wraps=wraps)
        robot = carriage([muscle], [WrapSurface("round", WORLD, shape, 0.3)])  # type: ignore[arg-type]
        core = Core(compile_blob(robot))
        core.move(core.handle, np.zeros(3).tobytes())
        core.trace(core.handle)
        assert np.isfinite(core.array("lengths", 1)).all()
        assert np.isfinite(core.array("jacobian", 1, 3)).all()


@pytest.mark.parametrize("size", [1e300, 1e-300])
def test_search_terminates_for_extreme_positions(size: float) -> None:
    """Numbers can overflow, but reads stay within bounds and the search terminates."""
    counts, fields = valid_blob()
    fields["point_position"] = size * np.arange(12.0).reshape(4, 3)
    core = Core(pack_blob(counts, fields))  # type: ignore[arg-type]
    for _ in range(3):
        core.move(core.handle, b"")
        core.trace(core.handle)
