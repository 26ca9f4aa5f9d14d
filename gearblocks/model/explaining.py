"""What a train has and what will limit the steps of its runs: states, switches, its fastest modes by element.

Modes are those about the start, teeth in contact. Knows nothing of runs.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import pi
from typing import NamedTuple, final

import numpy as np

from gearblocks.codegen.program import Program, SwitchInfo
from gearblocks.errors import GearblocksError
from gearblocks.language.fields import COMPLIANCE
from gearblocks.model.build import build_train, program_of
from gearblocks.pages import small_table
from gearblocks.solver.fast_modes import FastMode, fast_modes
from gearblocks.solver.point import opened
from gearblocks.train.graph import Train
from gearblocks.train.left_out import closed

SHOWN = 5
"""The fastest modes that are told of."""
_KINDS = {
    "coordinate": "relative angles", "state": "states of blocks", "sum": "sums", "speed": "speeds", "angle": "angles",
}  # fmt: skip


class ModeOfElement(NamedTuple):
    """A mode: the element that it strains (or that damps it), its share, abs(s) [1/s], whether it swings, the state that has
    the largest part in it."""

    element: str
    share: float
    rate: float
    swings: bool
    state: str

    @property
    def pace(self) -> str:
        """How fast it is, in words."""
        return f"swings at {self.rate / (2 * pi):.4g} Hz" if self.swings else f"decays at {self.rate:.4g} 1/s"


@final
@dataclass(frozen=True, repr=False)
class TrainExplanation:
    """What a train has. states: how many of each kind; switches: how many each component has, most first; modes: the fastest
    ones, each with its element; rigid: the effect without which that of the fastest one is rigid, "" where it has none."""

    name: str
    states: Mapping[str, int]
    switches: Mapping[str, int]
    modes: tuple[ModeOfElement, ...]
    rigid: str

    @property
    def limiting(self) -> str:
        """The element that will limit the step: that of the fastest mode; "" where no mode is known."""
        return self.modes[0].element if self.modes else ""

    def sentences(self) -> list[str]:
        """What there is to say."""
        kinds = ", ".join(f"{number} {_KINDS[kind]}" for kind, number in self.states.items() if number)
        found = [f"'{self.name}' has {sum(self.states.values())} states ({kinds or 'none'})."]
        if self.switches:
            listed = ", ".join(f"{name} {number}" for name, number in list(self.switches.items())[:SHOWN])
            found.append(
                f"It has {sum(self.switches.values())} switches: {listed}{', ...' * (len(self.switches) > SHOWN)}."
            )
        if not self.modes:
            return [*found, "Its modes are not known."]
        first = self.modes[0]
        share = "" if first.share > 0.995 else f", which holds {100 * first.share:.0f} % of it"
        span = 1.0 / first.rate
        found.append(
            f"'{first.element}' will limit the step: its fastest mode {first.pace}{share}; explicit steps there are about "
            f"{span:.2g} s long{'' if first.swings else ', implicit ones (method=rodas) longer'}."
        )
        other = next((mode for mode in self.modes if mode.element != first.element), None)
        if self.rigid and other is not None:
            found.append(
                f"Without it (rig.without('{self.rigid}')) the next one, of '{other.element}', {other.pace}: "
                f"{first.rate / other.rate:.3g} times slower."
            )
        return found

    def __str__(self) -> str:
        return "\n".join([*self.sentences(), *(f"  {m.element}: {m.pace}, mostly {m.state}" for m in self.modes)])

    def __repr__(self) -> str:
        return f"<explanation of '{self.name}': {sum(self.states.values())} states, limited by '{self.limiting}'>"

    def _repr_html_(self) -> str:
        rows = [(m.element, m.pace, f"{100 * m.share:.0f} %", m.state) for m in self.modes]
        head = ("element", "fastest modes", "its share", "moves most")
        return small_table(f"What limits '{self.name}'", rows, head=head, notes=self.sentences())


def explanation_of(train: Train) -> TrainExplanation:
    """The explanation of a train. Raises ModelError, or CompileError where there is no working compiler."""
    program, _ = program_of(train)
    states = {kind: sum(s.kind == kind for s in program.states) for kind in _KINDS}
    switches = Counter(component_of_switch(s) for s in program.switches)
    modes = _modes(train)
    compliant = {element_of(c.path) for c in train.components if COMPLIANCE in c.block.effects()}
    rigid = f"{modes[0].element}.{COMPLIANCE}" if modes and modes[0].element in compliant else ""
    return TrainExplanation(train.name, states, dict(switches.most_common()), modes, rigid)


def component_of_switch(switch: SwitchInfo) -> str:
    """The component that has a switch."""
    return element_of(switch.component.removesuffix(f".{switch.name}"))


def element_of(component: str) -> str:
    """The name by which the effects of a component are left out: parts of a composite block share theirs ("gear.sun_mesh[1]":
    "gear.sun_mesh", "shaft.spring[1]": "shaft")."""
    whole, bracket, _ = component.rpartition("[")
    return component if not bracket else whole.removesuffix(".spring")


def mode_of_element(program: Program, mode: FastMode) -> ModeOfElement:
    """A mode in words."""
    state = program.states[int(np.argmax(mode.parts))].name
    shares = shares_by_element(mode)
    element = max(shares, key=shares.__getitem__)
    return ModeOfElement(element, shares[element], mode.rate, mode.swings, state)


def shares_by_element(mode: FastMode) -> dict[str, float]:
    """Shares in a mode, those of the parts of one element together."""
    found: dict[str, float] = {}
    for component, share in mode.shares.items():
        found[element_of(component)] = found.get(element_of(component), 0.0) + share
    return found


def _modes(train: Train) -> tuple[ModeOfElement, ...]:
    """The fastest modes about the start, teeth in contact."""
    touching = replace(train, components=tuple(c._replace(block=closed(c.block)) for c in train.components))
    try:
        model = build_train(touching)
        program = model.program
        with model.library.open() as sim:
            sim.parameters[:], sim.inputs[:] = model.values, program.input_starts
            with opened(sim, program, 0.0) as point:
                found = fast_modes(point)
    except (GearblocksError, RuntimeError, ArithmeticError):
        return ()
    listed = [mode_of_element(program, mode) for mode in found if mode.shares]
    others = next((i for i, mode in enumerate(listed) if mode.element != listed[0].element), 0)
    return tuple(listed[:SHOWN] if others < SHOWN else [*listed[: SHOWN - 1], listed[others]])
