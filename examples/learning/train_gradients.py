"""Train a policy to reach by exact gradients through the robot, and export it as a controller.

python train_gradients.py -o trained
"""

from __future__ import annotations

import argparse
from typing import Any

import numpy as np
import torch
from networks import Clock, Normaliser, Row, add_options, evaluate, make, network, save

from cardsflow_fmu.gym.torch_step import BatchStep

ID, ENVS, STEPS, RATE = "cardsflow/PlanarReach-v0", 64, 10, 3e-3
AHEAD, EFFORT, DECAY = 0.12, 0.1, 0.995
POSITIONS, VELOCITIES = 0.2, 1.0
SCALES = (0.3, 0.03, 0.5, 0.5)
"""Scales of q, of qd times the step, of the tip and of its distance to the target."""
EVALUATE_EVERY = 25


def motion_loss(
    envs: Any, actor: torch.nn.Module, normal: Normaliser, rng: np.random.Generator
) -> torch.Tensor:
    """Return the loss of short motions from random states.

    It is the distance to the target of the point that the tip reaches after `AHEAD` at its present
    velocity. So the tip is fast far from the target, and slow near it.
    """
    envs.reset()
    episodes = envs.episodes
    batch, targets = episodes.batch, torch.from_numpy(episodes.targets.copy())
    low, high = (torch.from_numpy(end) for end in episodes.actions.ranges()[1:3])
    dofs, h = batch.q.shape[1], batch.step_size
    spread = np.repeat([POSITIONS, VELOCITIES], dofs)
    batch.set_state(batch.get_state() + spread * rng.normal(size=(batch.n, 2 * dofs)))
    step = BatchStep(batch)
    state, loss = step.start(), torch.zeros(())
    y = step.position(state)
    for _ in range(STEPS):
        q, qd = state[:, :dofs], state[:, dofs:]
        observations = torch.cat([q, h * qd, y, targets - y], dim=1)
        actions = actor(normal(observations))
        state = step(state, low + 0.5 * (1.0 + actions.clamp(-1.0, 1.0)) * (high - low))
        before, y = y, step.position(state)
        distance = (targets - y - AHEAD / h * (y - before)).square().sum(1).add(1e-4).sqrt()
        beyond = (actions.abs() - 1.0).clamp(min=0.0).square().sum(1)
        loss = loss + (distance + EFFORT * beyond).mean() / STEPS
    return loss


def train(options: argparse.Namespace) -> tuple[Any, Normaliser, list[Row]]:
    """Train until the goal or the limit of time; return actor, normalisation and curve."""
    torch.set_num_threads(1)
    torch.set_default_dtype(torch.float64)
    torch.manual_seed(options.seed)
    envs, trial = make(ID, ENVS), make(ID, 256)
    first, _ = envs.reset(seed=options.seed)
    inputs, outputs = envs.single_observation_space.shape[0], envs.single_action_space.shape[0]
    actor, normal = network(inputs, outputs, gain=0.01), Normaliser(inputs)
    normal.mean, normal.sd = first.mean(axis=0), np.repeat(SCALES, envs.episodes.batch.q.shape[1])
    rng = np.random.default_rng(options.seed)
    optimiser = torch.optim.Adam(actor.parameters(), RATE)
    decay = torch.optim.lr_scheduler.ExponentialLR(optimiser, DECAY)
    rows, clock, rounds = [], Clock(), 0
    while clock()[options.cpu] < 60.0 * options.minutes:
        optimiser.zero_grad()
        motion_loss(envs, actor, normal, rng).backward()
        torch.nn.utils.clip_grad_norm_(actor.parameters(), 1.0)
        optimiser.step()
        decay.step()
        rounds += 1
        if rounds % EVALUATE_EVERY == 0:
            found = evaluate(trial, actor, normal)
            rows.append(Row(*clock(), rounds * STEPS * ENVS, *found))
            print(rows[-1].text(), flush=True)
            if rows[-1].solved >= options.goal:
                break
    return actor, normal, rows


def main() -> None:
    """Train with the options of the command line."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    add_options(parser)
    options = parser.parse_args()
    actor, normal, rows = train(options)
    save(options.output, make(ID, 1), actor, normal, rows)


if __name__ == "__main__":
    main()
