"""C sources in native FMUs, to be compiled for other platforms."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from functools import cache

from addin_sdfusion.robot import InputError
from cardsflow_fmu.runtime.sources import FLAGS, NATIVE, ROOT

from .description import FmiVersion, xml_bytes

_OPTIONS = " ".join(FLAGS)
_README = """\
The sources of this FMU's binaries, for FMI 2.0 and FMI 3.0 alike. In this folder, on Linux:

    gcc {options} -fPIC -shared -o ../binaries/{folder}/{name}.so \\
        $(find . -name '*.c') -lm

The plant's directional derivatives use C99's complex numbers. Without them, as with Microsoft's
compiler, the FMU has no derivatives.

-ffp-contract=off keeps a compiler from fusing multiplications and additions: with it every
platform computes the same bits. The functions of FMI keep their plain names, for a shared library.
"""


def source_files(model_name: str, fmi: FmiVersion) -> dict[str, bytes]:
    """Return the contents of the source files, by path in the FMU."""
    folder = "linux64" if fmi == "2.0" else "x86_64-linux"
    text = _README.format(options=_OPTIONS, folder=folder, name=model_name)
    files = dict(_contents())
    if fmi == "3.0":
        files["buildDescription.xml"] = _build_description(model_name)
    files["README.txt"] = text.encode()
    return {f"sources/{name}": contents for name, contents in files.items()}


@cache
def _contents() -> dict[str, bytes]:
    """Return the sources and headers of every native FMU."""
    names = [*NATIVE.sources(), *NATIVE.headers()]
    try:
        return {name: (ROOT / name).read_bytes() for name in names}
    except OSError:
        raise InputError("the C sources are missing; install the package again") from None


def compiled_files() -> list[str]:
    """Return the C files to compile, relative to the FMU's sources."""
    return NATIVE.sources()


def _build_description(model_name: str) -> bytes:
    root = ET.Element("fmiBuildDescription", fmiVersion="3.0")
    configuration = ET.SubElement(root, "BuildConfiguration", modelIdentifier=model_name)
    files = ET.SubElement(configuration, "SourceFileSet", language="C99")
    files.set("compiler", "gcc")
    files.set("compilerOptions", _OPTIONS)
    for name in compiled_files():
        ET.SubElement(files, "SourceFile", name=name)
    ET.SubElement(configuration, "Library", name="m", description="On Linux: sqrt, floor, fmod")
    return xml_bytes(root)
