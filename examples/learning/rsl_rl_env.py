"""Adapt vector environments to RSL-RL, and train the planar arm: `python rsl_rl_env.py`."""

from __future__ import annotations

from typing import Any

import gymnasium
import torch
from rsl_rl.env import VecEnv
from rsl_rl.runners import OnPolicyRunner
from tensordict import TensorDict

import cardsflow_fmu.gym  # noqa: F401  registers cardsflow/...

STEPS, SCALE = 100, 0.01  # steps of an episode; scale of the rewards
MODEL = {
    "class_name": "MLPModel",
    "hidden_dims": [64, 64],
    "activation": "tanh",
    "obs_normalization": True,
}
SETTINGS = {
    "num_steps_per_env": 32,
    "save_interval": 1000,
    "obs_groups": {"actor": ["policy"], "critic": ["policy"]},
    "actor": {
        **MODEL,
        "distribution_cfg": {
            "class_name": "GaussianDistribution",
            "init_std": 0.5,
            "std_type": "log",
        },
    },
    "critic": MODEL,
    "algorithm": {
        "class_name": "PPO",
        "gamma": 0.98,
        "learning_rate": 5e-4,
        "schedule": "fixed",
        "entropy_coef": 0.0,
        "num_mini_batches": 8,
        "use_clipped_value_loss": False,
        "max_grad_norm": 0.5,
    },
}


class RslEnv(VecEnv):  # type: ignore[misc]
    """Vector environment with tensors, as RSL-RL expects it."""

    def __init__(self, name: str, num_envs: int) -> None:
        self.envs = gymnasium.make_vec(name, num_envs, autoreset_mode="SameStep")
        self.num_envs, self.num_actions = num_envs, self.envs.single_action_space.shape[0]
        self.max_episode_length, self.device, self.cfg = STEPS, "cpu", {}
        self.episode_length_buf = torch.zeros(num_envs, dtype=torch.long)
        self._observations = self._grouped(self.envs.reset(seed=0)[0])

    def get_observations(self) -> Any:
        """Return the current observations."""
        return self._observations

    def step(self, actions: torch.Tensor) -> tuple[Any, torch.Tensor, torch.Tensor, dict[str, Any]]:
        """Return observations, rewards, ends of episodes, and which ends are time limits."""
        observations, rewards, terminated, truncated, _ = self.envs.step(actions.numpy())
        self._observations = self._grouped(observations)
        dones = torch.as_tensor(terminated | truncated)
        self.episode_length_buf = (self.episode_length_buf + 1) * ~dones
        scaled = torch.as_tensor(SCALE * rewards, dtype=torch.float32)
        limits = torch.as_tensor(truncated & ~terminated)
        return self._observations, scaled, dones, {"time_outs": limits}

    def _grouped(self, observations: Any) -> TensorDict:
        return TensorDict({"policy": torch.as_tensor(observations)}, batch_size=[self.num_envs])


if __name__ == "__main__":
    OnPolicyRunner(RslEnv("cardsflow/PlanarReach-v0", 256), SETTINGS).learn(120)
