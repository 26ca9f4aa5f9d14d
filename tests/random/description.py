"""A random train as plain frozen data: parts with their fields and the nodes that their flanges hang on.

From it come the gearblocks train, the independent reference, smaller trains, and a script of a few lines.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from random import Random
from typing import Any

from tests.random.expressions import Node, to_gearblocks, to_text, walk

GROUND, WALL = "ground", "wall"  # what does not turn, and what does not slide
FIXED = (GROUND, WALL)
BODIES = {"Inertia": "J", "Mass": "m", "Chassis": "mass"}
SLIDING = ("Mass", "Chassis")
HITS = "hits"  # no field of a block: its compliance is taken away, so that its sides hit each other
# flanges that stand on the ground where they are not connected
OPEN = {"housing": None, "carrier": ("GearMesh", "NonCircularGear"), "b": ("HardStop",)}


@dataclass(frozen=True)
class Part:
    """One block: its name, its class, its fields, and the node of every flange."""

    name: str
    block: str
    fields: tuple[tuple[str, Any], ...]
    at: tuple[tuple[str, str], ...]

    def field(self, name: str, default: Any = None) -> Any:
        """A field by name."""
        return dict(self.fields).get(name, default)

    def node(self, flange: str) -> str:
        """The node of a flange; the ground where it is left open."""
        return dict(self.at).get(flange, GROUND)

    def changed(self, **fields: Any) -> Part:
        """With other fields; None takes one away."""
        merged = {k: v for k, v in {**dict(self.fields), **fields}.items() if v is not None}
        return replace(self, fields=tuple(merged.items()))

    @property
    def is_body(self) -> bool:
        """Whether it is an Inertia, a Mass or a Chassis."""
        return self.block in BODIES


@dataclass(frozen=True)
class Train:
    """A train and the run asked of it. inputs: trees over time by name.

    initial: None, "static", "rolling", or the (name, value) of gb.rolling."""

    family: str
    seed: int
    parts: tuple[Part, ...]
    t_end: float
    initial: str | tuple[tuple[str, float], ...] | None = None
    inputs: tuple[tuple[str, Any], ...] = ()
    drops: tuple[str, ...] = ()  # names of compliant parts to be tied in the comparison with `without`

    @property
    def bodies(self) -> tuple[Part, ...]:
        """Its inertias and masses."""
        return tuple(p for p in self.parts if p.is_body)

    def with_parts(self, parts: Iterable[Part]) -> Train:
        """The same run of other parts."""
        return replace(self, parts=tuple(parts))

    def outputs(self) -> list[tuple[str, str]]:
        """(angle, speed) outputs of every body."""
        return [
            (f"{p.name}.s", f"{p.name}.v") if p.block in SLIDING else (f"{p.name}.phi", f"{p.name}.w")
            for p in self.bodies
        ]

    def rises(self) -> list[str]:
        """Outputs for the rise of the temperature of every thermal mass."""
        return [f"{p.name}.rise" for p in self.parts if p.block == "ThermalMass"]

    def nodes(self) -> tuple[str, ...]:
        """Names of all nodes, the ground left out."""
        return tuple(dict.fromkeys(n for p in self.parts for _, n in p.at if n not in FIXED))


def may_stay_open(block: str, flange: str) -> bool:
    """Whether an open flange stands on the ground."""
    return flange in OPEN and (OPEN[flange] is None or block in OPEN[flange])


def connections(train: Train, order: Random | None = None) -> tuple[list[Part], list[list[str]]]:
    """The parts, and the connections as lists of "part.flange"; shuffled with an order.

    A body of a node takes half of the flanges at its left and half at its right end.
    """
    parts = list(train.parts)
    hanging: dict[str, list[str]] = {}
    for part in parts:
        for flange, node in part.at:
            if node in FIXED and may_stay_open(part.block, flange):
                continue
            hanging.setdefault(node, []).append(f"{part.name}.{flange}")
    for fixed in FIXED:
        if fixed in hanging:
            parts.append(Part(fixed, "Fixed", (), (("flange", fixed),)))
            hanging[fixed].append(f"{fixed}.flange")
    links: list[list[str]] = []
    bodies = {f"{p.name}.a" for p in parts if p.is_body}
    for ends in hanging.values():
        if order is not None:
            order.shuffle(ends)
        own = [e for e in ends if e in bodies]
        if len(own) == 1 and len(ends) > 2:
            others = [e for e in ends if e != own[0]]
            half = (len(others) + 1) // 2
            links += [[own[0], *others[:half]], [own[0][:-1] + "b", *others[half:]]]
        elif len(ends) > 1:
            links.append(ends)
    if order is not None:
        order.shuffle(parts)
        order.shuffle(links)
    return parts, links


def build(train: Train, gb: Any, order: Random | None = None) -> Any:
    """The train in gearblocks; the order of parts and connections is shuffled with an order."""
    rig = gb.Drivetrain(f"{train.family} {train.seed}")
    handles = {}
    parts, links = connections(train, order)
    for part in parts:
        fields = {name: to_gearblocks(value, gb) for name, value in part.fields if name != HITS}
        handles[part.name] = rig.add(part.name, getattr(gb, part.block)(**fields))
    for ends in links:
        rig.connect(*(getattr(handles[name], flange) for name, flange in (e.rsplit(".", 1) for e in ends)))
    rigid = [f"{part.name}.compliance" for part in train.parts if part.field(HITS)]
    return rig.without(*rigid) if rigid else rig


def arguments(train: Train, gb: Any) -> dict[str, Any]:
    """What gb.simulate is given besides the train and how to solve."""
    given: dict[str, Any] = {"watch": False}
    if train.initial is not None:
        given["initial"] = train.initial if isinstance(train.initial, str) else gb.rolling(dict(train.initial))
    used = {n.args[0] for p in train.parts for n in walk(p.fields) if n.op == "input"}
    if used:
        given["inputs"] = {name: to_gearblocks(value, gb) for name, value in train.inputs if name in used}
    return given


def script(train: Train, options: str = "") -> str:
    """A script of a few lines that builds and runs the train."""
    parts, links = connections(train)
    text = "".join(to_text(v) for p in parts for _, v in p.fields)
    lines = ["import gearblocks as gb"] + (["import sympy as sp"] if "sp." in text else [])
    lines.append(f"rig = gb.Drivetrain({train.family + ' ' + str(train.seed)!r})")
    for part in parts:
        fields = ", ".join(f"{name}={to_text(value)}" for name, value in part.fields if name != HITS)
        lines.append(f"{part.name} = rig.add({part.name!r}, gb.{part.block}({fields}))")
    lines += [f"rig.connect({', '.join(ends)})" for ends in links]
    rigid = [f"{part.name}.compliance" for part in train.parts if part.field(HITS)]
    lines += [f"rig = rig.without({', '.join(map(repr, rigid))})"] if rigid else []
    more = f", initial={train.initial!r}" if train.initial else ""
    if isinstance(train.initial, tuple):
        more = f", initial=gb.rolling({dict(train.initial)!r})"
    used = {n.args[0] for p in train.parts for n in walk(p.fields) if n.op == "input"}
    if used:
        more += ", inputs={" + ", ".join(f"{n!r}: {to_text(v)}" for n, v in train.inputs if n in used) + "}"
    lines.append(f"run = gb.simulate(rig, t_end={train.t_end!r}{more}{options})")
    return "\n".join(lines) + "\n"


def senses(part: Part) -> set[str]:
    """Names of the parts that the signals of a part read."""
    return {n.args[0].split(".")[0] for n in walk(part.fields) if isinstance(n, Node) and n.op == "sense"}
