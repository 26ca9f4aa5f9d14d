"""Planetary sets: gear meshes and planets about one turning carrier, drawn as one stick scheme.

A planet is a shaft with two or more meshes about the same carrier and nothing else but bodies; planets that mesh alike with
the same wheels are drawn once. Knows nothing of places on the paper.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import final

from gearblocks.blocks import GearMesh, IdealGear, IdealPlanetary, Inertia, LossyGear, NonCircularGear, PlanetaryGear
from gearblocks.language.block import Block
from gearblocks.train.graph import GROUND, Component

MESHES = (GearMesh, NonCircularGear, IdealGear, LossyGear)
CARRIER = "carrier"


@final
@dataclass(frozen=True, slots=True)
class Gearing:
    """Wheels of a set. meshes: (planet, what it meshes with): a port by name, or another planet by number.

    suns and rings are names of ports; counts: how many planets of each kind there are (0: not said); noncircular: meshes
    of non-circular gears.
    """

    suns: tuple[str, ...]
    rings: tuple[str, ...]
    counts: tuple[int, ...]
    meshes: tuple[tuple[int, str | int], ...]
    noncircular: frozenset[tuple[int, str | int]] = frozenset()


@final
@dataclass(frozen=True, slots=True)
class PlanetSet:
    """The blocks of a set, its ports (role, shaft), wheels that are held fast (role, line), and all its wheels."""

    name: str
    blocks: tuple[tuple[str, Block], ...]
    ports: tuple[tuple[str, int], ...]
    grounded: tuple[tuple[str, int], ...]
    gearing: Gearing


def simple_gearing(block: Block) -> Gearing:
    """Sun, planets and ring of a block that is a set by itself; a negative ratio has two planets in mesh."""
    if isinstance(block, IdealPlanetary) and block.ratio < 0:
        return Gearing(("sun",), ("ring",), (0, 0), ((0, "sun"), (0, 1), (1, "ring")))
    count = block.planets if isinstance(block, PlanetaryGear) else 0
    return Gearing(("sun",), ("ring",), (count,), ((0, "sun"), (0, "ring")))


def planet_sets(components: Sequence[Component], shaft_at: Callable[[int], int]) -> list[PlanetSet]:
    """The sets among the components of a train. shaft_at: the line of a node, from 0 a shaft, below GROUND one held fast."""
    about = defaultdict[int, list[Component]](list)
    on_shaft = defaultdict[int, list[Component]](list)
    for c in components:
        shafts = [shaft_at(n) for n in c.nodes]
        for shaft in dict.fromkeys(shafts):
            on_shaft[shaft].append(c)
        if isinstance(c.block, MESHES) and GROUND not in shafts and shafts[2] >= 0 and len(set(shafts)) == 3:
            about[shafts[2]].append(c)
    found = [_planet_set(carrier, meshes, on_shaft, shaft_at) for carrier, meshes in about.items()]
    return [one for one in found if one is not None]


def _is_external(block: Block) -> bool:
    external = getattr(block, "external", None)
    if isinstance(external, bool):
        return external
    ratio = getattr(block, "ratio", None)
    return not isinstance(ratio, (int, float)) or ratio < 0


def _planet_set(
    carrier: int, meshes: list[Component], on_shaft: dict[int, list[Component]], shaft_at: Callable[[int], int]
) -> PlanetSet | None:
    ends = {m.path: (shaft_at(m.nodes[0]), shaft_at(m.nodes[1])) for m in meshes}
    planets = _planets(meshes, ends, on_shaft)
    taken = [m for m in meshes if planets & set(ends[m.path])]
    if not taken:
        return None
    kinds = _kinds(planets, taken, ends)
    kind_of = {planet: i for i, kind in enumerate(kinds) for planet in kind}
    internal = {ends[m.path][1] for m in taken if not _is_external(m.block)} - planets
    central = [s for s in dict.fromkeys(s for m in taken for s in ends[m.path]) if s not in planets]
    names = {
        s: f"{_role(s, on_shaft, f'({i})')}{i if _role(s, on_shaft, '') == CARRIER else ''}"
        for i, s in enumerate(central)
    }
    pairs: list[tuple[int, str | int]] = []
    for m in taken:
        first, second = sorted(ends[m.path], key=lambda s: s not in planets)
        pairs.append((kind_of[first], kind_of[second] if second in planets else names[second]))
    bodies = [c for c in dict.fromkeys(c for p in planets for c in on_shaft[p]) if isinstance(c.block, Inertia)]
    gearing = Gearing(
        tuple(names[s] for s in central if s not in internal), tuple(names[s] for s in central if s in internal),
        tuple(len(kind) for kind in kinds), tuple(dict.fromkeys(pairs)),
        frozenset(pair for pair, m in zip(pairs, taken, strict=True) if isinstance(m.block, NonCircularGear)),
    )  # fmt: skip
    ports = [(names[s], s) for s in central if s not in internal] + [(CARRIER, carrier)]
    ports += [(names[s], s) for s in central if s in internal]
    called = [
        _role(kind[0], on_shaft, "planet") + (f" … {_role(kind[-1], on_shaft, '')}" * (len(kind) > 1)) for kind in kinds
    ]
    blocks = tuple((c.path, c.block) for c in (*taken, *bodies))
    turning, held = (tuple(p for p in ports if (p[1] >= 0) == turns) for turns in (True, False))
    return PlanetSet(", ".join(called), blocks, turning, held, gearing)


def _role(shaft: int, on_shaft: dict[int, list[Component]], otherwise: str) -> str:
    """The name of the first body on a shaft."""
    return next((c.path for c in on_shaft[shaft] if isinstance(c.block, Inertia)), otherwise)


def _planets(
    meshes: list[Component], ends: dict[str, tuple[int, int]], on_shaft: dict[int, list[Component]]
) -> set[int]:
    own = {m.path for m in meshes}
    wheels = {ends[m.path][1] for m in meshes if not _is_external(m.block)}
    count = defaultdict[int, set[int]](set)
    for m in meshes:
        a, b = ends[m.path]
        count[a].add(b)
        count[b].add(a)
    found = {
        s for s, others in count.items()
        if s >= 0 and len(others) > 1 and s not in wheels
        and all(c.path in own or isinstance(c.block, Inertia) for c in on_shaft[s])
    }  # fmt: skip
    return {s for s in found if len(count[s] & found) < 2}  # a sun that carries nothing else meshes with many planets


def _kinds(planets: set[int], meshes: list[Component], ends: dict[str, tuple[int, int]]) -> list[list[int]]:
    """Planets that mesh alike, together, in the order of the meshes."""
    alike = defaultdict[tuple[object, ...], list[int]](list)
    for p in dict.fromkeys(s for m in meshes for s in ends[m.path] if s in planets):
        touching = [(m, ends[m.path]) for m in meshes if p in ends[m.path]]
        signature = sorted(
            (type(m.block).__name__, e.index(p), _is_external(m.block), "planet" if {*e} - {p} <= planets else str({*e} - {p}))
            for m, e in touching
        )  # fmt: skip
        alike[tuple(signature)].append(p)
    return list(alike.values())
