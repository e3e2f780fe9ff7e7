"""Self-contained HTML page that simulates an experiment: plant and controller run in the page."""

from __future__ import annotations

import base64
import zlib
from collections.abc import Iterator
from typing import Any

from addin_sdfusion.robot import Robot
from addin_sdfusion.robot.json_text import json_text
from cardsflow_fmu.cosim.signals.ports import task_names
from cardsflow_fmu.experiment.experiment import EXPERIMENT_FILE, Experiment
from cardsflow_fmu.experiment.writer import experiment_resources
from cardsflow_fmu.models.browser.pack import engine_text
from cardsflow_fmu.results.viewer.scene import shapes
from cardsflow_fmu.results.viewer.scene.act import Act
from cardsflow_fmu.results.viewer.scene.meshes import link_meshes
from cardsflow_fmu.results.viewer.scene.motion import Motion
from cardsflow_fmu.results.viewer.scene.stage import Stage
from cardsflow_fmu.utils.archive import read_contents
from cardsflow_fmu.utils.html_page import html_page, script_element

from .page import SHARED_SCRIPTS, page_part, strict_script
from .page_data import encode

_WORKER = ("module", "crc32", "drawing", "changes", "analysis", "engine", "worker")
_PLAY = ("analysis", "download", "panel", "pointer", "bar", "play")
_SCRIPTS = (*SHARED_SCRIPTS, *(f"play_parts/{name}.js" for name in _PLAY))


def engine_script(*names: str) -> str:
    """Return scripts of the simulation, such as `client` or `worker`."""
    return "\n".join(page_part(f"engine_parts/{name}.js") for name in names)


def play_page(experiment: Experiment) -> str:
    """Return a page in which a user drives the robot, pulls it and changes it.

    Args:
        experiment: The experiment.

    Raises:
        InputError: The experiment requires Python, DART or hardware, or the compiler is missing.
    """
    engine = engine_text(experiment)
    robot = experiment.robot
    meshes = link_meshes(robot, experiment.folder, experiment.roots)
    stage = Stage(robot, Motion.still(experiment.start.q), meshes)
    act = Act(stage, experiment.name, tuple(experiment.warnings()))
    motion = base64.b64encode(encode([act])).decode()
    extra = {
        "links": dict(_links_of_shapes(robot, stage)),
        "muscleRadius": 0.004 * stage.reach,
        "hand": _hand(robot),
        "path": experiment.file.parent.as_posix(),
        "name": experiment.name,
        "experimentFile": EXPERIMENT_FILE,
        "tasks": list(task_names(robot)),
    }
    texts = {"motion": motion, "engine": engine, "play": _escaped(json_text(extra))}
    texts["files"] = _files(experiment)
    texts["engine-script"] = engine_script(*_WORKER)
    script = "\n".join((strict_script(_SCRIPTS), engine_script("client", "crc32")))
    return html_page(
        f"{experiment.name} - play",
        page_part("page.css") + page_part("play_parts/play.css"),
        "<noscript>This page requires JavaScript; allow scripts for it.</noscript>",
        *(f'<script type="text/plain" id="{id_}">{text}</script>' for id_, text in texts.items()),
        script_element(script),
        scripts=(script,),
        simulates=True,
    )


def _hand(robot: Robot) -> dict[str, Any] | None:
    """Return link and position of the first end-effector point, or None."""
    names = [link.name for link in robot.links]
    for frame in robot.task_frames:
        if not frame.is_orientation and frame.link in names:
            return {"link": names.index(frame.link), "position": list(frame.position)}
    return None


def _files(experiment: Experiment) -> str:
    """Return the files of the experiment as base64 of compressed JSON: base64 by path."""
    contents = {
        name: base64.b64encode(read_contents(source)).decode()
        for name, source in experiment_resources(experiment).items()
    }
    return base64.b64encode(zlib.compress(json_text(contents).encode(), 9)).decode()


def _escaped(text: str) -> str:
    """Return JSON that cannot end a script element."""
    return text.replace("<", "\\u003c")


def _links_of_shapes(robot: Robot, stage: Stage) -> Iterator[tuple[str, str]]:
    """Yield the name of each shape that moves with a link, and the link."""
    children = {joint.name: joint.child for joint in robot.joints}
    parts = {
        shapes.WRAP_SURFACES: {s.name: s.link for s in robot.wrap_surfaces},
        shapes.VIA_POINTS: {
            f"{muscle.name}/{v}": point.link
            for muscle in robot.muscles
            for v, point in enumerate(muscle.via_points)
        },
        shapes.LINK_FRAMES: {link.name: link.name for link in robot.links},
        shapes.JOINT_FRAMES: children,
        shapes.JOINT_VALUES: {c.name: j.child for j in robot.joints for c in j.coordinates},
        shapes.LINKS: {f"joint {name}": child for name, child in children.items()},
    }
    names = [link.name for link in robot.links]
    for shape in stage.scene(0):
        link = parts.get(shape.group, {}).get(shape.key)
        if link is None and shape.group == shapes.LINKS:
            link = shape.key.rpartition("/")[0]
        if link in names:
            yield shape.name, link
