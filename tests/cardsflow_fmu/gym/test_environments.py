"""Environments of Gymnasium: its checks, equal vector environments, rewards, wrong inputs."""

from __future__ import annotations

import pickle
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import gymnasium
import mujoco
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode, SyncVectorEnv
from scipy.optimize import lsq_linear
from support.robots.robots import EXAMPLES, with_coordinates

import cardsflow_fmu.gym as gym
from addin_sdfusion.robot import CardsflowError, read_robot
from addin_sdfusion.robot.json_text import json_text
from cardsflow_fmu.gym.episodes import Setup
from cardsflow_fmu.gym.image import image
from cardsflow_fmu.gym.myosuite import soft_limits
from cardsflow_fmu.gym.tasks.pose import PoseTask
from cardsflow_fmu.gym.vector_env import CardsflowVectorEnv
from sim_dart import Batch

POSE, REACH = "cardsflow/PlanarPose-v0", "cardsflow/PlanarReach-v0"
PLANAR = EXAMPLES / "planar_2r"


@pytest.mark.filterwarnings("ignore:.*infinity")
@pytest.mark.parametrize("name", [POSE, REACH, "cardsflow/TrackFlower-v0"])
def test_environments_pass_the_check_of_gymnasium(name: str) -> None:
    check_env(gymnasium.make(name, render_mode="rgb_array").unwrapped, skip_render_check=True)


@pytest.mark.parametrize("mode", [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP])
def test_vector_environments_equal_single_ones(mode: AutoresetMode) -> None:
    options: dict[str, Any] = {"task": "reach", "poses": {"joint_1": (-0.8, 0.8)}, "far": 0.9}

    def single() -> Any:
        return gym.from_experiment(PLANAR, max_episode_steps=13, **options)

    several = SyncVectorEnv([single] * 3, autoreset_mode=mode)
    batch = gym.from_experiment(
        PLANAR, num_envs=3, max_episode_steps=13, autoreset_mode=mode, **options
    )
    assert batch.metadata["autoreset_mode"] is mode
    assert batch.observation_space == several.observation_space
    assert batch.action_space == several.action_space
    found = batch.reset(seed=5)[0]
    np.testing.assert_array_equal(found, several.reset(seed=5)[0])
    rng, ends = np.random.default_rng(0), 0
    for _ in range(40):
        actions = rng.uniform(-1.2, 1.2, batch.action_space.shape).astype(np.float32)
        one, other = batch.step(actions), several.step(actions)
        for a, b in zip(one[:4], other[:4], strict=True):
            np.testing.assert_array_equal(a, b)
        infos = one[4], other[4]
        for name, values in infos[1].items():
            if name in ("reach", "solved", "_solved", "_final_obs"):
                chosen = infos[1].get(f"_{name}", np.full(3, True))
                np.testing.assert_array_equal(infos[0][name][chosen], values[chosen])
        if "final_obs" in infos[1]:
            for i in np.flatnonzero(infos[1]["_final_obs"]):
                np.testing.assert_array_equal(infos[0]["final_obs"][i], infos[1]["final_obs"][i])
        ends += int((one[2] | one[3]).sum())
    assert ends > 6


@pytest.mark.parametrize("corner", [(0.5, 0.3), (0.5, -0.3), (-0.5, 0.3), (-0.5, -0.3)])
def test_planar_targets_can_be_held_by_the_actions(corner: tuple[float, float]) -> None:
    """Cables produce a torque of 1 N.m in each direction at the corners of the targets."""
    episodes = gymnasium.make(REACH).unwrapped.episodes
    episodes.batch.reset(q=corner, commands=episodes.actions.rest)
    _, low, high, _ = episodes.actions.ranges()
    A = -episodes.batch.jacobian[0].T
    for angle in np.linspace(0.0, 2.0 * np.pi, 8, endpoint=False):
        torque = np.array([np.cos(angle), np.sin(angle)])
        found = lsq_linear(A, torque, (low, high))
        np.testing.assert_allclose(A @ found.x, torque, atol=1e-6)


def test_targets_are_drawn_by_splitmix64() -> None:
    """The numbers of the seed 1234567 are those of Rosetta Code, for any number of instances."""
    expected = np.array([6457827717110365317, 3203168211198807973, 9817491932198370423], np.uint64)
    targets = {"joint_1": (0.0, 1.0), "joint_2": (0.0, 2.0)}
    for n in (1, 3):
        env = gym.from_experiment(PLANAR, task="pose", targets=targets, num_envs=n)
        env.reset(seed=0)
        env.episodes.streams[-1] = 1234567
        found = []
        for _ in range(2):
            env.episodes.reset(np.arange(n) == n - 1)
            found += [*env.episodes.targets[-1] / [1.0, 2.0]]
        np.testing.assert_array_equal(found[:3], (expected >> np.uint64(11)) * 2.0**-53)


