"""Train a policy by proximal policy optimisation (PPO), and export it as a controller.

python train_ppo.py --id cardsflow/PlanarReach-v0 -o trained
"""

from __future__ import annotations

import argparse
from typing import Any

import numpy as np
import torch
from networks import Curve, Normaliser, add_options, advantages, make, network, save
from torch import nn
from torch.distributions import Normal

STEPS, EPOCHS, PARTS = 32, 5, 8
DISCOUNT, CLIP, RATE = 0.98, 0.2, 5e-4
LOG_SD, MAX_CHANGE = -1.0, 0.02
EVALUATE_EVERY = 10


class Agent:
    """Policy and value networks with their optimisers."""

    def __init__(self, inputs: int, outputs: int) -> None:
        self.actor, self.critic = network(inputs, outputs, gain=0.01), network(inputs, 1)
        self.log_sd = nn.Parameter(torch.full((outputs,), LOG_SD))
        self._groups = [*self.actor.parameters(), self.log_sd], [*self.critic.parameters()]
        self._optimisers = [torch.optim.Adam(group, RATE) for group in self._groups]

    def policy(self, x: torch.Tensor) -> Normal:
        """Return the distribution of the actions."""
        return Normal(self.actor(x), self.log_sd.exp())

    def value(self, x: torch.Tensor) -> torch.Tensor:
        """Return the values, shape (n,)."""
        return self.critic(x)[:, 0]

    def improve(self, x: torch.Tensor, a: torch.Tensor, log_p: torch.Tensor, data: Any) -> None:
        """Improve both networks with the rows of a rollout."""
        advantages, returns = data
        advantages = (advantages - advantages.mean()) / (advantages.std() + 1e-8)
        for _ in range(EPOCHS):
            for batch in torch.randperm(len(x)).chunk(PARTS):
                change = self.policy(x[batch]).log_prob(a[batch]).sum(1) - log_p[batch]
                ratio = change.exp()
                if (ratio - 1.0 - change).mean() > MAX_CHANGE:  # Kullback-Leibler divergence
                    return
                gain, clipped = advantages[batch], ratio.clamp(1.0 - CLIP, 1.0 + CLIP)
                policy_loss = -torch.min(ratio * gain, clipped * gain).mean()
                value_loss = (self.value(x[batch]) - returns[batch]).square().mean()
                losses = zip((policy_loss, value_loss), self._groups, self._optimisers, strict=True)
                for loss, group, optimiser in losses:
                    optimiser.zero_grad()
                    loss.backward()
                    nn.utils.clip_grad_norm_(group, 0.5)
                    optimiser.step()


class Rollouts:
    """Steps of the vector environment with normalised observations and rewards."""

    def __init__(self, envs: Any, agent: Agent, seed: int) -> None:
        self._envs, self._agent = envs, agent
        self.normal = Normaliser(envs.single_observation_space.shape[0])
        self._returns, self._scale = np.zeros(envs.num_envs), Normaliser(1)
        self._observations, _ = envs.reset(seed=seed)

    @torch.no_grad()
    def collect(self) -> list[torch.Tensor]:
        """Return observations, actions, log probabilities, advantages and returns, as rows."""
        rows, agent = [], self._agent
        for _ in range(STEPS):
            self.normal.update(self._observations)
            x = self.normal(self._observations)
            policy = agent.policy(x)
            actions = policy.sample()
            rewards, ends = self._step(actions.numpy())
            log_p = policy.log_prob(actions).sum(1)
            rows.append((x, actions, log_p, rewards, ends, agent.value(x)))
        x, actions, log_p, rewards, ends, values = (torch.stack(c) for c in zip(*rows, strict=True))
        last = agent.value(self.normal(self._observations))
        gains = advantages(rewards, ends, torch.cat([values, last[None]]), DISCOUNT)
        columns = x, actions, log_p, gains, gains + values
        return [column.flatten(0, 1) for column in columns]

    def _step(self, actions: np.ndarray) -> tuple[torch.Tensor, torch.Tensor]:
        """Return rewards and ends of a step. A reward at the time limit includes the value."""
        result = self._envs.step(actions)
        self._observations, rewards, terminated, truncated, infos = result
        ends = terminated | truncated
        self._returns = DISCOUNT * self._returns + rewards
        self._scale.update(self._returns[:, None])
        self._returns[ends] = 0.0
        rewards = torch.as_tensor(rewards / self._scale.sd, dtype=torch.float32)
        limited = truncated & ~terminated
        if limited.any():
            beyond = self.normal(np.stack(infos["final_obs"][limited]))
            rewards[torch.as_tensor(limited)] += DISCOUNT * self._agent.value(beyond)
        return rewards, torch.as_tensor(ends, dtype=torch.float32)


def train(options: argparse.Namespace) -> tuple[Agent, Normaliser, Curve]:
    """Train until the goal or the limit of time; return agent, normalisation and curve."""
    torch.set_num_threads(1)  # the networks are too small for more
    torch.manual_seed(options.seed)
    envs = make(options.id, options.envs, options.model)
    sizes = envs.single_observation_space.shape[0], envs.single_action_space.shape[0]
    agent = Agent(*sizes)
    rollouts = Rollouts(envs, agent, options.seed)
    rounds, curve = 0, Curve(options, make(options.id, 256, options.model))
    while not curve.is_complete():
        x, actions, log_p, *data = rollouts.collect()
        agent.improve(x, actions, log_p, data)
        rounds += 1
        if rounds % EVALUATE_EVERY == 0:
            curve.evaluate(rounds * STEPS * options.envs, agent.actor, rollouts.normal)
    return agent, rollouts.normal, curve


def main() -> None:
    """Train with the options of the command line."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--id", default="cardsflow/PlanarReach-v0", help="(default: %(default)s)")
    parser.add_argument("--model", help="model file, for tasks of MyoSuite (default: none)")
    add_options(parser)
    parser.add_argument("--envs", type=int, default=256, help="number of robots (default: 256)")
    options = parser.parse_args()
    agent, normal, curve = train(options)
    save(options.output, make(options.id, 1, options.model), agent.actor, normal, curve.rows)


if __name__ == "__main__":
    main()
