"""Why a run stopped, in words: the name of the element, the cause and the way out, from a code of the C core.

Knows nothing of trajectories.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress

import numpy as np

from gearblocks.codegen.program import Program
from gearblocks.model.explaining import mode_of_element
from gearblocks.solver.binding import Simulation
from gearblocks.solver.fast_modes import fast_modes
from gearblocks.solver.point import Point
from gearblocks.solver.structures import Array, Code


def reason(program: Program, code: Code, sim: Simulation) -> tuple[str, str, str]:
    """(component, cause, remedy) of why a simulation stopped. Raises what an input function ended the program with."""
    sim.raise_end()
    report = sim.report
    cause, remedy = _CAUSES.get(code, (f"the solver answered {code.name}", ""))
    if code == Code.ERR_CALLBACK and sim.error is not None:
        cause = f"the input function raised {type(sim.error).__name__}: {sim.error}"
    if code == Code.ERR_CHATTER and report.value >= _CROWD:
        cause, remedy = f"{report.value:.0f} events in a row hardly bring the run on", _CROWDED
    if code == Code.ERR_STALL:
        cause = f"{report.value:.0f} steps or tries in a row hardly bring the run on"
        remedy = _IN_DOUBT if report.index >= program.n else remedy
    if code == Code.ERR_CHATTER and report.value < 0:
        switch = program.switches[report.index].name
        its = f"its {switch}" if switch else "its slip"
        cause = f"{-report.value:.0f} swings of {its} about its limit, too narrow to be told, come to no rest"
        remedy = _NARROW
        if component_of(program, code, report.index) in {slip.component for slip in program.algebraic_slips}:
            remedy = f"{_FALLING}; or {_NARROW}"
    if code == Code.ERR_CHATTER and report.value == _STRUCK_BACK:
        return component_of(program, code, report.index), *_WITHOUT_END
    if code == Code.ERR_LOSS and report.value == _TWO_MOTIONS:
        cause = _SEVERAL
    elif code == Code.ERR_LOSS and report.value == _SHARED_LOAD:
        cause, remedy = _SHARED
    massless = [
        p.path
        for p, v in zip(program.parameters, sim.parameters, strict=True)
        if p.path.endswith((".J", ".m")) and v == 0
    ]
    of_rates = code in (Code.ERR_NAN_RATE, Code.ERR_NAN_START)
    untold = of_rates or code in _AT_INFINITY or code == Code.ERR_CHATTER
    if untold and (program.algebraic_slips or not massless) and (flange := _free_flange(program, sim)):
        element, _, side = flange.rpartition(".")
        return element, f"nothing tells how fast its side {side} turns, a shaft without inertia", _FREE
    if of_rates and massless:
        remedy = (
            f"{', '.join(massless[:3])} = 0: a shaft without inertia moves by what damps it, in every mode (teeth in their "
            "gap damp nothing): give a spring beside it a c, contact_damping='always', or the shaft an inertia"
        )
    elif code in _AT_INFINITY and (source := _source(program, sim)):
        body = component_of(program, code, report.index)
        moves = f"; it moves '{body}'" if body and code == Code.ERR_NAN_RATE else ""
        if _has_no_speed(program, sim, source[0]):
            return source[0], _NO_SPEED, _OF_A_LOAD + moves
        return source[0], source[1], _OF_A_SOURCE + moves
    return component_of(program, code, report.index), cause, remedy


def _free_flange(program: Program, sim: Simulation) -> str | None:
    """A flange of friction at a shaft without inertia, or else of an element between two flanges, whose speed has no number
    where a run stopped, or shortly ahead."""
    slips, names = {slip.component for slip in program.algebraic_slips}, program.output_numbers
    flanges = [n.removesuffix(".w") for n in names if n.endswith(".w") and f"{n.removesuffix('.w')}.tau" in names]
    count = Counter(flange.rpartition(".")[0] for flange in flanges)
    for values in _ahead(sim, len(program.switches)):
        free = [flange for flange in flanges if np.isnan(values[names[f"{flange}.w"]])]
        # a source may have no number itself
        sources = [flange for flange in free if count[flange.rpartition(".")[0]] == 1]
        first = next((flange for flange in free if flange.rpartition(".")[0] in slips), None)
        if first or free:
            return first or (None if sources else free[0])
    return None


def _has_no_speed(program: Program, sim: Simulation, element: str) -> bool:
    """Whether a flange of an element has no speed where a run stopped: one without inertia, as all others are states."""
    own = {name: i for name, i in program.output_numbers.items() if name.startswith(f"{element}.")}
    speeds = [i for name, i in own.items() if name.endswith(".w")]
    for values in _ahead(sim, len(program.switches)):
        if np.isnan(values[list(own.values())]).any():
            return bool(np.isnan(values[speeds]).any())
    return False


def _source(program: Program, sim: Simulation) -> tuple[str, str] | None:
    """The element whose law gives no finite number where a run stopped, or shortly ahead, and which of its outputs that is: of
    several the one with fewest flanges. None where all are finite, or bodies and flanges alone are not."""
    names = list(program.outputs.names())
    bodies = {name.removesuffix(".alpha") for name in names if name.endswith(".alpha")}
    for values in _ahead(sim, len(program.switches)):
        found: list[tuple[int, int]] = []
        for i in map(int, np.flatnonzero(~np.isfinite(values))):
            element, _, shown = names[i].rpartition(".")
            if element not in bodies and shown not in _OF_FLANGES:
                flanges = sum(name.startswith(f"{element}.") and name.endswith(".tau") for name in names)
                found.append((flanges, i))
        if found:
            i = min(found)[1]
            became = "NaN" if np.isnan(values[i]) else "infinite"
            return names[i].rpartition(".")[0], f"its {program.outputs[i].words} ({names[i]}) became {became}"
    return None


def _ahead(sim: Simulation, switches: int) -> Iterator[Array]:
    """All outputs where a run stopped, in its modes if it began, with states a little later, and beside those as stages are."""
    t, modes = sim.report.t, np.zeros(switches)
    try:
        y = sim.state(stopped=True)
        with suppress(RuntimeError):
            modes = sim.modes()
        yield sim.probe(t, y, modes, "outputs")
        rates = sim.probe(t, y, modes, "rates")
        for seconds in (1e-9, 1e-6, 1e-3):
            yield sim.probe(t, y + seconds * rates, modes, "outputs")
        yield sim.probe(t, y + 1e-6 * rates * np.linspace(0.5, 1.5, len(y)), modes, "outputs")
    except (RuntimeError, ArithmeticError, ValueError):
        sim.raise_end()


def too_long(
    sim: Simulation, program: Program, step: float, pieces: Sequence[Array], known: tuple[str, str, str]
) -> tuple[str, str, str]:
    """The reason for a fixed step that is too long, with the step, and the element of the fastest mode on the way."""
    name, cause, remedy = known
    cause = cause.replace("the fixed step", f"the fixed step = {step:g} s", 1)
    rows, fastest = np.concatenate(pieces), None
    for row in rows[np.unique(np.linspace(0, len(rows) - 1, _LOOKS).astype(int))]:
        y, modes = row[1 : 1 + program.n_total], row[1 + program.n_total :][: len(program.switches)]
        try:
            found = [mode for mode in fast_modes(Point(sim, program, float(row[0]), y, modes)) if mode.shares]
        except (RuntimeError, ArithmeticError, ValueError):
            continue
        for mode in found[:1]:
            if fastest is None or mode.rate > fastest.rate:
                fastest = mode_of_element(program, mode)
    if fastest is None:
        return name, cause, remedy
    return (
        fastest.element,
        f"{cause} (its fastest mode {fastest.pace})",
        f"{remedy}; about {1 / fastest.rate:.1g} s would do",
    )


def remedy_beside_jumps(told: str, remedy: str, modes: Mapping[str, float]) -> str:
    """What to do where a switch of `told` flips without progress, from the modes by name: where conditions of other elements
    hold the motion on their limits (a mode half way between two), it is their jumps that need a width first."""
    held = {name.partition(".switch ")[0]: None for name, mode in modes.items() if mode % 1.0 == 0.5}
    if not held or told in held or remedy != _CAUSES[Code.ERR_CHATTER][1]:
        return remedy
    others = ", ".join(f"'{name}'" for name in held)
    return (
        f"the law of {others} jumps against the motion on both sides and holds it on its limit meanwhile: give that jump a "
        "width first (a steep line)"
    )


def component_of(program: Program, code: Code, index: int) -> str:
    """The component or input that a code's index means."""
    if code in (Code.ERR_NAN_INPUT, Code.ERR_CALLBACK):
        return program.inputs[index].name if 0 <= index < len(program.inputs) else ""
    if code is Code.ERR_STALL and index >= program.n:
        code, index = Code.ERR_CHATTER, index - program.n
    if code in (Code.ERR_CHATTER, Code.ERR_BRANCH, Code.ERR_LOSS, Code.ERR_BEYOND):
        if not 0 <= index < len(program.switches):
            return ""
        switch = program.switches[index]
        return switch.component.removesuffix(f".{switch.name}")
    if 0 <= index < len(program.states):
        return program.states[index].name.rsplit(".", 1)[0]
    if code == Code.ERR_NAN_START and index >= program.n:
        return program.parameters[index - program.n].path
    return ""


