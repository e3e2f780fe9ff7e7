"""Configuration of Sphinx: `uv run --group docs sphinx-build -W docs docs/_build`.

The pages are plain Markdown, which GitHub also displays. They load no files from other sites.
Formulas become MathML, which browsers draw without a library.
"""

from __future__ import annotations

import importlib
import inspect
import re
import sys
from functools import partial
from pathlib import Path
from typing import Any

import latex2mathml.converter
from docutils import nodes
from sphinx.application import Sphinx

DOCS = Path(__file__).resolve().parent
ROOT = DOCS.parent
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
html_show_sphinx = False

default_role = "code"
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
napoleon_attr_annotations = False  # a type such as `str_` would be taken for a link


def whole_page(app: Sphinx, name: str, source: list[str]) -> None:
    """Change a page where Sphinx needs another text than GitHub.

    The index gets a table of contents with the pages that it links to, and the page of names gets
    all public names. Links to files outside `docs` are marked, so that the files are copied.
    """
    text = source[0]
    if name == "index":
        pages = dict.fromkeys(re.findall(r"\]\(([\w/]+)\.(?:md|rst)\)", text))
        text += "\n".join(("\n```{toctree}", ":hidden:", *pages, "```\n"))
    text = re.sub(r"^\.\. names:: (\w[\w.]*)$", public_names, text, flags=re.MULTILINE)
    source[0] = re.sub(r"(!\[[^\]]*)?\]\((\.\./[^)\s]*)\)", partial(link_out_of_docs, name), text)


def link_out_of_docs(page: str, match: re.Match[str]) -> str:
    """Mark a link to a file outside `docs`, which Sphinx then copies to the pages."""
    image, target = match.groups()
    file = (DOCS / page).parent / target.partition("#")[0]
    if image or DOCS in file.resolve().parents:
        return match[0]
    return f"](path:{target})"


def public_names(match: re.Match[str]) -> str:
    """Return the directives for all classes and functions of a package."""
    package = match[1]
    module = importlib.import_module(package)
    lines = []
    for name in module.__all__:
        member = getattr(module, name)
        if inspect.isclass(member):
            lines += [f".. autoclass:: {package}.{name}", "   :members:", "   :no-index:", ""]
        elif inspect.isfunction(member):
            lines += [f".. autofunction:: {package}.{name}", "   :no-index:", ""]
    return "\n".join(lines)


def plain_docstring(
    app: Sphinx, kind: str, name: str, member: Any, options: Any, lines: list[str]
) -> None:
    """Escape characters that are markup in reStructuredText: |x|, a * b, a trailing _."""
    for k, line in enumerate(lines):
        parts = re.split(r"(`[^`]*`)", line)
        parts[::2] = [re.sub(r"([|*]|_\b)", r"\\\1", part) for part in parts[::2]]
        lines[k] = "".join(parts)


def mathml(translator: Any, node: nodes.Element) -> None:
    """Return a formula as MathML."""
    is_block = isinstance(node, nodes.math_block)
    display = "block" if is_block else "inline"
    formula = latex2mathml.converter.convert(node.astext(), display=display)
    translator.body.append(f"<div>{formula}</div>" if is_block else formula)
    raise nodes.SkipNode


def setup(app: Sphinx) -> None:
    """Connect the functions above to the events of Sphinx."""
    app.connect("source-read", whole_page)
    app.connect("autodoc-process-docstring", plain_docstring, priority=100)
    app.add_html_math_renderer("mathml", (mathml, None), (mathml, None))


html_math_renderer = "mathml"
