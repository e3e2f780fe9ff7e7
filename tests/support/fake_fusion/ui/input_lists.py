"""Drop-downs, button rows and radio buttons: inputs with items."""

from __future__ import annotations

from typing import Any

from ..base import Base, api, new, stored
from ..collections_ import Items, listing
from .changes import changed_by_addin
from .inputs import CommandInput, InputData, field


class _ItemData:
    def __init__(self, name: str, selected: bool, icon: str) -> None:
        self.name, self.selected, self.icon = name, selected, icon


@api("adsk.core")
class ListItem(Base):
    def __eq__(self, other: object) -> bool:
        return isinstance(other, ListItem) and self._item is other._item

    def _is_gone(self) -> bool:
        return self._item not in self._data.fields["items"]

    name = stored("item.name", "str")

    icon = property(lambda self: self._item.icon)
    index = property(lambda self: self._data.fields["items"].index(self._item))

    @property
    def isSelected(self) -> bool:
        return self._item.selected

    @isSelected.setter
    def isSelected(self, value: bool) -> None:
        select_item(self._data, self._item, value)


def select_item(data: InputData, item: _ItemData, selected: bool) -> None:
    """Select an item of a list; deselect the others unless the list has check boxes."""
    was_selected = item.selected
    if selected and not data.fields["many"]:
        for other in data.fields["items"]:
            other.selected = False
    item.selected = selected
    if selected != was_selected:
        changed_by_addin(data)


@api("adsk.core")
@listing
class ListItems(Items):
    def _is_gone(self) -> bool:
        return self._data.gone or self._data.command.gone

    def _all(self) -> list[Any]:
        return [new(ListItem, data=self._data, item=i) for i in self._data.fields["items"]]

    def add(
        self, name: str, isSelected: bool = False, icon: str = "", beforeIndex: int = -1
    ) -> Any:
        item = _ItemData(name, False, icon)
        items = self._data.fields["items"]
        items.insert(len(items) if beforeIndex < 0 else beforeIndex, item)
        if isSelected:
            select_item(self._data, item, True)
        return new(ListItem, data=self._data, item=item)

    def clear(self) -> bool:
        self._data.fields["items"].clear()
        return True


class _List(CommandInput):
    listItems = property(lambda self: new(ListItems, data=self._data))

    @property
    def selectedItem(self) -> Any:
        """Selected item, or None."""
        items = [i for i in self._data.fields["items"] if i.selected]
        return new(ListItem, data=self._data, item=items[0]) if items else None


@api("adsk.core")
class DropDownCommandInput(_List):
    dropDownStyle = field("style", "int", 0, writable=False)