@pytest.mark.parametrize("name", ["planar_2r", "hill_arm"])
def test_actions_are_mapped_to_commands_and_torques(name: str) -> None:
    """A step equals that of a batch with commands by the formulas of both maps."""
    robot = with_coordinates(
        read_robot(EXAMPLES / name / "robot"), actuated=True, tau_min=-0.2, tau_max=0.6
    )
    setup = Setup(robot, PoseTask(robot, start="random"))
    env, batch = CardsflowVectorEnv(setup, 3, max_episode_steps=None), Batch(robot, 3, 2e-3)
    env.reset(seed=0)
    m = len(robot.muscles)
    actions = np.random.default_rng(0).uniform(-1.4, 1.4, env.action_space.shape)
    batch.reset(q=env.episodes.batch.q, commands=env.episodes.batch.commands)
    env.step(actions)
    share = 0.5 + 0.5 * actions.clip(-1.0, 1.0)
    u = 1.0 / (1.0 + np.exp(-5.0 * (actions[:, :m].clip(-1.0, 1.0) - 0.5)))
    if name == "planar_2r":
        f = [(muscle.f_min, muscle.f_max) for muscle in robot.muscles]
        u = share[:, :m] * np.diff(f)[:, 0] + np.array(f)[:, 0]
    for _ in range(setup.substeps):
        batch.step(u, -0.2 + 0.8 * share[:, m:])
    np.testing.assert_allclose(env.episodes.batch.get_state(), batch.get_state(), rtol=1e-9)


def test_reset_mask_starts_only_chosen_episodes() -> None:
    env = gymnasium.make_vec(POSE, 2, autoreset_mode="Disabled")
    before = env.reset(seed=[3, 4])[0]
    env.step(np.full(env.action_space.shape, [1.0, -1.0, -1.0, -1.0], np.float32))
    options = {"reset_mask": np.array([True, False])}
    found = env.reset(seed=[3, 4], options=options)[0]
    np.testing.assert_array_equal(found[0], before[0])
    assert not np.array_equal(found[1], before[1])


def test_rewards_are_those_of_their_formulas() -> None:
    env = gym.from_experiment(PLANAR, task="pose", threshold=0.9, weights={"act_reg": 0.0})
    env.action_space.seed(0)
    env.reset(seed=1)
    solved = []
    for _ in range(80):
        observation, reward, *_, info = env.step(env.action_space.sample())
        error = env.episodes.targets[0] - env.episodes.batch.q[0]
        np.testing.assert_allclose(observation[4:], error, atol=1e-6)
        np.testing.assert_allclose(observation[2:4], 0.02 * env.episodes.batch.qd[0], atol=1e-6)
        distance = np.linalg.norm(error)
        bonus = float(distance < 0.9) + float(distance < 1.35)
        assert reward == pytest.approx(-distance + 4.0 * bonus - 50.0 * (distance > 2 * np.pi))
        assert info["solved"] == (distance < 0.9)
        solved.append(info["solved"])
    assert {*solved} == {False, True}


def test_pickled_environments_continue_equally() -> None:
    env = gymnasium.make(REACH)
    env.reset(seed=1)
    env.step(env.action_space.sample())
    again = pickle.loads(pickle.dumps(env))
    for k in range(3):
        actions = np.full(4, 0.3 * k, np.float32)
        np.testing.assert_array_equal(env.step(actions)[0], again.step(actions)[0])
    np.testing.assert_array_equal(env.reset()[0], again.reset()[0])


@pytest.mark.parametrize("end", [0, 1])
def test_images_contain_the_robot_at_its_joint_limits(end: int) -> None:
    robot = gymnasium.make("cardsflow/TrackFlower-v0").unwrapped.episodes.setup.robot
    q = np.array([(c.lower, c.upper)[end] for c in robot.coordinates])
    drawn = (image(robot, q, np.zeros(len(robot.muscles))) < 240).any(axis=2)
    assert drawn[1:-1, 1:-1].any()
    drawn[1:-1, 1:-1] = False
    assert not drawn.any()


