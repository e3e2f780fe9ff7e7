"""Reader for STEP files: the tree of components with names, poses and colors."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from addin_sdfusion.robot import InputError, limits
from addin_sdfusion.robot.files import open_file
from addin_sdfusion.robot.model.transform import IDENTITY

from .assembly import Part
from .kernel import MILLIMETRE, kernel, transform

_HEAD = 64 * limits.KIB
_MAX_DEPTH = 100


def read_step(file: Path) -> tuple[str, tuple[Part, ...]]:
    """Read the parts in a STEP file, in millimetres.

    Returns:
        Name of the assembly (empty for an unnamed assembly or several roots), and its parts.
    """
    with open_file(file, limits.STEP) as stream:
        head = stream.read(_HEAD)
    if not head.lstrip().startswith(b"ISO-10303-21"):
        raise InputError("is not a STEP file: it does not begin with ISO-10303-21", file=file)
    document = _document(file)
    shapes = kernel("XCAFDoc").XCAFDoc_DocumentTool.ShapeTool_s(document.Main())
    colors = kernel("XCAFDoc").XCAFDoc_DocumentTool.ColorTool_s(document.Main())
    reader = _PartReader(file, shapes, colors)
    free = list(_labels(shapes.GetFreeShapes))
    if len(free) == 1 and shapes.IsAssembly_s(free[0]):
        return _name(free[0]), reader.children(free[0], 0)
    return "", tuple(reader.part(label, 0) for label in free)


def _document(file: Path) -> Any:
    """Return the document that the kernel reads; its messages are not printed."""
    messenger = kernel("Message").Message.DefaultMessenger_s()
    printers = list(messenger.Printers())
    for printer in printers:
        messenger.RemovePrinter(printer)
    try:
        text = kernel("TCollection").TCollection_ExtendedString("XDE")
        document = kernel("TDocStd").TDocStd_Document(text)
        reader = kernel("STEPCAFControl").STEPCAFControl_Reader()
        for choose in (reader.SetNameMode, reader.SetColorMode):
            choose(True)
        status = reader.ReadFile(str(file))
        done = kernel("IFSelect").IFSelect_ReturnStatus.IFSelect_RetDone
        if status != done or not reader.Transfer(document):
            raise InputError("cannot be read as a STEP file", file=file)
    except InputError:
        raise
    except Exception as error:  # errors of the kernel have no common base class
        problem = " ".join(str(error).split())
        raise InputError(f"cannot be read as a STEP file: {problem}", file=file) from error
    finally:
        for printer in printers:
            messenger.AddPrinter(printer)
    return document


class _PartReader:
    def __init__(self, file: Path, shapes: Any, colors: Any) -> None:
        self._file = file
        self._shapes = shapes
        self._colors = colors

    def children(self, label: Any, depth: int) -> tuple[Part, ...]:
        """Return the parts of an assembly."""
        if depth > _MAX_DEPTH:
            raise InputError(
                f"its assemblies are nested more than {_MAX_DEPTH} levels deep", file=self._file
            )
        components = _labels(lambda into: self._shapes.GetComponents_s(label, into))
        return tuple(self.part(component, depth + 1) for component in components)

    def part(self, label: Any, depth: int) -> Part:
        """Return an instance of a component."""
        tool, component = self._shapes, label
        if tool.IsReference_s(label):
            component = kernel("TDF").TDF_Label()
            tool.GetReferredShape_s(label, component)
        name = _name(component) or _name(label) or "part"
        is_assembly = tool.IsAssembly_s(component)
        shape = tool.GetShape_s(component)
        T = tool.GetLocation_s(label).Transformation()
        color, opacity = (None, 1.0) if is_assembly else self._color(label, component, shape)
        try:
            placed = transform(T, MILLIMETRE) if tool.IsReference_s(label) else IDENTITY
        except ValueError as error:
            raise InputError(f"invalid pose of part {name!r}: {error}", file=self._file) from None
        return Part(
            name,
            placed,
            None if is_assembly else shape,
            self.children(component, depth) if is_assembly else (),
            _name(label),
            color=color,
            opacity=opacity,
        )

    def _color(self, label: Any, component: Any, shape: Any) -> tuple[str | None, float]:
        """Return the color of the instance, or of the component, or of the shape."""
        color = kernel("Quantity").Quantity_ColorRGBA()
        tool, kinds = kernel("XCAFDoc").XCAFDoc_ColorTool, kernel("XCAFDoc").XCAFDoc_ColorType
        for kind in (kinds.XCAFDoc_ColorSurf, kinds.XCAFDoc_ColorGen):
            if (
                tool.GetColor_s(label, kind, color)
                or tool.GetColor_s(component, kind, color)
                or self._colors.GetColor(shape, kind, color)
            ):
                text = kernel("Quantity").Quantity_Color.ColorToHex_s(color.GetRGB())
                return str(text.ToCString()).lower(), float(color.Alpha())
        return None, 1.0


def _labels(fill: Any) -> Iterator[Any]:
    labels = kernel("collections").Sequence_TDF_Label()
    fill(labels)
    for i in range(1, labels.Length() + 1):
        yield labels.Value(i)


def _name(label: Any) -> str:
    name = kernel("TDataStd").TDataStd_Name()
    if not label.FindAttribute(kernel("TDataStd").TDataStd_Name.GetID_s(), name):
        return ""
    text = str(name.Get().ToExtString())
    if text.startswith("=>"):  # the kernel generates this for an instance without a name
        return ""
    return "".join(sign for sign in text if sign.isprintable()).strip()
