"""Check that the content of a mesh file matches the format of its suffix."""

from __future__ import annotations

import json
import re
import struct
from collections.abc import Callable
from typing import Any
from xml.parsers import expat

from . import limits
from .collada_scene import ColladaScene

_BINARY_HEAD, _BINARY_FACET = 84, 50
_STL_WORDS = rb"solid|facet|outer|vertex|endloop|endfacet|endsolid|color"
_NOT_FINITE = "it has vertices that are not finite"
_OBJ_WORDS = rb"v|vt|vn|vp|f|l|p|o|g|s|mg|usemtl|mtllib|usemap|maplib|cstype|deg|end|#.*"
_GLB_HEAD, _GLB_CHUNK = struct.Struct("<4sII"), struct.Struct("<I4s")


def mesh_problem(suffix: str, data: bytes) -> str | None:
    """Return the reason why a file is not a usable mesh, or None.

    A mesh that requires other files is rejected, since they would not be copied.
    """
    test = _TESTS.get(suffix.lower())
    if test is None:
        return f"{suffix or 'no suffix'!s} is not a mesh type; known: {', '.join(_TESTS)}"
    try:
        return _size_problem(suffix.lower(), data) or test(data)
    except (ValueError, RecursionError, struct.error, expat.ExpatError) as error:
        return f"it is not a {suffix} mesh: {error}"


def _size_problem(suffix: str, data: bytes) -> str | None:
    """Return the reason why reading would require too much memory, or None."""
    if len(data) > limits.MESH:
        return limits.too_large(limits.MESH)
    if not _is_text(suffix, data):
        return None
    if len(data) > limits.MESH_TEXT:
        return f"{limits.too_large(limits.MESH_TEXT)}, the limit for text meshes"
    if suffix == ".dae":
        return limits.xml_fault(data)
    if max(map(len, data.splitlines()), default=0) >= limits.MESH_LINE:
        return f"it has a line of more than {limits.MESH_LINE} bytes"
    return None


def _is_text(suffix: str, data: bytes) -> bool:
    if suffix == ".stl":
        return not _is_binary_stl(data)
    return suffix in (".obj", ".off", ".dae") or (
        suffix == ".ply" and b"format ascii" in data[:999]
    )


def _is_binary_stl(data: bytes) -> bool:
    if len(data) <= _BINARY_HEAD:
        return False
    (facets,) = struct.unpack_from("<I", data, _BINARY_HEAD - 4)
    return bool(len(data) == _BINARY_HEAD + facets * _BINARY_FACET)


def _stl(data: bytes) -> str | None:
    if _is_binary_stl(data):
        return _binary_corners(data)
    if b"\0" in data[:_BINARY_HEAD] and data[80:_BINARY_HEAD].strip(b"\0"):
        (facets,) = struct.unpack_from("<I", data, _BINARY_HEAD - 4)
        actual = (len(data) - _BINARY_HEAD) / _BINARY_FACET
        numbers = f"its header specifies {facets} facets, but it contains {actual:g}"
        return f"it is not a .stl mesh: {numbers}"
    return _parts_problem(data, b"solid") or _lines(data, ".stl", _STL_WORDS, b"solid", b"vertex")


def _binary_corners(data: bytes) -> str | None:
    """Report vertices of a binary STL that are not finite or exceed 1.7e38, by their exponents.

    Normals are not checked, since programs recompute them.
    """
    for last in range(_BINARY_HEAD + 15, _BINARY_HEAD + _BINARY_FACET - 2, 4):
        exponents = data[last::_BINARY_FACET]
        if b"\x7f" in exponents or b"\xff" in exponents:
            return _NOT_FINITE
    return None


def _obj(data: bytes) -> str | None:
    return _parts_problem(data, b"o|g|usemtl") or _lines(data, ".obj", _OBJ_WORDS, b"v", b"f")


def _parts_problem(data: bytes, words: bytes) -> str | None:
    """Return the reason why text has too many lines that begin a part with one of `words`."""
    if sum(1 for _ in re.finditer(rb"(?im)^[ \t]*(?:" + words + rb")\s", data)) > limits.MESH_NODES:
        return f"it has more than {limits.MESH_NODES} parts"
    return None


def _lines(data: bytes, kind: str, words: bytes, *needed: bytes) -> str | None:
    """Check text whose lines must begin with one of `words`, with a line for each of `needed`."""
    unexpected = re.search(rb"(?im)^[ \t]*(?!(?:" + words + rb")(?:\s|$))[^\s]", data)
    if unexpected is not None:
        line = data.count(b"\n", 0, unexpected.start()) + 1
        return f"it is not a {kind} mesh: line {line} has an unexpected keyword"
    for word in needed:
        if not re.search(rb"(?im)^[ \t]*" + word + rb"\s", data):
            return f"it is not a {kind} mesh: no line begins with {word.decode()}"
    if re.search(rb"(?im)^[ \t]*v(?:ertex)?[ \t][^\n#]*\b(?:nan|inf(?:inity)?)\b", data):
        return _NOT_FINITE
    return None