def test_images_and_pages_show_the_robot(monkeypatch: pytest.MonkeyPatch) -> None:
    env = gym.from_experiment(PLANAR, task="pose", render_mode="rgb_array")
    env.reset(seed=0)
    first = env.render()
    env.step(np.array([1, -1, -1, -1], np.float32))
    assert first is not None
    assert first.shape == (360, 480, 3)
    assert 500 < (first < 240).any(axis=2).sum() < 40_000
    assert not np.array_equal(first, env.render())
    opened: list[str] = []
    monkeypatch.setattr("webbrowser.open", opened.append)
    assert env.episodes.setup.robot.name in env.show().html
    assert len(opened) == 1


def test_variants_are_drawn_by_variations_of_studies() -> None:
    vary = [{"path": "robot.links.link_2.inertia.mass", "uniform": [0.5, 2.0]}]
    env = gym.from_experiment(PLANAR, task="pose", randomise=vary, variants=4, num_envs=16)
    env.reset(seed=0)
    masses = {r.links[-1].inertia.mass for r in env.episodes.setup.variants}
    assert len(masses) == 4
    assert min(masses) > 0.5
    assert max(masses) < 2.0
    assert len(set(env.episodes.batch.variant.tolist())) > 1


def test_variants_deviate_as_a_calibration_states(tmp_path: Path) -> None:
    shutil.copytree(PLANAR, tmp_path / "arm")
    rows = [
        {"name": "muscles.cable_1.via_points[0].x", "sd": 0.01},
        {"name": "joints.joint_1.damping", "sd": 0.1},
        {"name": "links.link_2.inertia.mass", "sd": 0.05},
        {"name": "muscles.cable_1.offset", "sd": 0.001},
    ]
    file = tmp_path / "arm/robot/calibration.json"
    file.write_text(json_text({"parameters": rows}))
    env = gym.from_experiment(tmp_path / "arm", task="pose", randomise="calibration", variants=40)
    robots, nominal = env.episodes.setup.variants, env.episodes.setup.robot
    x = [r.muscles[0].via_points[0].position[0] for r in robots]
    assert np.std(x) == pytest.approx(0.01, rel=0.4)
    assert np.mean(x) == pytest.approx(nominal.muscles[0].via_points[0].position[0], abs=0.005)
    assert min(r.coordinates[0].damping for r in robots) >= 0.0
    assert np.std([r.links[-1].inertia.mass for r in robots]) == pytest.approx(0.05, rel=0.4)


PENDULUM = """<mujoco>
  <compiler angle="radian"/>
  <option gravity="90 0 0"/>
  <default>
    <joint axis="0 1 0" range="-0.2 0.3" damping="0.5" armature="0.01"/>
    <geom type="capsule" size="0.02" fromto="0 0 0 0 0 -0.3" contype="0"/>
  </default>
  <worldbody><body name="upper"><joint name="a"/><geom mass="2"/>
    <body name="lower" pos="0 0 -0.3"><joint name="b"/><geom mass="1"/></body>
  </body></worldbody>
</mujoco>"""


def test_joints_move_beyond_their_limits_as_in_mujoco(tmp_path: Path) -> None:
    """They meet, exceed and leave their limits; damping is implicit here, which decays as h."""
    file = tmp_path / "pendulum.xml"
    file.write_text(PENDULUM)
    model = mujoco.MjModel.from_xml_string(PENDULUM)
    model.opt.timestep = 0.0005
    data, batch = mujoco.MjData(model), Batch(soft_limits(read_robot(file)), 1, 0.0005)
    data.qpos[:] = [0.1, 0.2]
    batch.reset(q=data.qpos)
    lowest = data.qpos.copy()
    for _ in range(3000):
        mujoco.mj_step(model, data)
        batch.step(np.zeros((1, 0)))
        np.testing.assert_allclose(batch.q[0], data.qpos, atol=0.002)
        lowest = np.minimum(lowest, data.qpos)
    assert (lowest < -0.27).all()
    assert (data.qpos < -0.208).all()
    np.testing.assert_allclose(batch.q[0], data.qpos, atol=1e-9)


def _make(name: str = POSE, **options: Any) -> Callable[[], object]:
    return lambda: gymnasium.make(name, **options)


def _experiment(**options: Any) -> Callable[[], object]:
    return lambda: gym.from_experiment(PLANAR, **options)


def _step(actions: Any, **options: Any) -> Callable[[], object]:
    def run() -> None:
        env = gym.from_experiment(PLANAR, task="pose", **options)
        env.reset(seed=0)
        env.step(actions)

    return run


