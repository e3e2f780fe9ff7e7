"""Design, Component and Occurrence."""

from __future__ import annotations

import re
from typing import Any

import numpy as np

from ..base import Base, api, by_name, edited, new
from ..collections_ import Items, named
from ..maths import matrix
from ..state import world
from .bodies import BRepBodies, MeshBodies
from .data import ComponentData, DesignData, OccurrenceData, paths_below, transform
from .entity import Seen, WithName, WithToken, occurrence, wrap, wraps
from .physical import physical_properties


def material(name: str) -> Any:
    """Return the Material with a name; None for an empty name."""
    return new(Material, name=name) if name else None


@api("adsk.core")
class Material(Base):
    name = property(lambda self: self._name)
    id = property(lambda self: f"PrismMaterial-{self._name}")


@api("adsk.fusion")
class BaseComponent(Base):
    """Base of Component."""


def _listed(cls: type, make: Any) -> Any:
    return new(cls, make=make)


@api("adsk.fusion")
@wraps(ComponentData)
class Component(WithName, BaseComponent):
    _component = property(lambda self: self._data)

    def _siblings(self) -> list[Any]:
        return self._data.design.components

    @property
    def name(self) -> str:
        """Name of the component; the names of its occurrences follow it."""
        return self._data.name

    @name.setter
    def name(self, value: str) -> None:
        WithName.name.fset(self, value)
        rename_occurrences(self._data)

    id = property(lambda self: self._data.id)
    parentDesign = property(lambda self: wrap(self._data.source or self._data.design))
    description = property(lambda _: "")
    material = property(lambda self: material(self._data.material))
    occurrences = property(lambda self: new(Occurrences, component=self._data))

    @property
    def opacity(self) -> float:
        """Opacity; only components below the root component have one."""
        return self._data.opacity

    @opacity.setter
    def opacity(self, value: float) -> None:
        if self._data is self._data.design.root:
            raise RuntimeError("3 : the root component has no opacity")
        world().set(self._data, "opacity", float(value), "Component.opacity")

    @property
    def allOccurrences(self) -> Any:
        data = self._data
        _reject_unresolved(data)
        return _listed(OccurrenceList, lambda: [occurrence(p) for p in paths_below(data)])

    motionLinks = property(lambda self: by_name("MotionLinks", component=self._data))
    tangentRelationships = property(
        lambda self: by_name("TangentRelationships", component=self._data)
    )
    bRepBodies = property(lambda self: new(BRepBodies, component=self._data, path=()))
    meshBodies = property(lambda self: new(MeshBodies, component=self._data, path=()))
    constructionPoints = property(lambda self: by_name("ConstructionPoints", component=self._data))
    sketches = property(lambda self: by_name("Sketches", component=self._data))
    joints = property(lambda self: by_name("Joints", component=self._data))
    asBuiltJoints = property(lambda self: by_name("AsBuiltJoints", component=self._data))
    rigidGroups = property(lambda self: by_name("RigidGroups", component=self._data))
    customGraphicsGroups = property(
        lambda self: by_name("CustomGraphicsGroups", component=self._data)
    )
    assemblyConstraints = property(
        lambda self: by_name("AssemblyConstraints", component=self._data)
    )

    @property
    def allJoints(self) -> list:
        self._reject_constraints("allJoints")
        return self._everywhere("joints")

    def _reject_constraints(self, what: str) -> None:
        """Fail like Fusion if assembly constraints exist: ACDC4Robot issue 10."""
        below = [self._data, *(p[-1].component for p in paths_below(self._data))]
        if world().options.all_joints_fail and any(c.constraints for c in below):
            raise RuntimeError(f"2 : InternalValidationError : {what}")

    def _everywhere(self, shelf: str) -> list:
        """Return a list of the component and all its children, as proxies in its context."""
        found = [wrap(item) for item in getattr(self._data, shelf)]
        for path in paths_below(self._data):
            found += [wrap(item, path) for item in getattr(path[-1].component, shelf)]
        return found

    def getPhysicalProperties(self, accuracy: int = 0) -> Any:
        return physical_properties(self._data.mass(), accuracy, np.eye(4))


