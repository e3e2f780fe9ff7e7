"""Dialogs for progress, folders and files, which are recorded and answered from queues."""

from __future__ import annotations

from typing import Any

from ..base import Base, api, stored
from ..state import ProgressRecord, world


@api("adsk.core")
class ProgressDialog(Base):
    """Progress dialog with recorded updates; World.cancel_progress_after cancels it."""

    _record: Any = None
    _is_cancel_shown = True
    _cancel_text = "Cancel"

    def show(
        self, title: str, message: str, minimumValue: int, maximumValue: int, delay: int = 0
    ) -> bool:
        if maximumValue <= minimumValue:
            raise RuntimeError("3 : invalid argument minimumValue or maximumValue")
        self._record = ProgressRecord(title, message, minimumValue, maximumValue)
        world().progress.append(self._record)
        return True

    def hide(self) -> bool:
        self._shown().hidden = True
        return True

    def _shown(self) -> ProgressRecord:
        if self._record is None:
            raise RuntimeError("3 : the progress dialog is not shown")
        return self._record

    @property
    def wasCancelled(self) -> bool:
        after = world().cancel_progress_after
        if self._record is None or after is None or not self._is_cancel_shown:
            return False
        return len(self._record.values) >= after

    @property
    def progressValue(self) -> int:
        record = self._shown()
        return record.values[-1] if record.values else record.minimum

    @progressValue.setter
    def progressValue(self, value: int) -> None:
        record = self._shown()
        if not record.minimum <= value <= record.maximum:
            raise RuntimeError("3 : invalid argument progressValue")
        record.values.append(value)

    @property
    def maximumValue(self) -> int:
        return self._shown().maximum

    @maximumValue.setter
    def maximumValue(self, value: int) -> None:
        if value <= self._shown().minimum:
            raise RuntimeError("3 : invalid argument maximumValue")
        self._shown().maximum = value

    minimumValue = property(lambda self: self._shown().minimum)

    @property
    def message(self) -> str:
        return self._shown().message

    @message.setter
    def message(self, value: str) -> None:
        self._shown().message = value
        self._shown().messages.append(value)

    @property
    def title(self) -> str:
        return self._shown().title

    @title.setter
    def title(self, value: str) -> None:
        self._shown().title = value

    isCancelButtonShown = stored("is_cancel_shown", "bool")
    cancelButtonText = stored("cancel_text", "str")


@api("adsk.core")
class FolderDialog(Base):
    _title = ""
    _initial = ""
    _folder = ""

    title = stored("title", "str")
    initialDirectory = stored("initial", "str")
    folder = property(lambda self: self._folder)

    def showDialog(self) -> int:
        world().folder_dialogs.append((self._title, self._initial))
        answer = world().folder_answers.popleft() if world().folder_answers else None
        if answer is None:
            return 1
        self._folder = str(answer)
        return 0


@api("adsk.core")
class FileDialog(Base):
    _title = ""
    _initial = ""
    _initial_name = ""
    _filter = ""
    _file = ""

    title = stored("title", "str")
    initialDirectory = stored("initial", "str")
    initialFilename = stored("initial_name", "str")
    filter = stored("filter", "str")
    filename = property(lambda self: self._file)

    def showOpen(self) -> int:
        return self._show()

    def showSave(self) -> int:
        return self._show()

    def _show(self) -> int:
        world().file_dialogs.append((self._title, self._filter))
        answer = world().file_answers.popleft() if world().file_answers else None
        if answer is None:
            return 1
        self._file = str(answer)
        return 0
