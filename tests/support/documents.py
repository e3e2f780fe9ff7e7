"""Blocks of code, links and anchors of README.md and docs/."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]

NOT_RUN = "not run: "
"""Reason why a block cannot run in a test. All these words are in a comment before a block."""
RUN_WITH = "run with: "
"""Options that are added to every `cardsflow run`, such as a shorter duration."""
CONTINUES = "continues"
"""The Python block continues the previous one."""
UNTIL_INTERRUPTED = "run until Ctrl-C"
"""The command prints its address and continues until it is interrupted."""
SIDE_BY_SIDE = "run side by side"
"""Each line runs in a separate terminal; only the last command ends by itself."""
PART_OF = "part of: "
"""The tables replace tables of the experiment of that example."""
PATCH = "patch"
"""The block is a patch of this source tree."""


@dataclass(frozen=True)
class Block:
    """A block of code.

    Attributes:
        file, line: Its beginning.
        language: Word after the fence; empty if missing.
        text: Its content.
        note: Comment for tests directly before it; empty if missing.
    """

    file: Path
    line: int
    language: str
    text: str
    note: str

    def __str__(self) -> str:
        return f"{self.file.relative_to(ROOT)}:{self.line}"

    def argument(self, what: str) -> str | None:
        """Return the text of the note after one of the words above, or None."""
        return self.note.removeprefix(what).strip() if self.note.startswith(what) else None


def pages() -> list[Path]:
    """Return the Markdown pages of `docs`."""
    built = ROOT / "docs/_build"
    return sorted(file for file in (ROOT / "docs").rglob("*.md") if built not in file.parents)


def documents() -> list[Path]:
    """Return the README and all pages of `docs`."""
    return [ROOT / "README.md", *pages()]


def all_documents() -> list[Path]:
    """Return all documents, including those in other folders."""
    others = [ROOT / name for name in ("CONTRIBUTING.md", "CHANGELOG.md", "SECURITY.md")]
    return [*documents(), *others, *example_documents()]


def example_documents() -> list[Path]:
    """Return the documents of the examples."""
    return sorted((ROOT / "examples").glob("*/README.md"))


_FENCED = re.compile(
    r"^(?:[ ]*<!-- (?P<note>[^\n]*?) -->\n\n?)?"
    r"^(?P<indent>[ ]*)```(?P<language>[^\n]*)\n(?P<text>.*?)^(?P=indent)```[ ]*$",
    re.MULTILINE | re.DOTALL,
)


def blocks(file: Path) -> Iterator[Block]:
    """Return all blocks of code of a document, in order."""
    text = file.read_text(encoding="utf-8")
    for match in _FENCED.finditer(text):
        line = text.count("\n", 0, match.start("text")) + 1
        yield Block(file, line, match["language"].strip(), match["text"], match["note"] or "")


def prose(file: Path) -> str:
    """Return a document without its blocks of code; line numbers do not change."""
    text = file.read_text(encoding="utf-8")
    return _FENCED.sub(lambda match: "\n" * match[0].count("\n"), text)


def links(file: Path) -> Iterator[tuple[int, str]]:
    """Yield line and target of every link and picture."""
    text = prose(file)
    for match in re.finditer(r"\]\(([^()\s]+(?:\([^()\s]*\))?)\)|<img[^>]*src=\"([^\"]+)\"", text):
        yield text.count("\n", 0, match.start()) + 1, match[1] or match[2]


def inline_code(file: Path) -> Iterator[tuple[int, str]]:
    """Yield line and content of all inline code."""
    text = prose(file)
    for match in re.finditer(r"(?<!`)`([^`\n]+)`", text):
        yield text.count("\n", 0, match.start()) + 1, match[1]


def anchors(file: Path) -> set[str]:
    """Return the anchors of a document: its headings in the form of GitHub."""
    if file.suffix != ".md":
        return set(re.findall(r'id="([^"]+)"', file.read_text(encoding="utf-8")))
    found: dict[str, int] = {}
    names = set()
    for heading in re.findall(r"^#{1,6} +(.+?)\s*#*$", prose(file), re.MULTILINE):
        plain = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading)
        name = re.sub(r"[^\w\- ]", "", plain.lower()).replace(" ", "-")
        count = found.get(name, 0)
        found[name] = count + 1
        names.add(f"{name}-{count}" if count else name)
    return names