@api("adsk.fusion")
@wraps(OccurrenceData)
class Occurrence(WithToken):
    """Occurrence of a component. `_path` ends with the occurrence itself."""

    _component = property(lambda self: self._data.parent)
    name = property(lambda self: self._data.name)
    fullPathName = property(lambda self: "+".join(o.name for o in self._path))

    @property
    def component(self) -> Any:
        self._reject_unresolved()
        return wrap(self._data.component)

    def _reject_unresolved(self) -> None:
        """Fail like an unresolved external reference [inferred]."""
        if self._data.unresolved:
            raise RuntimeError("2 : InternalValidationError : occ")

    assemblyContext = property(lambda self: occurrence(self._path[:-1]))

    @property
    def nativeObject(self) -> Any:
        return occurrence(self._path[-1:]) if len(self._path) > 1 else None

    def createForAssemblyContext(self, occurrence: Occurrence) -> Any:
        if len(self._path) > 1:
            raise RuntimeError("3 : object is not the native object")
        if occurrence._data.component is not self._data.parent:
            raise RuntimeError("3 : invalid argument occurrence: it is of another component")
        return wrap(self._data, (*occurrence._path, self._data))

    @property
    def transform2(self) -> Any:
        return matrix(transform(self._path))

    @property
    def childOccurrences(self) -> Any:
        self._reject_unresolved()
        path, data = self._path, self._data
        children = lambda: [occurrence((*path, o)) for o in data.component.shown]  # noqa: E731
        return _listed(OccurrenceList, children)

    @property
    def bRepBodies(self) -> Any:
        return new(BRepBodies, component=self._data.component, path=self._path)

    isReferencedComponent = property(lambda self: self._data.component.referenced)

    isGrounded = edited("data.grounded", "bool", "isGrounded")
    isGroundToParent = edited("data.ground_to_parent", "bool", "isGroundToParent")

    isVisible = property(lambda self: all(o.light_bulb for o in self._path))

    def getPhysicalProperties(self, accuracy: int = 0) -> Any:
        return self._physical(accuracy)

    def _physical(self, accuracy: int) -> Any:
        self._reject_unresolved()
        return physical_properties(self._data.component.mass(self._path), accuracy, self._T)


def _reject_unresolved(component: ComponentData) -> None:
    """Fail if one external reference is unresolved [live]."""
    if any(path[-1].unresolved for path in paths_below(component)):
        raise RuntimeError("2 : InternalValidationError : occ")


@api("adsk.fusion")
@named
class OccurrenceList(Items):
    pass


@api("adsk.fusion")
@named
class Occurrences(Items):
    def _all(self) -> list[Any]:
        return [occurrence((o,)) for o in self._component.shown]

    def asArray(self) -> list:
        return self._all()


@api("adsk.core")
class Product(Seen):
    """Base of Design."""


@api("adsk.fusion")
@wraps(DesignData)
class Design(Product):
    _component = property(lambda self: self._data.root)
    rootComponent = property(lambda self: wrap(self._data.root))
    designType = property(lambda self: 0 if self._data.is_edited() else self._data.kind)
    snapshots = property(lambda self: by_name("Snapshots", design=self._data))
    designIntent = property(lambda self: self._data.intent)

    @property
    def parentDocument(self) -> Any:
        from ..app import document_of

        return document_of(self._data)

    def findEntityByToken(self, entityToken: str) -> list:
        """Return the entity of a token; a moved occurrence only if Options.tokens_survive."""
        _, _, token = entityToken.partition(":")
        above, _, own = token.rpartition(":")
        ids = above.split("/") if above else []
        paths = [(), *paths_below(self._data.root)]
        exact = [p for p in paths if [str(id(o)) for o in p] == ids]
        if not exact and world().options.tokens_survive:
            exact = [p for p in paths if p and ids[-1:] == [own] == [str(id(p[-1]))]]
        return [
            wrap(data, path)
            for path in exact
            for data in ([path[-1]] if ids[-1:] == [own] else every_entity(self._data))
            if str(id(data)) == own and not data.gone
        ]

    def findAttributes(self, groupName: str, attributeName: str) -> list:
        """Return attributes of entities; empty names match all, `re:` starts a pattern."""
        group, name = _matcher(groupName), _matcher(attributeName)
        owners = [wrap(d) for d in every_entity(self._data)]
        return [
            attribute
            for owner in owners
            if owner._data.attributes
            for attribute in owner.attributes
            if group(attribute.groupName) and name(attribute.name)
        ]


def rename_occurrences(component: ComponentData) -> None:
    """Rename the occurrences of a component, which are called `<component>:<number>`."""
    for other in component.design.components:
        for o in other.occurrences:
            if o.component is component:
                name = f"{component.name}:{o.name.rpartition(':')[2]}"
                world().set(o, "name", name, "Component.name")


def _matcher(text: str) -> Any:
    if text.startswith("re:"):
        pattern = re.compile(text[3:])
        return lambda value: pattern.fullmatch(value) is not None
    return lambda value: not text or value == text


def every_entity(design: DesignData) -> list[Any]:
    """Return the data of all entities of a design that may have attributes."""
    found: list[Any] = []
    for c in design.components:
        found.append(c)
        found += [*c.occurrences, *c.points, *c.sketches, *c.joints, *c.as_built]
        found += [*c.groups, *c.joint_origins, *c.bodies, *c.mesh_bodies]
        for sketch in c.sketches:
            found += sketch.points
        for body in c.bodies:
            for part in body.parts or ():
                found += part
    return found
