"""Self-contained HTML page in which a user adds and changes the muscles of a robot."""

from __future__ import annotations

import base64
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from addin_sdfusion.muscles.mirror import other_side
from addin_sdfusion.robot import Robot
from cardsflow_fmu.results.viewer.scene.act import Act
from cardsflow_fmu.results.viewer.scene.link_poses import coordinate_axes
from cardsflow_fmu.results.viewer.scene.meshes import link_meshes
from cardsflow_fmu.results.viewer.scene.motion import Motion
from cardsflow_fmu.results.viewer.scene.stage import Stage
from cardsflow_fmu.utils.arrays import FloatArray

from .page import EDITING_SCRIPTS, SHARED_SCRIPTS, data_json, page_with, strict_script
from .page_data import encode
from .robot_data import links_of_shapes

_EDIT = (
    *("document", "table", "mirror", "server", "shapes", "snap", "pointer", "fields"),
    *("muscles", "wraps", "analysis", "saving", "bar", "edit", "start"),
)
_SCRIPTS = (*SHARED_SCRIPTS, *EDITING_SCRIPTS, *(f"edit_parts/{name}.js" for name in _EDIT))


def edit_page(robot: Robot, folder: Path, session: Mapping[str, Any]) -> str:
    """Return a page that edits the muscles and wrap surfaces of a robot.

    Args:
        session: What the page edits, as data for JSON: `name`, `document`, `laws`, `files` and
            `digest`; and the `token` for its server, or None for a page without a server.
    """
    stage = Stage(robot, Motion.initial(robot), link_meshes(robot, folder))
    data = {
        **session,
        "links": dict(links_of_shapes(robot, stage)),
        "poses": {name: _numbers(T[0]) for name, T in stage.poses.items()},
        "otherSides": dict(_other_sides(robot)),
        "coordinates": [
            {"name": c.name, "unit": c.unit, "lower": c.lower, "upper": c.upper, "value": value}
            for c, value in zip(robot.coordinates, stage.motion.q[0].tolist(), strict=True)
        ],
        "axes": list(_axes(robot, stage)),
    }
    texts = {"motion": base64.b64encode(encode([Act(stage, session["name"])])).decode()}
    texts["edit"] = data_json(data)
    return page_with(
        f"{session['name']} - edit",
        ("page.css", "play_parts/play.css", "edit_parts/edit.css"),
        texts,
        strict_script(_SCRIPTS),
        connects=session["token"] is not None,
    )


def _numbers(T: FloatArray) -> list[float]:
    """Return a pose as 12 numbers: rotation row by row, position."""
    return [*T[:3, :3].reshape(-1).tolist(), *T[:3, 3].tolist()]


def _other_sides(robot: Robot) -> Iterator[tuple[str, str]]:
    """Yield the links whose names contain a side, and their mirror images."""
    names = [link.name for link in robot.links]
    for name in names:
        other = other_side(name)
        if other in names:
            yield name, other


def _axes(robot: Robot, stage: Stage) -> Iterator[dict[str, Any]]:
    """Yield the axes of rotation of the joints in the frames of their links.

    The first axis of a joint is fixed in the parent link. Others are given in the child link.
    """
    axes = coordinate_axes(robot, stage.motion.q, stage.poses)
    for joint in robot.joints:
        moved = [motion for motion in joint.motions if not motion.is_fixed]
        for k, motion in enumerate(moved):
            name = joint.coordinates[motion.coordinate].name
            if motion.kind != "rotation" or name not in axes:
                continue
            T = stage.poses[joint.parent if k == 0 else joint.child][0]
            point, direction = (values[0] for values in axes[name])
            yield {
                "name": name,
                "link": joint.parent if k == 0 else joint.child,
                "child": joint.child,
                "position": (T[:3, :3].T @ (point - T[:3, 3])).tolist(),
                "direction": (T[:3, :3].T @ direction).tolist(),
            }