def _ply(data: bytes) -> str | None:
    head, end, _ = data[:65536].partition(b"end_header")
    lines = head.split(b"\n")
    parts = [line.strip().split(b" ")[:2] for line in lines]
    if lines[0].strip() != b"ply" or not end:
        return "it is not a .ply mesh: its header is invalid"
    if [b"element", b"vertex"] not in parts or [b"element", b"face"] not in parts:
        return "it is not a .ply mesh: it has no faces"
    return None


def _off(data: bytes) -> str | None:
    text = re.sub(rb"#[^\n]*", b"", data).strip()
    if not text.startswith(b"OFF") or text.translate(None, b"0123456789+-.eE \t\r\n") != b"OFF":
        return "it is not a .off mesh: it contains characters that are not part of numbers"
    return None


def _glb(data: bytes) -> str | None:
    magic, _, length = _GLB_HEAD.unpack_from(data)
    size, kind = _GLB_CHUNK.unpack_from(data, _GLB_HEAD.size)
    if magic != b"glTF" or length != len(data) or kind != b"JSON":
        return "it is not a .glb mesh: its header is invalid"
    begin = _GLB_HEAD.size + _GLB_CHUNK.size
    return _scene(json.loads(data[begin : begin + size]), ".glb")


def _scene(scene: Any, kind: str) -> str | None:
    """Check the scene in a glTF file."""
    if not isinstance(scene, dict) or not scene.get("asset") or not scene.get("meshes"):
        return f"it is not a {kind} mesh: it has no faces"
    resources = [*(scene.get("buffers") or ()), *(scene.get("images") or ())]
    for resource in resources:
        uri = resource.get("uri", "data:") if isinstance(resource, dict) else ""
        if not str(uri).startswith("data:"):
            return f"it requires another file, {str(uri)[:80]!r}; save it as one .glb file"
    return _scene_size_problem(scene)


def _scene_size_problem(scene: dict[str, Any]) -> str | None:
    """Return the reason why a glTF scene is invalid or has too many mesh instances, or None."""
    lists = (scene.get(key) or [] for key in ("nodes", "meshes", "accessors", "scenes"))
    nodes, meshes, accessors, scenes = lists
    try:
        children = [child for node in nodes for child in node.get("children") or ()]
        if len(set(children)) < len(children):
            return "it has a node with two parents"
        if _is_deep([node.get("children") or () for node in nodes]):
            return (
                f"it has more than {limits.MESH_NODES} nodes, or more than {limits.MESH_DEPTH} "
                "nested ones"
            )
        if any("bufferView" not in one or "sparse" in one for one in accessors):
            return "it has accessors without a buffer"
        if any(type(one["count"]) is not int or one["count"] < 0 for one in accessors):
            return "it has accessors with an invalid count"
        primitives = [mesh.get("primitives") or () for mesh in meshes]
        sizes = [
            sum(
                accessors[index]["count"]
                for primitive in group
                for index in (*primitive["attributes"].values(), primitive.get("indices"))
                if index is not None
            )
            for group in primitives
        ]
        placed = [node["mesh"] for node in nodes if "mesh" in node]
        numbers = sum(sizes[mesh] for mesh in placed), sum(one["count"] for one in accessors)
        pieces = [sum(map(len, primitives)), sum(len(primitives[mesh]) for mesh in placed)]
        pieces += [sum(len(one.get("nodes") or ()) for one in scenes)]
    except (AttributeError, KeyError, IndexError, TypeError) as error:
        raise ValueError(f"its scene is damaged ({error!r})") from None
    if max(sum(sizes), *numbers) > limits.MESH_NUMBERS:
        return f"its meshes have more than {limits.MESH_NUMBERS} vertices and indices"
    if max(pieces) > limits.MESH_NODES:
        return f"its scene has more than {limits.MESH_NODES} parts"
    return None


def _is_deep(children: list[Any]) -> bool:
    """Return whether there are too many nodes, too many nested nodes, or a cycle of nodes."""
    if len(children) > limits.MESH_NODES:
        return True
    parents = {child: k for k, siblings in enumerate(children) for child in siblings}
    row: list[int | None] = list(range(len(children)))
    for _ in range(limits.MESH_DEPTH):
        row = [parents.get(k) for k in row if k is not None]
    return any(k is not None for k in row)


_TESTS: dict[str, Callable[[bytes], str | None]] = {
    ".stl": _stl,
    ".obj": _obj,
    ".dae": lambda data: ColladaScene(data).fault(),
    ".ply": _ply,
    ".glb": _glb,
    ".gltf": lambda data: _scene(json.loads(data), ".gltf"),
    ".off": _off,
}
