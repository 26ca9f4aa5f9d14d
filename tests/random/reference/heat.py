"""Heat: what elements lose, as further states; temperatures of thermal masses, and what is conducted between them.

given' = power lost,    T = T0 + (sum of what is given and passed on)/C,    passed' = G (T_a - T_b)
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from tests.random.description import Part, Train
from tests.random.expressions import Node, rewrite, sense
from tests.random.reference.switches import Context
from tests.random.reference.system import Array, System


@dataclass
class Store:
    """A thermal mass: its capacity, and which states count heat that comes in (+1) and goes out (-1)."""

    C: float
    T0: float
    flows: list[tuple[int, int]]

    def rise(self, states: Any) -> float:
        """T - T0."""
        return sum(sign * states[i] for i, sign in self.flows) / self.C

    def temperature(self, c: Context) -> float:
        """T."""
        return self.T0 + self.rise(c.s)


def port(p: Part) -> Any:
    """The temperature of a part's heat port, or None."""
    found = p.field("heat")
    return None if found is None else dict(found.args[1])["T"]


def prepared(s: System, train: Train) -> tuple[Part, ...]:
    """The parts with their temperatures as signals; stores and states of heat are made."""
    for p in train.parts:
        if p.block == "ThermalMass":
            s.stores[p.name] = Store(p.field("C"), p.field("T0", 293.15), [])
    for p in train.parts:
        if p.block == "ThermalConductance":
            k = s.heats[p.name] = s.state()
            for end, sign in (("a", -1), ("b", 1)):
                if isinstance(p.field(end), str):
                    s.stores[p.field(end)].flows.append((k, sign))
        elif isinstance(port(p), str):
            k = s.heats[p.name] = s.state()
            s.stores[port(p)].flows.append((k, 1))
    return tuple(p if port(p) is None else _warm(p) for p in train.parts)


def _warm(p: Part) -> Part:
    T = as_signal(port(p))
    read = lambda x: T if isinstance(x, Node) and x.op == "temperature" else x  # noqa: E731
    return p.changed(**{name: rewrite(value, read) for name, value in p.fields if name != "heat"})


def as_signal(T: Any) -> Any:
    """The temperature that a name stands for."""
    return sense(f"{T}.T") if isinstance(T, str) else T


def lost(s: System, p: Part, power: Callable[[Context], float]) -> None:
    """What an element loses goes into the mass of its port, if any."""
    k = s.heats.get(p.name)
    if k is None:
        return

    def law(c: Context, f: list[float]) -> None:
        f[-1 - k] += power(c)

    s.laws.append(law)


def conductance(s: System, p: Part) -> None:
    """G (T_a - T_b), from what is known of both at the start and what they have risen by."""
    G, k = s.compile(p.field("G")), s.heats[p.name]
    ends = [s.stores.get(p.field(end)) for end in ("a", "b")]
    outside = [s.compile(p.field(end)) if store is None else None for end, store in zip(("a", "b"), ends, strict=True)]

    def law(c: Context, f: list[float]) -> None:
        start = [store.T0 if store is not None else T(c) for store, T in zip(ends, outside, strict=True)]
        since = [store.rise(c.s) if store is not None else 0.0 for store in ends]
        f[-1 - k] += G(c) * (start[0] - start[1] + (since[0] - since[1]))

    s.laws.append(law)


def heat_of_gears(
    s: System, v: Array, numbers: list[float], losses: list[tuple[float, float]]
) -> list[tuple[int, float]]:
    """(state, power) of what the forces of turning gears with losses take out of the motion of their two sides."""
    at = sum(d.mode == 0 for d in s.dry) + sum(x.mode == 0 for x in s.stops)
    found: list[tuple[int, float]] = []
    for g, loss in zip(s.lossy, losses, strict=True):
        if not g.mode[0]:
            at += 2
            continue
        w_a, w_b = float(g.ra @ v), g.ratio * float(g.rb @ v)
        given = numbers[at] * (w_b if g.mode[1] == 2 else -w_a + (1 - loss[0]) * w_b) - loss[1] * w_b
        found += [(g.heat, -given)] if g.heat >= 0 else []
        at += 1
    return found
