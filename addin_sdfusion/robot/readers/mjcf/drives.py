"""Actuators of MJCF as it has them: any shortcut is a general one with certain parameters."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from ...formats.reading.xml import Node
from .compiler import Compiler, numbers
from .document import ACTUATORS, MAIN, Document

MUSCLE = (0.75, 1.05, -1.0, 200.0, 0.5, 1.6, 1.5, 1.3, 1.2)
"""range, force, scale, lmin, lmax, vmax, fpmax, fvmax unless a file says otherwise."""
PLACES = {
    "force": 2,
    "scale": 3,
    "lmin": 4,
    "lmax": 5,
    "vmax": 6,
    "fpmax": 7,
    "fvmax": 8,
}
TIMES = (0.01, 0.04, 0.0)
TARGETS = ("joint", "jointinparent", "tendon", "site", "body", "slidersite", "cranksite")


@dataclass
class Drive:
    """An actuator.

    Attributes:
        node: Its element.
        gain, bias, dynamics: The kinds of its parameters, as MuJoCo calls them.
        gain_numbers, bias_numbers, dynamics_numbers: The parameters.
        words: Its attributes, those of its class where it gives none.
    """

    node: Node
    gain: str = "fixed"
    bias: str = "none"
    dynamics: str = "none"
    gain_numbers: list[float] = field(default_factory=lambda: [1.0])
    bias_numbers: list[float] = field(default_factory=list)
    dynamics_numbers: list[float] = field(default_factory=lambda: [1.0])
    words: dict[str, Node] = field(default_factory=dict)

    @property
    def is_muscle(self) -> bool:
        """Whether it is MuJoCo's muscle."""
        return (self.gain, self.bias, self.dynamics) == ("muscle",) * 3

    @property
    def gear(self) -> float:
        """What the length of its target is times."""
        return (*self.numbers("gear"), 1.0)[0] if "gear" in self.words else 1.0

    @property
    def target(self) -> tuple[str, str]:
        """What kind of thing it drives, and the thing's name."""
        for kind in TARGETS:
            if kind in self.words:
                return kind, self.words[kind].attribute(kind)
        return "", ""

    def numbers(self, name: str, *, infinite: bool = False) -> tuple[float, ...]:
        """The numbers of an attribute; none where it is not given."""
        return numbers(self.words[name], name, infinite=infinite) if name in self.words else ()

    def range_of(self, compiler: Compiler, what: str) -> tuple[float, float] | None:
        """The range `ctrl` or `force`, where it counts."""
        given = (
            self.words[f"{what}limited"].attribute(f"{what}limited")
            if f"{what}limited" in self.words
            else "auto"
        )
        values = self.numbers(f"{what}range", infinite=True)
        counts = given == "true" or (given == "auto" and compiler.autolimits)
        return (values[0], values[1]) if counts and len(values) == 2 else None

    def apply(self, node: Node) -> None:
        """What an element says, over what is known already."""
        self.words |= {str(name): node for name in node.element.attrib}
        kind = node.tag
        if kind == "general":
            self._general(node)
        elif kind == "muscle":
            self._muscle(node)
        elif kind == "motor":
            self._set("fixed", [1.0], "none", [])
        elif kind == "position":
            kp, kv = node.number_attribute("kp", 1.0), node.number_attribute("kv", 0.0)
            self._set("fixed", [kp], "affine", [0.0, -kp, -kv])
        elif kind == "velocity":
            kv = node.number_attribute("kv", 1.0)
            self._set("fixed", [kv], "affine", [0.0, 0.0, -kv])
        else:
            self._set(kind, [], kind, [])

    def _set(self, gain: str, gains: list[float], bias: str, biases: list[float]) -> None:
        self.gain, self.gain_numbers, self.bias, self.bias_numbers = gain, gains, bias, biases

    def _general(self, node: Node) -> None:
        for word, of in (("gain", "gaintype"), ("bias", "biastype"), ("dynamics", "dyntype")):
            if node.has(of):
                setattr(self, word, node.attribute(of))
        for word, of in (("gain", "gainprm"), ("bias", "biasprm"), ("dynamics", "dynprm")):
            if node.has(of):
                self._fill(f"{word}_numbers", numbers(node, of))

    def _fill(self, name: str, values: Sequence[float]) -> None:
        """MuJoCo keeps the parameters that an attribute does not reach."""
        setattr(self, name, [*values, *getattr(self, name)[len(values) :]])

    def _muscle(self, node: Node) -> None:
        if not self.is_muscle:
            self.gain = self.bias = self.dynamics = "muscle"
            self.gain_numbers, self.dynamics_numbers = list(MUSCLE), list(TIMES)
        if node.has("range"):
            self.gain_numbers[:2] = node.numbers_attribute("range", 2)
        for word, place in PLACES.items():
            if node.has(word):
                self.gain_numbers[place] = node.number_attribute(word)
        if node.has("timeconst"):
            self.dynamics_numbers[:2] = node.numbers_attribute("timeconst", 2)
        if node.has("tausmooth"):
            self.dynamics_numbers[2:3] = [node.number_attribute("tausmooth")]
        self.bias_numbers = list(self.gain_numbers)


def read_drives(document: Document) -> list[Drive]:
    """The actuators, in order, with the defaults of their classes."""
    drives = []
    for node in document.parts("actuator"):
        drive = Drive(node)
        for default in reversed(document.defaults(node, MAIN, ACTUATORS)):
            drive.apply(default)
        drive.apply(node)
        drives.append(drive)
    return drives
