"""Episodes in the viewer."""

from __future__ import annotations

import numpy as np

from addin_sdfusion.robot import InputError
from cardsflow_fmu.results.viewer.html.page import replay_page
from cardsflow_fmu.results.viewer.inline import ShownPage, shown
from cardsflow_fmu.results.viewer.scene.act import Act
from cardsflow_fmu.results.viewer.scene.meshes import link_meshes
from cardsflow_fmu.results.viewer.scene.motion import Motion
from cardsflow_fmu.results.viewer.scene.stage import Stage
from cardsflow_fmu.utils.arrays import FloatArray

from .episodes import Setup


def show_episode(setup: Setup, frames: FloatArray) -> ShownPage:
    """Return a page with the motion of an episode; outside of notebooks, open the browser.

    Args:
        setup: Robot and step of the environment.
        frames: Joint positions and tensions of each step, shape (k, dofs + m).

    Raises:
        InputError: The episode has not begun.
    """
    if not len(frames):
        raise InputError("the episode has not begun; call reset first")
    robot, dofs = setup.robot, len(setup.robot.coordinates)
    time: FloatArray = setup.step * np.arange(len(frames), dtype=np.float64)
    motion = Motion(time, frames[:, :dofs], frames[:, dofs:])
    meshes = {} if setup.folder is None else link_meshes(robot, setup.folder)
    return shown(replay_page([Act(Stage(robot, motion, meshes), robot.name)]))
