"""Sphinx makes pages of docs/: `uv run --group docs sphinx-build -W docs docs/_build`.

The pages are plain Markdown, which reads on GitHub as well; nothing in them is loaded from elsewhere
when they are built or read. Formulas become MathML, which browsers draw by themselves.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import Any

import latex2mathml.converter
from docutils import nodes
from sphinx.application import Sphinx

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))

from cardsflow_fmu.version import __version__  # noqa: E402

project = "CARDSFlow"
copyright = "the CARDSFlow authors"  # noqa: A001
version = release = __version__

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
exclude_patterns = ["_build"]
myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 4
html_theme = "furo"
html_title = f"CARDSFlow {version}"
html_extra_path = ["addin.html"]
html_show_sphinx = False

default_role = "code"
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
nitpicky = False


def listed_pages(app: Sphinx, name: str, source: list[str]) -> None:
    """Give the index a table of contents of the pages that it links to, in its order."""
    if name == "index":
        pages = dict.fromkeys(re.findall(r"\]\(([\w/]+)\.(?:md|rst)\)", source[0]))
        source[0] += "\n".join(("\n```{toctree}", ":hidden:", *pages, "```\n"))


def plain_docstring(
    app: Sphinx, what: str, name: str, thing: Any, options: Any, lines: list[str]
) -> None:
    """Keep what our docstrings say from being taken for markup: `|x|`, `J'q'`, formulas, `a * b`."""
    for k, line in enumerate(lines):
        parts = re.split(r"(`[^`]*`)", line)
        parts[::2] = [re.sub(r"([|*_])", r"\\\1", part) for part in parts[::2]]
        lines[k] = "".join(parts)


def mathml(translator: Any, node: nodes.Element) -> None:
    """A formula as MathML."""
    is_block = isinstance(node, nodes.math_block)
    display = "block" if is_block else "inline"
    formula = latex2mathml.converter.convert(node.astext(), display=display)
    translator.body.append(f"<div>{formula}</div>" if is_block else formula)
    raise nodes.SkipNode


def setup(app: Sphinx) -> None:
    """Called by Sphinx."""
    app.connect("source-read", listed_pages)
    app.connect("autodoc-process-docstring", plain_docstring, priority=100)
    app.add_html_math_renderer("mathml", (mathml, None), (mathml, None))


html_math_renderer = "mathml"
