"""Why a run took the steps that it took: the run is done again with an account of what limited each of them.

A state that limits is told with the element that moves it: that of the fastest mode, at nine instants of the run, in which it
has a part. Knows nothing of blocks.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from gearblocks.codegen.program import Program
from gearblocks.errors import SimulationError
from gearblocks.model.explaining import ModeOfElement, component_of_switch, element_of, mode_of_element
from gearblocks.simulation.arguments import set_inputs
from gearblocks.simulation.case import Case
from gearblocks.simulation.events import Events
from gearblocks.simulation.failures import reason
from gearblocks.simulation.run_explanation import Limit, RunExplanation
from gearblocks.solver.account import Account
from gearblocks.solver.binding import Simulation
from gearblocks.solver.fast_modes import FastMode, fast_modes
from gearblocks.solver.point import Point
from gearblocks.solver.structures import Array, Code

_LOOKS = 9  # instants at which modes are looked for
_PART = 0.2  # of a mode: a state with less has no part in it
_MUCH = 0.2  # of all steps: what is worth a remedy

CAUSES: Mapping[str, tuple[str, str]] = {
    "state": ("error of {of}", ""),
    "massless": ("error of the speeds of shafts without inertia", "give these an inertia"),
    "ledger": ("error of the energy ledger", ""),
    "balance": ("energy balance of the step", ""),
    "defect": ("error between the ends of the step", ""),
    "reach": ("stability: {of} is too fast for the method", "method='rodas'"),
    "feature": ("narrow feature of a law", "a wider transition of what changes over a short way (friction of teeth)"),
    "turn": ("turns of a wrapped angle within a step", ""),
    "most": ("the largest step that was allowed", "a larger max_step (or step)"),
    "event": ("events within the step", ""),
    "doubt": ("event functions that the step did not tell", ""),
    "time": ("announced times: joints of tables over time, time events, the end", "coarser or smoother tables"),
    "failure": ("a rate or a matrix that is no number", ""),
}
"""Words for each cause, and what would help."""


def explained(name: str, method: str, case: Case, events: Events) -> RunExplanation:
    """Why the run of a case took its steps; it is done again."""
    program = case.library.program
    with case.library.open() as sim:
        sim.parameters[:] = case.parameters
        set_inputs(sim, program, case.inputs)
        account, looks = _done_again(sim, case)
        modes = [mode for t, y, m in looks for mode in _modes_at(Point(sim, program, t, y, m))]
    rows = [*_by_states(program, account, modes), *_by_causes(account), *_by_events(program, events)]
    rows.sort(key=lambda row: -(row.steps + row.rejected))
    kept = tuple(row for row in rows if row.steps + row.rejected + row.events)
    return RunExplanation(name, method, kept, tuple(dict.fromkeys(_remedies(program, kept, modes))))


def _done_again(sim: Simulation, case: Case) -> tuple[Account, list[tuple[float, Array, Array]]]:
    """The account of the run, and time, state and modes at some instants of it."""
    account = sim.account()
    code, looks = sim.start(case.options, case.begin, case.y0), []
    for t in np.linspace(case.begin, case.end, _LOOKS + 1)[1:] if code == Code.DONE else ():
        code = sim.advance(float(t))
        if code != Code.DONE:
            break
        looks.append((float(t), sim.state(), sim.modes()))
    if code < 0:
        raise SimulationError(sim.report.t, *reason(case.library.program, code, sim)) from sim.error
    return account, looks


def _modes_at(point: Point) -> list[FastMode]:
    try:
        return fast_modes(point)
    except (RuntimeError, ArithmeticError, np.linalg.LinAlgError):
        point.sim.raise_end()
        return []


def _mode_of(state: int, modes: Sequence[FastMode]) -> FastMode | None:
    """The fastest mode with an element in which a state has a part."""
    having = [m for m in modes if m.shares and m.parts[state] >= _PART * m.parts.max()]
    return max(having, key=lambda mode: mode.rate, default=None)


def _by_states(program: Program, account: Account, modes: Sequence[FastMode]) -> Iterator[Limit]:
    """A row for each element that moves states that limited, or for the owner of these."""
    cause = "reach" if account.accepted["reach"] > account.accepted["state"] else "state"
    found: dict[str, list[tuple[int, int, int]]] = {}
    paces: dict[str, str] = {}
    for i in np.flatnonzero(account.accepted_by + account.rejected_by).tolist():
        mode = _mode_of(i, modes)
        at = mode_of_element(program, mode) if mode is not None else None
        element = at.element if at is not None else program.states[i].name.rsplit(".", 1)[0]
        paces.setdefault(element, f", moved by '{element}', which {at.pace}" if at is not None else "")
        found.setdefault(element, []).append((int(account.accepted_by[i]), int(account.rejected_by[i]), i))
    for element, counts in found.items():
        worst = program.states[max(counts, key=lambda x: x[0] + x[1])[2]].name
        of = worst + (f" and {len(counts) - 1} more" if len(counts) > 1 else "")
        words = CAUSES[cause][0].format(of=of) + paces[element]
        yield Limit(cause, element, sum(x[0] for x in counts), sum(x[1] for x in counts), 0, words)


def _by_causes(account: Account) -> Iterator[Limit]:
    """A row for each cause that is of no state."""
    for cause, (words, _) in CAUSES.items():
        if cause not in ("state", "reach"):
            yield Limit(cause, "", account.accepted[cause], account.rejected[cause], 0, words)


def _by_events(program: Program, events: Events) -> Iterator[Limit]:
    """A row for each component that switched, most first."""
    of = {s.component: component_of_switch(s) for s in program.switches}
    found: dict[str, int] = {}
    for name, number in events.counts().items():
        found[of.get(name, name)] = found.get(of.get(name, name), 0) + number
    for component, number in sorted(found.items(), key=lambda item: -item[1]):
        yield Limit("event", component, 0, 0, number, "what switches")


# -- what would help --------------------------------------------------------------------------------------------------


def _remedies(program: Program, rows: Sequence[Limit], modes: Sequence[FastMode]) -> Iterator[str]:
    total = max(sum(row.steps + row.rejected for row in rows), 1)
    paths = program.parameter_numbers
    for row in rows:
        if row.steps + row.rejected < _MUCH * total:
            continue
        if row.cause in ("state", "reach") and row.component:
            yield from _of_element(row.component, program, modes)
        if CAUSES[row.cause][1]:
            yield CAUSES[row.cause][1]
        if row.cause in ("state", "ledger", "defect", "balance"):
            yield "a larger rtol, where the accuracy allows it (ten times: about a quarter of the steps less)"
    switching = [row for row in rows if row.events > 0.1 * total]
    for row in switching[:2]:
        gone = [x for x in ("backlash", "friction") if any(_has(p, row.component, x) for p in paths)]
        gone += ["backlash"] * (f"{row.component}.half_gap" in paths)
        for effect in gone:
            yield f"rig.without('{row.component}.{effect}') if the question allows it: no events of '{row.component}'"
        if not gone:
            yield f"'{row.component}' switches {row.events} times: look at its inputs, or give what bounces there a loss"


def _of_element(element: str, program: Program, modes: Sequence[FastMode]) -> Iterator[str]:
    """Ways to be rid of a fast mode."""
    rates: dict[str, ModeOfElement] = {}
    for mode in sorted((mode_of_element(program, m) for m in modes if m.shares), key=lambda m: m.rate):
        rates[mode.element] = mode
    own = rates.pop(element, None)
    others = max((mode.rate for mode in rates.values()), default=0.0)
    if own is not None and any(
        c.component == element or element_of(c.component) == element for c in program.energies if c.part == "stored"
    ):
        much = f" (the next element is {own.rate / others:.3g} times slower)" if 0 < others < own.rate else ""
        yield f"rig.without('{element}.compliance') makes it rigid{much}"
    if own is not None and not own.swings:
        yield "method='rodas'"


def _has(path: str, element: str, effect: str) -> bool:
    """Whether a parameter is one of an effect of an element, or of the parts that share its name."""
    owner, found, _ = path.partition(f".{effect}.")
    return bool(found) and element_of(owner) == element
