"""Merging of nested and included models of an SDF file into one model."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from lxml import etree

from ...errors import InputError
from ...finding import Subject
from ...mesh_files import is_file
from ..reading.xml import TRUE, Node, parse, short_repr
from .names import MODEL_FRAME

_SEPARATOR = "::"  # SDF's separator between the name of a model and the name of a part
_MAX_DEPTH = 20
_MAX_FILES = 50
_PARTS = ("link", "joint", "frame")
_NAMING = ("relative_to", "attached_to", "expressed_in", "frame")


def included_models(place: Node, depth: int = 0) -> list[Node]:
    """Return the models in `<include>` elements, with the changes made by these elements.

    An element without a valid model is reported as an error.
    """
    return [model for node in place.all("include") if (model := _included(node, depth)) is not None]


def flatten(model: Node, depth: int = 0) -> None:
    """Merge nested models into a model: `gripper::palm` becomes `gripper_palm`.

    The frames of the nested models become frames of the model, and poses refer to them.
    """
    inner = [*model.all("model"), *included_models(model, depth)]
    if not inner:
        return
    if depth >= _MAX_DEPTH:
        inner[0].error("nested-too-deep", f"models are nested in more than {_MAX_DEPTH} levels")
        return
    for node in inner:
        flatten(node, depth + 1)
        _merge_model(model.element, node)
        if node.element.getparent() is model.element:
            model.element.remove(node.element)
    if depth == 0:
        _rename(model)


def _merge_model(outer: etree._Element, model: Node) -> None:
    """Move the parts of a nested model to the outer model, with prefixed names."""
    name = model.attribute("name")
    merged = model.attribute("merge", "false") in TRUE
    if model.attribute("placement_frame", ""):
        model.error("unsupported-element", "placement_frame of a nested model is not supported")
    for plugin in model.all("plugin"):
        plugin.warning("plugin-left-out", f"plugins of the nested model {name!r} are omitted")
    first = next((part.attribute("name", "") for part in model.all("link")), "")
    carrier = model.attribute("canonical_link", "") or first
    if not first:
        model.error("no-links", f"the nested model {name!r} has no links")
    frame_name = f"_merged__{name}{MODEL_FRAME}" if merged else name
    prefix = "" if merged else f"{name}{_SEPARATOR}"
    frame = etree.SubElement(outer, "frame", name=frame_name, attached_to=f"{prefix}{carrier}")
    pose = model.optional("pose")
    frame.append(etree.Element("pose") if pose is None else pose.element)
    if not frame[0].get("relative_to"):
        frame[0].set("relative_to", MODEL_FRAME)
    for part in model.all(*_PARTS):
        _prefix_names(part.element, prefix, frame_name)
        outer.append(part.element)


def _prefix_names(part: etree._Element, prefix: str, frame: str) -> None:
    """Prefix the names in a part, and make implicit references to its model explicit."""

    def full_name(name: str) -> str:
        return frame if name == MODEL_FRAME else name if name == "world" else prefix + name

    part.set("name", prefix + part.get("name", ""))
    for element in part.iter():
        for key in _NAMING:
            if element.get(key):
                element.set(key, full_name(element.get(key, "")))
    for element in part.iter("mimic"):
        if element.get("joint"):
            element.set("joint", full_name(element.get("joint", "")))
    if part.tag == "joint":
        for element in part.iterchildren("parent", "child"):
            element.text = full_name((element.text or "").strip())
        return
    if part.tag == "frame" and not part.get("attached_to"):
        part.set("attached_to", frame)
    if part.tag == "link" or part.get("attached_to") == frame:
        pose = part.find("pose")
        if pose is None:
            pose = etree.SubElement(part, "pose")
        if not (pose.get("frame") or pose.get("relative_to")):
            pose.set("relative_to", frame)


def _rename(model: Node) -> None:
    """Replace `::` in names, which SDF does not allow in written files; names stay unique."""
    parts = [part.element for part in model.all(*_PARTS)]
    names = {part.get("name", "") for part in parts}
    plain = {name for name in names if _SEPARATOR not in name}
    short = {name: name.replace(_SEPARATOR, "_") for name in names - plain}
    if len(plain | set(short.values())) < len(names):
        short = {name: name.replace(_SEPARATOR, "__") for name in short}
    for part in parts:
        for element in part.iter():
            for key in (*_NAMING, "name", "joint"):
                if element.get(key) in short:
                    element.set(key, short[element.get(key, "")])
            if element.tag in ("parent", "child") and (element.text or "").strip() in short:
                element.text = short[(element.text or "").strip()]
    models = sorted({name.partition(_SEPARATOR)[0] for name in short})
    if models:
        example = min(short)
        named = ", ".join(map(repr, models[:10]))
        model.warning(
            "nested-model",
            f"nested models are merged: {named}; {example!r} becomes {short[example]!r}",
        )


def _included(node: Node, depth: int) -> Node | None:
    uri = node.required("uri")
    if uri is None:
        return None
    if depth >= _MAX_DEPTH or len(node.notes.files) > _MAX_FILES:
        node.error("nested-too-deep", f"includes exceed {_MAX_DEPTH} levels or {_MAX_FILES} files")
        return None
    file = _file(uri.text, node.file.parent)
    if file is None:
        problem = f"{short_repr(uri.text)} does not exist in this folder or next to it"
        node.error("include-not-found", f"{problem}; copy the model there (no downloads)")
        return None
    try:
        root = parse(file, Subject("robot", file.stem), node.notes)
    except InputError as error:
        node.error("include-not-read", f"{short_repr(uri.text)}: {error}")
        return None
    models = [*root.all("model"), *included_models(root, depth + 1)]
    if root.tag != "sdf" or len(models) != 1:
        node.error(
            "not-one-model", f"{short_repr(uri.text)} contains {len(models)} models, not one"
        )
        return None
    _place_meshes(models[0].element, file.parent, node.file.parent)
    return _override_model(replace(models[0], file=node.file), node)


def _override_model(model: Node, include: Node) -> Node:
    """Return an included model with the name and pose of the `<include>` element."""
    name, pose = include.optional("name"), include.optional("pose")
    if name is not None:
        model.element.set("name", name.text)
    if pose is not None:
        for old in list(model.element.iterchildren("pose")):
            model.element.remove(old)
        model.element.append(pose.element)
    for key in ("merge", "placement_frame"):
        value = include.element.get(key) or include.element.findtext(key)
        if value:
            model.element.set(key, value.strip())
    return model


def _file(uri: str, folder: Path) -> Path | None:
    """Return the model file of a URI, in the robot folder or in a folder next to it."""
    for place in _places(uri, folder):
        if is_file(place):
            return place
        try:
            files = sorted(place.glob("*.sdf"))
        except (OSError, ValueError):
            continue
        named = [file for file in files if file.name == "model.sdf"] or files[-1:]
        if named:
            return named[0]
    return None


def _places(uri: str, folder: Path) -> Iterator[Path]:
    scheme, separator, rest = uri.partition("://")
    if not separator:
        scheme, rest = "", uri
    path = Path(rest)
    if scheme not in ("", "model", "file") or path.is_absolute() or ".." in path.parts or not rest:
        return
    yield folder / path
    if scheme == "model":
        yield folder.parent / path


def _place_meshes(model: etree._Element, source: Path, target: Path) -> None:
    """Make mesh paths relative to the folder of the including file."""
    for uri in model.iter("uri"):
        text = (uri.text or "").strip()
        if text and "://" not in text and not Path(text).is_absolute():
            uri.text = Path(os.path.relpath(source / text, target)).as_posix()
