"""Self-contained HTML pages of a robot that moves: a simulation with controller, or poses."""

from __future__ import annotations

import base64
import zlib
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from addin_sdfusion.robot import Robot
from addin_sdfusion.robot.json_text import json_text
from cardsflow_fmu.cosim.signals.ports import task_names
from cardsflow_fmu.experiment.experiment import EXPERIMENT_FILE, Experiment
from cardsflow_fmu.experiment.reader import EXPERIMENT_TOML
from cardsflow_fmu.experiment.writer import experiment_resources
from cardsflow_fmu.models.browser.pack import engine_text
from cardsflow_fmu.models.browser.pose import pose_experiment
from cardsflow_fmu.results.analysis.look_ahead import with_look_ahead
from cardsflow_fmu.results.viewer.scene.act import Act
from cardsflow_fmu.results.viewer.scene.meshes import link_meshes
from cardsflow_fmu.results.viewer.scene.motion import Motion
from cardsflow_fmu.results.viewer.scene.stage import Stage
from cardsflow_fmu.utils.archive import read_contents

from .page import EDITING_SCRIPTS, SHARED_SCRIPTS, data_json, page_part, page_with, strict_script
from .page_data import encode
from .robot_data import links_of_shapes

_WORKER = ("module", "crc32", "drawing", "changes", "analysis", "engine", "worker")
_PLAY = ("analysis", "download", "events", "panel", "pointer", "bar", "play")
_SCRIPTS = (*SHARED_SCRIPTS, *EDITING_SCRIPTS, *(f"play_parts/{name}.js" for name in _PLAY))


_NO_CONTACTS = (
    "warning: this page simulates no ground, objects and contacts; `cardsflow run --view` does"
)


def engine_script(*names: str) -> str:
    """Return scripts of the simulation, such as `client` or `worker`."""
    return "\n".join(page_part(f"engine_parts/{name}.js") for name in names)


def play_page(experiment: Experiment, robot_file: str = "", changes: Sequence[str] = ()) -> str:
    """Return a page in which a user drives the robot, pulls it and changes it.

    Args:
        experiment: The experiment. Its page has no ground, objects and contacts.
        robot_file: The robot if `cardsflow init` created the experiment; the command that the page
            copies then begins with it.
        changes: Changes `key=value` of the experiment that the command contains.
    """
    notes = tuple(experiment.warnings())
    experiment = with_look_ahead(experiment)
    if experiment.scene is not None:
        experiment, notes = replace(experiment, scene=None), (_NO_CONTACTS, *notes)
    meshes = link_meshes(experiment.robot, experiment.folder, experiment.roots)
    stage = Stage(experiment.robot, Motion.still(experiment.start.q), meshes)
    extra = {
        "robotFile": robot_file,
        "path": EXPERIMENT_TOML if robot_file else experiment.file.parent.as_posix(),
        "changes": list(changes),
        "name": experiment.name,
        "experimentFile": EXPERIMENT_FILE,
        "tasks": list(task_names(experiment.robot)),
    }
    act = Act(stage, experiment.name, notes)
    return _moving_page(act, engine_text(experiment), extra, {"files": _files(experiment)})


def robot_page(act: Act) -> str:
    """Return a page in which a user moves the joints of a robot and sees lengths and moment arms.

    Args:
        act: The robot at rest.

    Raises:
        InputError: The robot is not supported, or the compiler is missing.
    """
    experiment = pose_experiment(act.stage.robot, act.stage.motion.q[0].tolist())
    return _moving_page(act, engine_text(experiment, ("pose",)), {}, {})


def _moving_page(act: Act, engine: str, extra: dict[str, Any], files: dict[str, str]) -> str:
    robot, stage = act.stage.robot, act.stage
    extra |= {"links": dict(links_of_shapes(robot, stage)), "hand": _hand(robot)}
    motion = base64.b64encode(encode([act])).decode()
    texts = {"motion": motion, "engine": engine, "play": data_json(extra), **files}
    texts["engine-script"] = engine_script(*_WORKER)
    script = "\n".join((strict_script(_SCRIPTS), engine_script("client", "crc32")))
    styles = ("page.css", "play_parts/play.css")
    return page_with(act.title, styles, texts, script, simulates=True)


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
