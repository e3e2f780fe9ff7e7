"""README.md and docs/ taken apart: blocks of code, links, anchors."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]

NOT_RUN = "not run: "
"""Why a block cannot run in a test; in a comment before it, as the others."""
RUN_WITH = "run with: "
"""What is added to every `cardsflow run`, such as a shorter duration."""
CONTINUES = "continues"
"""The Python block continues where the one before it ended."""
UNTIL_INTERRUPTED = "run until Ctrl-C"
"""The command continues until it is interrupted, once it has printed its address."""
SIDE_BY_SIDE = "run side by side"
"""Every line has a terminal of its own; the last one ends by itself."""
PART_OF = "part of: "
"""The tables stand in the place of those of that example's experiment."""
PATCH = "patch"
"""The change applies to this source tree."""


@dataclass(frozen=True)
class Block:
    """A block of code.

    Attributes:
        file, line: Where it begins.
        language: As written behind the fence; empty for none.
        text: What it holds.
        note: What the comment right before it says to tests; empty without one.
    """

    file: Path
    line: int
    language: str
    text: str
    note: str

    def __str__(self) -> str:
        return f"{self.file.relative_to(ROOT)}:{self.line}"

    def argument(self, what: str) -> str | None:
        """What the note says behind one of the words above; None if it does not."""
        return self.note.removeprefix(what).strip() if self.note.startswith(what) else None


def pages() -> list[Path]:
    """Return the Markdown pages of `docs`."""
    built = ROOT / "docs/_build"
    return sorted(file for file in (ROOT / "docs").rglob("*.md") if built not in file.parents)


def documents() -> list[Path]:
    """Return the README and all pages of `docs`."""
    return [ROOT / "README.md", *pages()]


def all_words() -> list[Path]:
    """And those that stand elsewhere."""
    others = [ROOT / name for name in ("CONTRIBUTING.md", "CHANGELOG.md", "SECURITY.md")]
    return [*documents(), *others, *of_examples()]


def of_examples() -> list[Path]:
    """Those of the examples."""
    return sorted((ROOT / "examples").glob("*/README.md"))


_FENCED = re.compile(
    r"^(?:[ ]*<!-- (?P<note>[^\n]*?) -->\n\n?)?"
    r"^(?P<indent>[ ]*)```(?P<language>[^\n]*)\n(?P<text>.*?)^(?P=indent)```[ ]*$",
    re.MULTILINE | re.DOTALL,
)


def blocks(file: Path) -> Iterator[Block]:
    """All blocks of code of a document, in order."""
    text = file.read_text(encoding="utf-8")
    for match in _FENCED.finditer(text):
        line = text.count("\n", 0, match.start("text")) + 1
        yield Block(file, line, match["language"].strip(), match["text"], match["note"] or "")


def prose(file: Path) -> str:
    """A document without its blocks of code; lines stay where they are."""
    text = file.read_text(encoding="utf-8")
    return _FENCED.sub(lambda match: "\n" * match[0].count("\n"), text)


def links(file: Path) -> Iterator[tuple[int, str]]:
    """Line and target of every link and picture."""
    text = prose(file)
    for match in re.finditer(r"\]\(([^()\s]+(?:\([^()\s]*\))?)\)|<img[^>]*src=\"([^\"]+)\"", text):
        yield text.count("\n", 0, match.start()) + 1, match[1] or match[2]


def inline_code(file: Path) -> Iterator[tuple[int, str]]:
    """Line and content of every piece of code within a line."""
    text = prose(file)
    for match in re.finditer(r"(?<!`)`([^`\n]+)`", text):
        yield text.count("\n", 0, match.start()) + 1, match[1]


def anchors(file: Path) -> set[str]:
    """What may stand behind a `#` in a link to a document: its headings, as GitHub names them."""
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
