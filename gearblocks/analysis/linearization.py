"""Linearization of a train about an operating point: state matrices and frequency response, in frozen modes.

    dx/dt = A x + B u,   y = C x + D u        for small deviations; contacts keep their side, the active set stays

The operating point: at="static" (equilibrium with every excitation at its mean, contact side from the load),
"static_at_start" (equilibrium under everything as it is at t), None (the start values), a dict of start values, or an
earlier run (its end).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, final

import numpy as np
from numpy.typing import NDArray

from gearblocks.analysis.operating_point import OperatingPoint, operating_point
from gearblocks.analysis.printed_linearization import document
from gearblocks.analysis.reduction import reduction
from gearblocks.codegen.program import Program
from gearblocks.drivetrain import Drivetrain
from gearblocks.errors import ParameterError, UnknownNameError, arguments_told, by_name_only, did_you_mean
from gearblocks.language.tidy import Tidy
from gearblocks.language.units import frequencies_in_si
from gearblocks.model.value_rules import check_bounds
from gearblocks.plurals import singular
from gearblocks.running import build
from gearblocks.simulation.arguments import (
    InputSource,
    listed,
    picked_outputs,
    resolve,
)  # fmt: skip
from gearblocks.simulation.plausibility import warn_of_parameters
from gearblocks.simulation.plotting import COLOURS, DASHES, finished, legend, new_figure, style
from gearblocks.solver.library import Model
from gearblocks.solver.point import Point, derivative, restarted, state_matrix, steps_of
from gearblocks.solver.sparse_maps import Indices
from gearblocks.solver.structures import Array

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from gearblocks.equations.document import Document

Complex = NDArray[np.complex128]

DENSE = 1000
"""States up to which matrices are full arrays; longer trains stay sparse."""

_CANCELS = 1e-9  # of two parts, each told by differences: their sum is rounding
_SIDES = {-1.0: "coast side", 0.0: "no contact", 1.0: "drive side"}


# -- state matrices ---------------------------------------------------------------------------------------------------


@final
@arguments_told
@dataclass(frozen=True, eq=False)
class Linearization(metaclass=Tidy):
    """dx/dt = A x + B u, y = C x + D u for small deviations from a point, contacts keeping their side.

    Active switched constraints (stuck, closed) act as rigid constraints: dependent states are left out. What slides acts by
    the slope of its force over the slip. `modes` has for friction 0 stuck, 1 and -1 sliding, 2 free; for a stop 1 closed,
    0 open.

    A, B, C, D: arrays (A and C sparse beyond 1000 states); states, inputs, outputs: their names; modes: the mode
    of every switch by the name of its component; point: the state that they hold at, by name; t [s].
    """

    A: Any
    B: Array
    C: Any
    D: Array
    states: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    modes: Mapping[str, float]
    point: Mapping[str, float]
    t: float
    words: str

    def __str__(self) -> str:
        return self.words

    def __repr__(self) -> str:
        counts = f"{len(self.states)} states, {len(self.inputs)} inputs, {len(self.outputs)} outputs"
        return singular(f"<Linearization of {self.words.partition(':')[0]!r} at t = {self.t:g} s: {counts}>")

    def document(self) -> Document:
        """The matrices as printed equations: str(), latex(), html() and mathml() of it."""
        return document(self)

    def latex(self) -> str:
        """The matrices as LaTeX, for a document with amsmath."""
        return self.document().latex()

    def _repr_html_(self) -> str:
        return self.document()._repr_html_()

    def response(self, frequencies: Any) -> Complex:
        """C (i w - A)^-1 B + D at angular frequencies [rad/s], shape (frequencies, outputs, inputs).

        Raises ParameterError at a frequency where the response has no bound.
        """
        w = frequencies_in_si("frequencies", frequencies)
        found = np.empty((len(w), len(self.outputs), len(self.inputs)), dtype=complex)
        for row, one in enumerate(w):
            x = self._solved(complex(0.0, one))
            if not np.isfinite(x).all():
                raise ParameterError(
                    f"at {one:g} rad/s the response has no bound: the train turns freely or is not damped there"
                )
            found[row] = self.C @ x + self.D
        return found

    def _solved(self, s: complex) -> Complex:
        """(s - A)^-1 B."""
        n = self.A.shape[0]
        try:
            if isinstance(self.A, np.ndarray):
                return np.asarray(np.linalg.solve(s * np.eye(n) - self.A, self.B), dtype=np.complex128)
            from scipy.sparse import csc_array, eye_array
            from scipy.sparse.linalg import splu

            return np.asarray(splu(csc_array(eye_array(n, dtype=complex) * s - self.A)).solve(self.B.astype(complex)))
        except (np.linalg.LinAlgError, RuntimeError):  # exactly singular
            return np.full(self.B.shape, np.nan, dtype=complex)


@by_name_only
def linearize(
    train: Drivetrain | Model, at: OperatingPoint = "static", *,
    inputs: str | Sequence[str] | Mapping[str, InputSource] | None = None, outputs: str | Sequence[str] = "*",
    t: float | None = None, parameters: Mapping[str, float | str] | None = None,
) -> Linearization:  # fmt: skip
    """The state matrices of a train at a point.

    at: "static" (the equilibrium with every excitation at its mean, contact side from the load), "static_at_start" (under
    everything as it is at t), None (the start values), a dict of start values, an earlier run (its end), "rolling".
    inputs: names of Inputs (default: all) or paths of tunable parameters such as "load.tau"; as a dict with the values
    that the Inputs have at the point. outputs: patterns; one that needs an absolute angle brings it along as a state
    ("*" leaves such outputs out); their order stays. t: instant [s], default 0 or the end of the run.
    """
    model = build(train)
    program = model.program
    warn_of_parameters(model, parameters)
    values = {n: v for n, v in inputs.items() if _is_input(program, n)} if isinstance(inputs, Mapping) else {}
    with operating_point(model, at, t, parameters, values) as point:
        columns, pick = _outputs(point, outputs)
        A = _with_angles(point, columns)
        C = _output_matrix(point, columns, pick, A)
        names = (
            [x.name for x in program.inputs]
            if inputs is None
            else [inputs]
            if isinstance(inputs, str)
            else list(inputs)
        )
        B, D = _inputs(point, names, columns, pick)
        small = reduction(point, len(columns))
        if small is not None:
            small = small.without_still(point, A, B)
            A, B, C, columns = small.matrix(A), B[small.kept], C @ small.R, columns[small.kept]
        states = tuple(_state_names(program, columns))
        switches = {s.component: float(m) for s, m in zip(program.switches, point.modes, strict=True)}
        for constraint in point.sim.constraints().shown:
            switches[program.switches[constraint.slip].component] = constraint.shown(point.modes)
        full = len(columns) <= DENSE
        return Linearization(
            A.toarray() if full else A, B, C.toarray() if full else C, D, states, tuple(names),
            tuple(program.outputs[i].name for i in pick), switches,
            dict(zip(states, map(float, point.y[columns]), strict=True)), point.t, _words(point, states),
        )  # fmt: skip


def _is_input(program: Program, name: str) -> bool:
    return any(x.name == name or x.name.endswith("." + name) for x in program.inputs)


def _words(point: Point, states: Sequence[str]) -> str:
    """What was linearised, in a sentence, with the side of every contact."""
    constraints = point.sim.constraints().constraints
    of_constraints = {i for x in constraints for i in (x.slip, x.active, x.free)}
    contacts = [
        f"{s.component}: {_SIDES[float(m)]}"
        for i, (s, m) in enumerate(zip(point.program.switches, point.modes, strict=True))
        if not s.name and float(m) in _SIDES and i not in of_constraints
    ]
    shown = point.sim.constraints().shown
    contacts += [f"{point.program.switches[x.slip].component}: {x.words(point.modes)}" for x in shown]
    means = ", excitations at their means" if point.means else ""
    sides = f"; {', '.join(contacts)}" if contacts else ""
    return singular(f"{point.program.name}: {len(states)} states at t = {point.t:g} s{means}{sides}")


def _outputs(point: Point, wanted: str | Sequence[str]) -> tuple[Indices, list[int]]:
    """Indices of the states and of the outputs; unread angles only where an output needs them."""
    program = point.program
    patterns = [wanted] if isinstance(wanted, str) or not isinstance(wanted, Iterable) else list(wanted)
    numbers = dict.fromkeys(i for pattern in patterns for i in picked_outputs(program, pattern).values())
    pick = np.array(list(numbers), dtype=np.intp)
    unread = np.array([x.offset for x in program.integrals if x.part == "angle"], dtype=np.intp)
    columns = np.arange(program.n)
    turned = point.y.copy()
    turned[unread] += 1.0
    needing = (point.outputs(turned) != point.outputs())[pick]
    if wanted == "*":
        pick = pick[~needing]
    elif needing.any():
        columns = np.concatenate([columns, unread])
    return columns, [int(i) for i in pick]


def _output_matrix(point: Point, columns: Indices, pick: list[int], A: Any) -> Any:
    """C. Accelerations and reactions follow from the rates: their part is that of A, to the last digit; where both parts
    cancel, as in the torque on a free end, nothing is left."""
    rates = point.rates()
    ones = np.maximum(np.abs(rates), 1.0)
    direct = derivative(lambda y: point.outputs(y, rates)[pick], point.y, columns, steps_of(point.program, point.y))
    through = derivative(lambda dy: point.outputs(rates=dy)[pick], rates, columns, ones)
    inner = through @ A
    found = direct + inner
    return found.multiply(abs(found) > _CANCELS * (abs(direct) + abs(inner)))


def _with_angles(point: Point, columns: Indices) -> Any:
    """A over these entries of the state vector: the states, and unread angles, which move no state."""
    from scipy.sparse import block_array, csc_array

    n = point.program.n
    A, unread = state_matrix(point), columns[n:]
    if len(unread) == 0:
        return A
    turning = derivative(lambda y: point.rates(y)[unread], point.y, np.arange(n), steps_of(point.program, point.y))
    return block_array([[A, None], [turning, csc_array((len(unread), len(unread)))]], format="csc")


def _state_names(program: Program, columns: Indices) -> Iterator[str]:
    outputs = {q.name for q in program.outputs}
    unread = {
        x.offset: f"{x.component}.{'s' if f'{x.component}.s' in outputs else 'phi'}"
        for x in program.integrals
        if x.part == "angle"
    }
    for i in columns:
        yield program.states[i].name if i < program.n else unread[int(i)]


def _inputs(point: Point, names: Sequence[str], columns: Indices, pick: list[int]) -> tuple[Array, Array]:
    """B and D, column by column."""
    program = point.program
    inputs = {x.name: i for i, x in enumerate(program.inputs)}
    paths = {p.path: i for i, p in enumerate(program.parameters) if p.tunable}
    B, D = np.zeros((len(columns), len(names))), np.zeros((len(pick), len(names)))
    for j, name in enumerate(names):
        if _is_input(program, name):
            up, down, width = _moved_input(point, resolve(name, inputs, "input"), columns, pick)
        elif name in paths or any(path.endswith("." + name) for path in paths):
            up, down, width = _moved_parameter(point, resolve(name, paths, "parameter"), columns, pick)
        else:
            raise UnknownNameError(
                f"there is no input or tunable parameter '{name}'; there are {listed([*inputs, *paths])}"
                f"{did_you_mean(name, [*inputs, *paths])}"
            )
        slope = (up - down) / width
        B[:, j], D[:, j] = slope[: len(columns)], slope[len(columns) :]
    return B, D


def _seen(point: Point, columns: Indices, pick: list[int]) -> Array:
    return np.concatenate([point.rates()[columns], point.outputs()[pick]])


def _moved_input(point: Point, i: int, columns: Indices, pick: list[int]) -> tuple[Array, Array, float]:
    assert point.u is not None
    step = 6e-6 * max(abs(point.u[i]), 1.0)
    found = []
    for sign in (1, -1):
        u = point.u.copy()
        u[i] += sign * step
        found.append(_seen(point.at(u=u), columns, pick))
    return found[0], found[1], 2 * step


def _moved_parameter(point: Point, i: int, columns: Indices, pick: list[int]) -> tuple[Array, Array, float]:
    value = float(point.sim.parameters[i])
    info = point.program.parameters[i]
    step = 6e-6 * (abs(value) or 1.0)
    found = []
    for sign in (1, -1):
        check_bounds(info, value + sign * step)
        point.sim.parameters[i] = value + sign * step
        restarted(point)
        found.append(_seen(point, columns, pick))
    point.sim.parameters[i] = value
    restarted(point)
    return found[0], found[1], 2 * step


# -- frequency response -----------------------------------------------------------------------------------------------


@final
@arguments_told
@dataclass(frozen=True, eq=False)
class FrequencyResponse(metaclass=Tidy):
    """Complex response of outputs to a harmonic input: output = Re(H exp(i w t)) for the input cos(w t).

    frequencies [rad/s]; values: shape (frequencies, outputs); units: of the outputs, per unit of the input.
    """

    name: str
    input: str
    outputs: tuple[str, ...]
    frequencies: Array
    values: Complex
    units: tuple[str, ...]

    def __getitem__(self, output: str) -> Complex:
        if output not in self.outputs:
            raise UnknownNameError(f"there is no output '{output}'{did_you_mean(output, self.outputs)}")
        return self.values[:, self.outputs.index(output)]

    def __repr__(self) -> str:
        listed = ", ".join(self.outputs[:3]) + (f", ... ({len(self.outputs)})" if len(self.outputs) > 3 else "")
        return singular(
            f"<FrequencyResponse of '{self.name}' to {self.input} at {len(self.frequencies)} frequencies: {listed}>"
        )

    def plot(self, path: Any = None) -> Figure:
        """Magnitude and phase over the frequency in Hz (Bode); saved to `path` where given."""

        return bode(self, path)


@by_name_only
def frequency_response(
    train: Drivetrain | Model, input: str, outputs: str | Sequence[str], frequencies: Any, *, at: OperatingPoint = "static",
    t: float | None = None, parameters: Mapping[str, float | str] | None = None,
) -> FrequencyResponse:  # fmt: skip
    """The response of outputs to an Input, or to a tunable parameter such as "load.tau", at frequencies in rad/s, or such as
    "3000 rpm" or "50 Hz"; at: as of `linearize`."""
    if not isinstance(input, str):
        raise ParameterError(f"input = {input!r:.80} must be the name of one, as text; write a response for each")
    model = build(train)
    found = linearize(model, at, inputs=[input], outputs=outputs, t=t, parameters=parameters)
    w = frequencies_in_si("frequencies", frequencies)
    if not len(w) or not found.outputs:
        given = f"frequencies = {frequencies!r:.80}" if found.outputs else f"outputs = {outputs!r:.80}"
        raise ParameterError(
            f"{given} must be one or more, such as frequency_response(train, 'u', 'mesh.force', ['50 Hz'])"
        )
    units = {q.name: q.unit for q in model.program.outputs}
    return FrequencyResponse(
        model.program.name, input, found.outputs, w, found.response(w)[:, :, 0], tuple(units[n] for n in found.outputs)
    )


def bode(response: FrequencyResponse, path: Any) -> Figure:
    """Magnitude and phase over the frequency in Hz."""
    hertz = response.frequencies / (2 * np.pi)
    with style():
        figure, (upper, lower) = new_figure(path, rows=2, size=(7.2, 4.8))
        for i, name in enumerate(response.outputs):
            value = response.values[:, i]
            look: dict[str, Any] = {"color": COLOURS[i % 8], "linestyle": DASHES[i // 8 % len(DASHES)], "label": name}
            upper.loglog(hertz, np.abs(value), **look)
            lower.semilogx(hertz, np.rad2deg(np.unwrap(np.angle(value))), **look)
        units = set(response.units)
        upper.set_ylabel("magnitude" + (f" in {units.pop()}\nper unit of the input" if len(units) == 1 else ""))
        lower.set_ylabel("phase in degrees")
        lower.set_xlabel("frequency in Hz")
        upper.set_title(f"{response.name}: response to {response.input}")
        legend(upper, lower, loc="upper left", bbox_to_anchor=(1.0, 1.0))
        return finished(figure, path)