_AT_INFINITY = (Code.ERR_NAN_RATE, Code.ERR_LOSS, Code.ERR_BRANCH)
"""What a law without a finite number ends in."""

_OF_FLANGES = ("phi", "w", "alpha", "tau", "power", "s", "v", "a", "f")
"""Outputs that follow from what others do."""

_OF_A_SOURCE = (
    "look in its values and expressions for a division by 0, a root or logarithm of less than 0; gb.maximum and gb.piecewise "
    "keep away from there"
)

_NO_SPEED = "its shaft has no inertia, and no speed at which the torques on it are in balance"
_OF_A_LOAD = (
    "a load that has come to its largest torque lets go there (a brake by eddy currents, a tyre at its grip): give the shaft "
    "an Inertia; or its law has no number: look for a division by 0, a root or logarithm of less than 0"
)
"""Of a law at a shaft without inertia."""

_FALLING = (
    "where its friction falls with the slip by more than the c beside it damps, the slip of a shaft without inertia jumps: "
    "give the springs more c, or the shaft an Inertia"
)

_FREE = (
    "in this mode nothing holds it: friction that is free, teeth in their gap and clipped contact damping hold nothing, and "
    "friction that falls with the slip by more than the c beside damps lets go; "
    "give a spring beside it a c, a gap contact_damping='always', or the shaft an Inertia, or a Damper to the ground "
    "(of 1e-5 of the c of its gaps: what has inertia hardly feels it)"
)
"""Where the balance of a shaft without inertia has no answer."""

