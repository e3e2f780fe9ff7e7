"""Readers for networks in files of PyTorch and ONNX."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from addin_sdfusion.robot import InputError
from addin_sdfusion.robot.files import file_error
from cardsflow_fmu.utils.arrays import FloatArray

Pair = tuple[FloatArray, FloatArray]

_FUNCTIONS = {"Tanh": "tanh", "Relu": "relu", "Elu": "elu", "Sigmoid": "sigmoid"}
_IGNORED = ("Flatten", "Identity", "Cast")


def layer_pairs(layers: Sequence[tuple[Any, Any]] | Mapping[str, Any]) -> list[Pair]:
    """Return weights and bias of each layer."""
    if isinstance(layers, Mapping):
        values = [np.asarray(value, dtype=np.float64) for value in layers.values()]
        layers = list(zip(values[::2], values[1::2], strict=False))
        if 2 * len(layers) != len(values):
            raise InputError(f"a state dictionary must have weights and biases, not {len(values)}")
    if not layers:
        raise InputError("the network has no layers")
    try:
        return [(np.asarray(weights, float), np.asarray(bias, float)) for weights, bias in layers]
    except (TypeError, ValueError):
        raise InputError("each layer must be a pair of weights and bias, of numbers") from None


def read_network(file: Path) -> tuple[list[Pair], list[str]]:
    """Return the layers of a network in a file, and their functions.

    Args:
        file: State dictionary of PyTorch (.pt, .pth), whose functions are unknown, so that the list
            is empty; or ONNX (.onnx) with layers Gemm or MatMul and Add.

    Raises:
        InputError: The file cannot be read, its package is missing, or it has other layers.
    """
    if file.suffix in (".pt", ".pth"):
        return _read_torch(file), []
    if file.suffix == ".onnx":
        return _read_onnx(file)
    raise InputError("is not a network; known file types: .pt, .pth, .onnx, .json", file=file)


def _loaded(file: Path, package: str, kind: str, load: Callable[[Any], Any]) -> Any:
    """Return what `load` reads from a file with a package."""
    try:
        module = importlib.import_module(package)
    except ImportError:
        raise InputError(f"needs the package {package}", file=file) from None
    try:
        return load(module)
    except OSError as error:
        raise file_error(error, "cannot be read", file) from None
    except Exception as error:  # the packages raise many kinds
        text = repr(error).partition("\\n")[0]
        raise InputError(f"is not {kind}: {text}", file=file) from None


def _read_torch(file: Path) -> list[Pair]:
    def load(torch: Any) -> dict[str, Any]:
        state = torch.load(file, map_location="cpu", weights_only=True)
        return {name: value.double().numpy() for name, value in state.items()}

    return layer_pairs(_loaded(file, "torch", "a state dictionary", load))


def _read_onnx(file: Path) -> tuple[list[Pair], list[str]]:
    graph = _loaded(file, "onnx", "an ONNX file", lambda onnx: onnx.load(file).graph)
    import onnx

    tensors = {t.name: np.array(onnx.numpy_helper.to_array(t), float) for t in graph.initializer}
    pairs: list[Pair] = []
    functions: list[str] = []
    for node in graph.node:
        constants = [tensors[name] for name in node.input if name in tensors]
        if node.op_type == "Gemm" and len(constants) == 2:
            settings = {a.name: onnx.helper.get_attribute_value(a) for a in node.attribute}
            weights = constants[0] if settings.get("transB") else constants[0].T
            scales = settings.get("alpha", 1.0), settings.get("beta", 1.0)
            pairs.append((scales[0] * weights, scales[1] * constants[1]))
        elif node.op_type == "MatMul" and len(constants) == 1:
            pairs.append((constants[0].T, np.zeros(constants[0].shape[1])))
        elif node.op_type == "Add" and len(constants) == 1 and pairs:
            pairs[-1] = pairs[-1][0], pairs[-1][1] + constants[0]
            continue
        elif node.op_type in _FUNCTIONS and pairs:
            functions[-1] = _FUNCTIONS[node.op_type]
            continue
        elif node.op_type in _IGNORED:
            continue
        else:
            problem = "only Gemm, MatMul, Add and functions of layers are supported"
            raise InputError(f"contains {node.op_type} ({node.name!r}); {problem}", file=file)
        functions.append("linear")
    if len({*functions[:-1]}) > 1:
        raise InputError(f"inner layers have different functions: {functions[:-1]}", file=file)
    return layer_pairs(pairs), functions
