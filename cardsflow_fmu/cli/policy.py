"""`cardsflow policy`: trained networks as controllers."""

from __future__ import annotations

import argparse
from pathlib import Path

from .common import GOOD, add_json, add_output, add_settings, parse_settings, print_files
from .parser import Commands

_TASKS = ("track", "pose", "reach")
_EXAMPLE = "cardsflow policy export policy.pt examples/planar_2r --task pose -o exported"


def add_policy(commands: Commands) -> None:
    """Add `policy` and its action."""
    text = "Turn trained networks into controllers."
    actions = commands.group("policy", text, _EXAMPLE)
    parser = actions.add(
        "export",
        _export,
        "Build a controller FMU in C from a trained network.",
        _EXAMPLE,
        "The FMU runs without Python. policy.json next to it is for controller.type = 'policy'.",
    )
    parser.add_argument(
        "network",
        type=Path,
        help="state dictionary of PyTorch (.pt, .pth), ONNX (.onnx), or a policy (.json)",
    )
    parser.add_argument("experiment", type=Path, help="an experiment.toml, or its folder")
    parser.add_argument(
        "--task",
        choices=_TASKS,
        default="track",
        help="task of cardsflow_fmu.gym in which the network was trained (default: track)",
    )
    parser.add_argument(
        "--step",
        type=float,
        default=0.02,
        metavar="S",
        help="length of a step of the network, in s (default: 0.02)",
    )
    parser.add_argument(
        "--activation",
        choices=("tanh", "relu", "elu", "sigmoid", "linear"),
        default="tanh",
        help="function of the inner layers of a state dictionary (default: tanh)",
    )
    add_settings(parser)
    add_output(parser, "folder, new or empty", required=True, metavar="FOLDER")
    add_json(parser, "the file names")


def _export(options: argparse.Namespace) -> int:
    from cardsflow_fmu.gym.export import export_network

    files = export_network(
        options.network,
        options.experiment,
        options.output,
        parse_settings(options.set),
        task=options.task,
        step=options.step,
        activation=options.activation,
    )
    print_files(files, options.json)
    return GOOD