_LOOKS = 16
"""Rows of a run at which its fastest mode is looked for: teeth are in contact at some."""

_CROWD = 1000
"""Flips in the report of a switch without progress: more are events that follow on each other too closely (gb_run.c)."""

_CROWDED = "what bounces or chatters there needs a loss, a compliance or a shorter run"

_NARROW = (
    "its law jumps there against the motion: give the jump a width (a steep line), or beside a jump over an angle take an "
    "element that sticks (Brake, BearingFriction)"
)

_IN_DOUBT = (
    "whether it holds there is told by rounding: give a looser rtol or another method, or put a compliance or an inertia "
    "beside what several elements hold at once"
)
"""Of a switch that no step is short enough to tell of."""

_STRUCK_BACK = 0.5
"""Value in the report of an impact without an end (gb_impact.c)."""

_WITHOUT_END = (
    "it strikes without loss and is struck back at once, without progress of time",
    "limits at the same place leave no room to move in, or a light body is struck from both sides for ever: give one of these "
    "contacts a restitution below 1, or some room between them",
)

_TWO_MOTIONS, _SHARED_LOAD = 2.0, 3.0
"""Values in the report of ERR_LOSS (gb_lossy_gear.c)."""

_SHARED = (
    "it shares its load with a lock beside it, and what it loses depends on how: no even split agrees with its losses",
    "the compliances tell how much each of them carries: put a compliant Shaft into that loop, or leave one of the two out",
)
"""Cause and remedy where a lossy gear and a lock tie the same shafts."""

