"""Train a policy to reach by exact gradients through the robot, and export it as a controller.

python train_gradients.py -o trained
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from typing import Any

import numpy as np
import torch
from networks import Curve, Normaliser, add_options, advantages, make, network, save

from cardsflow_fmu.gym.episodes import Episodes
from cardsflow_fmu.gym.torch_step import BatchStep

ID, ENVS, STEPS = "cardsflow/PlanarReach-v0", 48, 6
RATE, CRITIC_RATE, BETAS = 1e-2, 3e-3, (0.7, 0.95)
SLOWING = 130
"""Rounds k after which the rates are halved. They fall as 1 / (1 + k / SLOWING), whose sum is
infinite: with rates that fall exponentially, policies that learn late stop short."""
DISCOUNT, SCALE, MAX_GRADIENT = 0.97, 0.02, 1.0
SUBSTEPS = 2
"""Integrator steps in a step, fewer than in the environment, since each needs derivatives."""
WIDTH, AHEAD, GUIDE, EFFORT = 0.03, 0.03, 10.0, 0.1
SCALES = (0.3, 0.03, 0.5, 0.5)
"""Scales of q, of qd times the step, of the tip and of its distance to the target."""
POSITIONS, VELOCITIES, GROWTH, MAX_STEPS = 0.15, 2.0, 30, 100
POWER = 8
"""The policy that is evaluated and exported is the average of the policies of all rounds k, with
weights nearly as k^POWER (O. Shamir, T. Zhang, Stochastic gradient descent for non-smooth
optimization, 2013)."""
CRITIC_EPOCHS, CRITIC_PARTS, EVALUATE_EVERY = 2, 2, 10


class Motions:
    """Motions of many robots, which continue from one window of `STEPS` steps to the next.

    Args:
        envs: Vector environment with the task.
        seed: Seed of the targets and the starts.
    """

    def __init__(self, envs: Any, seed: int) -> None:
        self._episodes = Episodes(replace(envs.episodes.setup, substeps=SUBSTEPS), ENVS, None)
        self._episodes.seed([seed * ENVS + i for i in range(ENVS)])
        self._batch, self._rng = self._episodes.batch, np.random.default_rng(seed)
        self._step, self._dofs = BatchStep(self._batch), self._batch.q.shape[1]
        self._low, self._high = map(torch.Tensor, self._episodes.actions.ranges()[1:3])
        self._start(np.ones(ENVS, bool))
        self.normal = Normaliser(self._episodes.observations().shape[1])
        self.normal.mean = self._episodes.observations().mean(axis=0, dtype=float)
        self.normal.sd = np.repeat(SCALES, self._dofs)

    def _start(self, chosen: np.ndarray) -> None:
        """Start chosen motions near the initial pose, with a velocity and a new target."""
        self._episodes.reset(chosen)
        spread = np.repeat([POSITIONS, VELOCITIES], self._dofs)
        changes = chosen[:, None] * spread * self._rng.normal(size=(ENVS, 2 * self._dofs))
        self._batch.set_state(self._batch.get_state() + changes)

    def window(self, actor: torch.nn.Module, critic: torch.nn.Module) -> list[torch.Tensor]:
        """Return the loss with its gradients, observations, rewards and ends of a window.

        The loss is minus the discounted smooth rewards, then the value of the last state.
        """
        targets = torch.from_numpy(self._episodes.targets).float()
        state, rows = self._step.start(torch.float32), []
        points = [self._step.position(state)]
        x = self._observe(state, points[0], targets)
        for _ in range(STEPS):
            actions = actor(x)
            share = 0.5 * (1.0 + actions.clamp(-1.0, 1.0))
            state = self._step(state, self._low + share * (self._high - self._low))
            points.append(self._step.position(state))
            result = self._episodes.evaluate()
            rewards, ends = torch.Tensor(SCALE * result.rewards), torch.Tensor(result.done)
            rows.append((x, actions, rewards, ends))
            x = self._observe(state, points[-1], targets)
        found, actions, rewards, ends = (torch.stack(c) for c in zip(*rows, strict=True))
        y = torch.stack(points)
        smooth = self._smooth_reward(targets - y[1:], y.diff(dim=0))
        beyond = (actions.abs() - 1.0).clamp(min=0.0).square().sum(2)
        shares = DISCOUNT ** torch.arange(STEPS)
        gain = SCALE * shares @ (smooth - EFFORT * beyond).mean(1)
        gain = gain + DISCOUNT**STEPS * critic(x).mean()
        return [-gain, torch.cat([found, x[None]]).detach(), rewards, ends]

    def restart(self, ends: torch.Tensor, longest: float) -> None:
        """Restart motions that have left the region of the task, and the longest ones."""
        limits = longest * self._rng.uniform(0.5, 1.0, ENVS)
        self._start((ends[-1].numpy() > 0) | (self._batch.ticks >= limits))

    def _observe(self, state: Any, y: Any, targets: Any) -> torch.Tensor:
        q, qd = state[:, : self._dofs], state[:, self._dofs :]
        return self.normal(torch.cat([q, self._batch.step_size * qd, y, targets - y], dim=1))

    def _smooth_reward(self, error: torch.Tensor, move: torch.Tensor) -> torch.Tensor:
        """Return the reward of the task with smooth steps of the bonus, shape (steps, n).

        Far from the target the bonus has no slope. So the distance from the target of the point
        that the tip reaches after `AHEAD` is added: the tip shall be fast far from the target.
        """
        weights, near = self._episodes.task.weights, self._episodes.task.near
        ahead = error - AHEAD / self._batch.step_size * move
        distance, far = ((e.square().sum(-1) + 1e-4).sqrt() for e in (error, ahead))
        bonus = sum(torch.sigmoid((end * near - distance) / WIDTH) for end in (1.0, 2.0))
        return weights["bonus"] * bonus - weights["reach"] * distance - GUIDE * far


def fit(critic: torch.nn.Module, optimiser: Any, x: Any, rewards: Any, ends: Any) -> None:
    """Fit the values to the rewards of a window."""
    with torch.no_grad():
        values = critic(x)[..., 0]
        goals = values[:-1] + advantages(rewards, ends, values, DISCOUNT)
    x, goals = x[:-1].flatten(0, 1), goals.flatten()
    for _ in range(CRITIC_EPOCHS):
        for part in torch.randperm(len(x)).chunk(CRITIC_PARTS):
            optimiser.zero_grad()
            (critic(x[part])[:, 0] - goals[part]).square().mean().backward()
            optimiser.step()


def include(averages: list[Any], policy: list[Any], count: Any) -> None:
    """Include the parameters of a policy in the averages of `count` policies."""
    share = (POWER + 1) / (int(count) + 1 + POWER)
    for average, parameters in zip(averages, policy, strict=True):
        average.lerp_(parameters, share)


def train(options: argparse.Namespace) -> tuple[Any, Normaliser, Curve]:
    """Train until the goal or the limit of time; return actor, normalisation and curve."""
    torch.set_num_threads(1)
    torch.manual_seed(options.seed)
    trial = make(ID, 256)
    inputs, outputs = trial.single_observation_space.shape[0], trial.single_action_space.shape[0]
    actor, critic = network(inputs, outputs, gain=0.01), network(inputs, 1, gain=0.01)
    parts = (actor, RATE), (critic, CRITIC_RATE)
    optimisers = [torch.optim.Adam(part.parameters(), rate, BETAS) for part, rate in parts]
    average = torch.optim.swa_utils.AveragedModel(actor, multi_avg_fn=include)
    rule = torch.optim.lr_scheduler.LambdaLR
    decays = [rule(o, lambda k: 1.0 / (1.0 + k / SLOWING)) for o in optimisers]
    rounds, curve, motions = 0, Curve(options, trial), Motions(trial, options.seed)
    while not curve.is_complete():
        loss, x, rewards, ends = motions.window(actor, critic)
        optimisers[0].zero_grad()
        loss.backward()
        torch.nn.utils.clip_grad_norm_(actor.parameters(), MAX_GRADIENT)
        optimisers[0].step()
        average.update_parameters(actor)
        fit(critic, optimisers[1], x, rewards, ends)
        for decay in decays:
            decay.step()
        rounds += 1
        motions.restart(ends, min(MAX_STEPS, STEPS * (1.0 + rounds / GROWTH)))
        if rounds % EVALUATE_EVERY == 0:
            curve.evaluate(rounds * STEPS * ENVS, average.module, motions.normal)
    return average.module, motions.normal, curve


def main() -> None:
    """Train with the options of the command line."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    add_options(parser)
    options = parser.parse_args()
    actor, normal, curve = train(options)
    save(options.output, make(ID, 1), actor, normal, curve.rows)


if __name__ == "__main__":
    main()
