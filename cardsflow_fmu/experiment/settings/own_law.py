"""Controllers and muscle laws of one's own, as settings name them; their files are not run here."""

from __future__ import annotations

import ast
import re
from pathlib import Path
from typing import NamedTuple, Self

from addin_sdfusion.robot import InputError, UnknownNameError, limits
from addin_sdfusion.robot.files import read_file

_OWN_LAW = re.compile(r"(?P<file>.+\.py):(?P<name>[^\W\d]\w*)", re.DOTALL)
OWN_LAW_FORM = "<file>.py:<class>"


class OwnLaw(NamedTuple):
    """A controller or a muscle law of one's own: a class in a file of Python.

    Attributes:
        file: The file.
        name: The class.
    """

    file: Path
    name: str

    @classmethod
    def of(cls, law: str) -> Self | None:
        """From a setting; None where that is the name of one of ours."""
        match = _OWN_LAW.fullmatch(law)
        return None if match is None else cls(Path(match["file"]), match["name"])

    def __str__(self) -> str:
        return f"{self.file.as_posix()}:{self.name}"

    def require(self) -> ast.ClassDef:
        """The class as it is written; nothing of the file is run.

        Raises:
            InputError: The file cannot be read, is not Python, or does not have the class.
        """
        try:
            tree = ast.parse(read_file(self.file, limits.CODE))
        except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
            line = error.lineno if isinstance(error, SyntaxError) else None
            what = f"cannot be read: {getattr(error, 'msg', error)}"
            raise InputError(what, file=self.file, line=line) from None
        classes = {node.name: node for node in tree.body if isinstance(node, ast.ClassDef)}
        if self.name not in classes:
            raise UnknownNameError("class", self.name, classes, file=self.file)
        return classes[self.name]