_SEVERAL = (
    "two motions agree with its losses: it drives, or it jams while it turns, as its friction grows faster than what it slows "
    "down, and nothing before the start tells which"
)
"""Beside the cause of ERR_LOSS."""

_CAUSES: dict[Code, tuple[str, str]] = {
    Code.ERR_STEP: (
        "the step size fell below rounding", "the train may be stiff there or have a discontinuity that no switch locates"
    ),
    Code.ERR_NAN_RATE: (
        "a derivative became NaN or infinite",
        "look at the values of this component, and in the laws of what acts on it for a division by 0 or a root of less"
    ),
    Code.ERR_NAN_INPUT: ("the input became NaN or infinite", "the input must give a finite number at every time"),
    Code.ERR_NAN_START: ("a start value or parameter is NaN or infinite", "give it a finite number"),
    Code.ERR_CHATTER: (
        "a switch goes back and forth without progress of time",
        "its law jumps against the motion on both sides, which would hold it there, and it cannot: take an element that sticks "
        "(Brake, Clutch, BearingFriction), or give the jump a width (a steep line; a Vehicle with tyre: rolling_speed)",
    ),
    Code.ERR_BRANCH: (
        "no set of modes fits the state",
        "the conditions of this component contradict each other, or it jams with others: locks around a ratio that varies hold "
        "it where it is 1 and would have to stop at once as it goes on; put a compliant Shaft into that loop",
    ),
    Code.ERR_LOSS: (
        "no motion agrees with its losses: it jams while it turns, as its friction grows faster than what slows it down",
        "a load at b of a self-locking gear (efficiency below 0) whose driving side has too little inertia; give that side "
        "J > -efficiency J_b/ratio^2, start it at rest, put a compliant shaft beside, or raise the efficiency",
    ),
    Code.ERR_BEYOND: (
        "the start values contradict it", "start between the limits of a stop, and beside a lossy gear as its ratio says"
    ),
    Code.ERR_UNSTABLE: (
        "the fixed step is too long: outside the stability of its method, steps are wrong by as much as there is motion",
        "give a shorter step=, or leave it out: without it a method finds its own steps",
    ),
    Code.ERR_ESCAPE: (
        "the motion grows without bound",
        "look for what feeds it: a torque that rises with its own speed or angle, an expression that divides by what passes 0, "
        "a stiffness below zero, a resonance without damping",
    ),
    Code.ERR_JUMP: (
        "friction on a shaft without inertia and damping jumps, and with it the twist of the spring that it loads",
        "how a spring gets there nothing says: give it a c, or its shaft an inertia; peak = 1 and a capacity that does not "
        "jump need neither",
    ),
    Code.ERR_STALL: (
        "steps hardly bring the run on",
        "motion there is quicker by far than the run is long (or step= or max_step= far too short for it): look for a "
        "stiffness, damping or inertia in a wrong unit; where such motion dies out at once, method='auto' or 'rodas' goes on",
    ),
    Code.ERR_SINGULAR: (
        "the matrix of an implicit step has no inverse", "this part can move without inertia, damping or stiffness"
    ),
    Code.ERR_MEMORY: ("there is not enough memory", ""),
    Code.ERR_CALLBACK: ("the input function raised an exception", "it must answer a number to a time in s"),
}  # fmt: skip
