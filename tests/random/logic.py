"""Laws of signals that no one wrote down: what drivers, shift logic and limiters are made of, with their values in closed form.

A signal is a pair: an expression, and what it is at a time as plain Python says. Levels are small whole numbers, so that
signals stay on the limits of conditions, come to them, leave them and jump over them, many at the same instant.
"""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

import gearblocks as gb

T_END, PIECES = 4.0, 8
WIDTH = T_END / PIECES

Signal = tuple[Any, Callable[[float], float]]


@dataclass
class Composer:
    """Draws conditions over five signals; inputs: those that a run asks for, by name."""

    draw: random.Random
    inputs: dict[str, Any] = field(default_factory=dict)
    signals: list[Signal] = field(default_factory=list)

    def __post_init__(self) -> None:
        kinds = (
            self.held,
            self.held,
            self.ramps,
            self.steps,
            self.function,
            self.clipped,
            self.pulses,
            self.trapezoids,
        )
        self.signals = [self.draw.choice(kinds)(f"u{i}") for i in range(5)]

    def held(self, name: str) -> Signal:
        """An input that jumps from level to level."""
        levels = self.levels()
        times = [x for i in range(PIECES) for x in (i * WIDTH, (i + 1) * WIDTH)]
        self.inputs[name] = gb.Table(times, [x for level in levels for x in (level, level)])
        return gb.Input(name), lambda t: levels[min(int(t / WIDTH), PIECES - 1)]

    def steps(self, _: str) -> Signal:
        """The same as a table over time."""
        levels = self.levels()
        table = gb.Table([i * WIDTH for i in range(PIECES)], levels, "step")
        return table(gb.time), lambda t: levels[min(int(t / WIDTH), PIECES - 1)]

    def function(self, name: str) -> Signal:
        """The same as a function of Python's."""
        levels = self.levels()
        self.inputs[name] = lambda t: levels[min(max(int(t / WIDTH), 0), PIECES - 1)]
        return gb.Input(name), self.inputs[name]

    def ramps(self, name: str) -> Signal:
        """From level to level in straight lines, as an input or over time."""
        times, levels = [i * WIDTH for i in range(PIECES + 1)], [*self.levels(), 0.0]
        table = gb.Table(times, levels)
        if self.draw.random() < 0.5:
            return table(gb.time), lambda t: float(np.interp(t, times, levels))
        self.inputs[name] = table
        return gb.Input(name), lambda t: float(np.interp(t, times, levels))

    def clipped(self, name: str) -> Signal:
        """A function that rises from 0 to 1, or falls."""
        start, way = self.draw.choice([0.3, 0.7, 1.1, 1.6]), self.draw.choice([1.0, -1.0])
        self.inputs[name] = lambda t: max(0.0, min(1.0, way * (t - start) / 0.8))
        return gb.Input(name), self.inputs[name]

    def pulses(self, _: str) -> Signal:
        period, duty, offset = (
            self.draw.choice([1.0, 0.5]),
            self.draw.choice([0.25, 0.5]),
            self.draw.choice([0.0, -1.0, 1.0]),
        )
        signal = gb.pulse(1.0, period=period, duty=duty, offset=offset)
        return signal, lambda t: offset + float(t % period < period * duty)

    def trapezoids(self, _: str) -> Signal:
        offset = self.draw.choice([0.0, -1.0])
        signal = gb.trapezoid(1.0, period=2.0, rising=0.25, width=0.5, falling=0.25, offset=offset)
        return (
            signal,
            lambda t: offset + float(np.interp(t % 2.0, [0.0, 0.25, 0.75, 1.0, 2.0], [0.0, 1.0, 1.0, 0.0, 0.0])),
        )

    def levels(self) -> list[float]:
        return [self.draw.choice([-1.0, 0.0, 0.0, 1.0, 1.0, 2.0, 3.0]) for _ in range(PIECES)]

    def value(self, depth: int) -> Signal:
        """A sum, product, extremum, size, sign, step table or choice of signals."""
        if depth == 0 or self.draw.random() < 0.3:
            return self.draw.choice(self.signals)
        (a, of_a), (b, of_b) = self.value(depth - 1), self.value(depth - 1)
        made: list[Signal] = [
            (a + b, lambda t: of_a(t) + of_b(t)),
            (a - b, lambda t: of_a(t) - of_b(t)),
            (a * b, lambda t: of_a(t) * of_b(t)),
            (gb.maximum(a, b), lambda t: max(of_a(t), of_b(t))),
            (gb.minimum(a, b), lambda t: min(of_a(t), of_b(t))),
            (abs(a), lambda t: abs(of_a(t))),
            (np.sign(a), lambda t: float(np.sign(of_a(t)))),
            (gb.Heaviside(a), lambda t: float(of_a(t) >= 0.0)),
        ]
        chosen = self.draw.randrange(len(made) + 2)
        if chosen < len(made):
            return made[chosen]
        if chosen == len(made):
            levels = self.levels()[:3]
            joint = lambda t: levels[0 if of_a(t) < 1.0 else 1 if of_a(t) < 2.0 else 2]  # noqa: E731
            return gb.Table([0.0, 1.0, 2.0], levels, "step")(a), joint
        holds, is_so = self.condition(depth - 1)
        return gb.piecewise((a, holds), (b, True)), lambda t: of_a(t) if is_so(t) else of_b(t)

    def condition(self, depth: int) -> tuple[Any, Callable[[float], bool]]:
        """Over a value, compared with a number or another one; or two of them."""
        a, of_a = self.value(depth)
        level = self.draw.choice([0.0, 0.0, 1.0, 2.0, -1.0])
        number: Signal = (level, lambda _: level)
        b, of_b = number if self.draw.random() < 0.7 else self.value(depth)
        made, found = self.draw.choice(
            [
                (a > b, lambda t: of_a(t) > of_b(t)),
                (a >= b, lambda t: of_a(t) >= of_b(t)),
                (a < b, lambda t: of_a(t) < of_b(t)),
                (a <= b, lambda t: of_a(t) <= of_b(t)),
            ]
        )
        if depth == 0 or self.draw.random() < 0.7:
            return made, found
        also, is_so = self.condition(depth - 1)
        if self.draw.random() < 0.5:
            return made & also, lambda t: found(t) and is_so(t)
        return made | also, lambda t: found(t) or is_so(t)


def off(seed: int, method: str, laws: int = 8) -> list[str]:
    """Conditions of this seed that a run of T_END does not hold for as long as they do, with both times."""
    composer = Composer(random.Random(seed))
    conditions = [composer.condition(2) for _ in range(laws)]
    rig = gb.Drivetrain("logic")
    for i, (condition, _) in enumerate(conditions):
        drive = rig.add(f"drive{i}", gb.Torque(tau=gb.piecewise((1, condition), (0, True))))
        rig.chain(drive, rig.add(f"disc{i}", gb.Inertia(J=1.0)))
    model = gb.build(rig)
    asked = {x.name for x in model.program.inputs}
    run = gb.simulate(
        model, t_end=T_END, method=method, inputs={k: v for k, v in composer.inputs.items() if k in asked}
    )
    times = np.arange(0.0, T_END, 2e-3) + 1.03e-3
    found = []
    for i, (condition, holds) in enumerate(conditions):
        want, is_so = T_END * float(np.mean([bool(holds(t)) for t in times])), float(run[f"disc{i}.w"][-1])
        if abs(is_so - want) > 0.012:
            found.append(f"{condition} holds for {is_so:.4f} s, not {want:.3f} s")
    return found