MYO = "cardsflow/myoElbowPose1D6MRandom-v0"
VARY = {"path": "robot.links.link_7.inertia.mass", "uniform": [0.5, 2.0]}
WRONG: dict[str, tuple[Callable[[], object], str]] = {
    "no model": (_make(MYO), "needs a model of yours"),
    "model": (_make(MYO, model=3), "needs a model of yours: make"),
    "missing model": (_make(MYO, model="none.xml"), "none.xml: cannot be read"),
    "option of a model": (_make(MYO, model="a.xml", step=0.1), "has no option 'step'"),
    "model of an example": (_make(model="a.xml"), "has a robot"),
    "render mode": (_experiment(render_mode="human"), "render_mode must be one of"),
    "render of many": (_experiment(num_envs=2, render_mode="rgb_array"), "do not render"),
    "mode": (_experiment(num_envs=2, autoreset_mode="never"), "unknown autoreset_mode 'never'"),
    "count": (_experiment(num_envs=0), "n must be a whole number from 1"),
    "episode": (_experiment(max_episode_steps=0), "max_episode_steps must be a whole number"),
    "task": (_experiment(task="walk"), "unknown task 'walk'; known: track, pose, reach"),
    "task option": (_experiment(task="pose", radius=1), "unexpected keyword argument 'radius'"),
    "coordinate": (_experiment(task="pose", targets={"knee": (0, 1)}), "coordinate 'knee'"),
    "range": (_experiment(task="pose", targets={"joint_1": (1, 0)}), "must begin below its end"),
    "range of one": (_experiment(task="pose", targets={"joint_1": 1}), r"must be \(low, high\)"),
    "nan": (_experiment(task="pose", targets={"joint_1": (0, np.nan)}), "must have finite ends"),
    "threshold": (_experiment(task="pose", threshold=-1.0), "threshold must be positive"),
    "start": (_experiment(task="pose", start="rest"), "start must be 'initial' or 'random'"),
    "weights": (_experiment(weights=[1.0]), "weights must have values by name"),
    "weight": (_experiment(weights={"speed": 1.0}), "reward term 'speed'"),
    "point": (_experiment(task="reach", targets={"toe": (0, 1)}), "task frame 'toe'"),
    "no points": (lambda: gym.from_experiment(EXAMPLES / "bicycle", task="reach"), "no points to"),
    "box": (_experiment(task="reach", targets={"tip": ((0, 0, 0), (1, 1, 1))}), "coordinates"),
    "far box": (
        _experiment(task="reach", targets={"tip": ((9, 9), (10, 10))}, sampling="workspace"),
        "no pose of the robot brings the points into the boxes",
    ),
    "step": (_experiment(step=0.0015), "not a whole multiple of the step of the plant"),
    "action map": (_experiment(action="sigmoid"), "needs muscles with excitations"),
    "randomise": (_experiment(randomise="a lot"), "must be 'calibration' or a list of tables"),
    "variants": (_experiment(randomise=[VARY], variants=0), "variants must be a whole number"),
    "random seed": (_experiment(randomise=[VARY], seed="x"), "seed must be a whole number from 0"),
    "variation": (_experiment(randomise=[VARY]), "link_7"),
    "no calibration": (_experiment(randomise="calibration"), "run `cardsflow calibrate`"),
    "action shape": (_step(np.zeros(3)), r"action must have shape \(4,\), not \(3,\)"),
    "actions shape": (_step(np.zeros((3, 4)), num_envs=2), r"actions must have shape \(2, 4\)"),
    "actions text": (_step([["a", "b"]] * 2, num_envs=2), r"must be numbers of shape \(2, 4\)"),
    "actions infinite": (
        _step(np.full((40, 4), np.inf), num_envs=40),
        r"actions must be finite, not inf \(instance 0, column 0\)",
    ),
    "seed": (lambda: gymnasium.make_vec(POSE, 2).reset(seed=1.5), "seed must be a number or 2"),
    "action nan": (_step(np.full(4, np.nan)), "actions must be finite"),
    "contacts": (lambda: gym.from_experiment(EXAMPLES / "pick_up"), "worlds with contacts"),
}


@pytest.mark.parametrize(("call", "message"), WRONG.values(), ids=WRONG)
def test_wrong_inputs_are_rejected_with_one_line(call: Callable[[], object], message: str) -> None:
    with pytest.raises(CardsflowError, match=message) as caught:
        call()
    assert "\n" not in str(caught.value)
