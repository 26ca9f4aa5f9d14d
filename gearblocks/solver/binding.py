"""Binding of the solver core (c/gb_core.h): the same structures, the same calls, no policy of its own."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Sequence
from types import TracebackType
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from gearblocks.codegen.jacobian.sparsity import Pattern
from gearblocks.codegen.program import Program
from gearblocks.solver.account import Account
from gearblocks.solver.dense_jacobian import DenseJacobian
from gearblocks.solver.memory import NOTHING, SMALL, SPARE, Memory, taken, view
from gearblocks.solver.record import Record
from gearblocks.solver.step_matrix import (
    ColumnGroups,
    StepMatrix,
    full_matrix,
    matrix_at,
    pattern_of,
    sizes_of,
    state_jacobian,
)
from gearblocks.solver.structures import (
    CODES,
    Array,
    Code,
    Counters,
    InputFunction,
    Kind,
    Options,
    PointStructure,
    Report,
    address,
)
from gearblocks.solver.switched_constraints import ConstraintsAtPoint, ModelConstraints, constraints_at, constraints_of
from gearblocks.solver.watches import Watches

_PROBED = ("rates", "outputs", "energies", "modes", "surfaces")  # in the order of gb_probe


class Simulation:
    """One run of one model (its gb_model): owns the solver's memory and gives it back on close. Use as a context manager.

    Calls answer a `Code`. `error` holds the exception of an input function that stopped the run. spare: memory of earlier
    simulations that ended well and had numbers for inputs only: it is used again, with the parameters and inputs that it
    has, since a start clears all else.
    """

    def __init__(self, shared: ctypes.CDLL, native: int, program: Program, spare: list[Memory] | None = None) -> None:
        self._sim: int | None = None
        self._shared, self._native, self._program, self._spare = shared, native, program, spare
        memory = taken(spare) or self._allocated()
        self._sim, self.parameters, self.inputs, self._record = memory
        self._kept: list[object] = []
        self._pattern: Pattern | None = None
        self._groups: ColumnGroups | None = None
        self._dense: DenseJacobian | None = None
        self._constraints: ModelConstraints | None = None
        self.error: BaseException | None = None

    def _allocated(self) -> Memory:
        program = self._program
        sim = self._shared.gb_open(self._native)
        if not sim:
            raise MemoryError(f"no memory for a simulation of '{program.name}'")
        parameters = view(self._shared.gb_parameters(sim), len(program.parameters))
        return Memory(sim, parameters, view(self._shared.gb_inputs(sim), len(program.inputs)), None)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if kind is None and self._spare is not None and self._sim is not None and self._is_like_new():
            self._spare.append(Memory(self._sim, self.parameters, self.inputs, self._record))
            self._sim = None
            self.parameters = self.inputs = NOTHING
        self.close()
        if isinstance(error, Exception):
            self.raise_end()

    def raise_end(self) -> None:
        """Raises what an input function raised to end the program (Ctrl-C, sys.exit), if one did."""
        if self.error is not None and not isinstance(self.error, Exception):
            raise self.error

    def _is_like_new(self) -> bool:
        """Whether the memory may serve another simulation: small, with nothing tied to it."""
        small = self._program.n_total <= SMALL and self._spare is not None and len(self._spare) < SPARE
        return small and not self._kept and self.error is None

    def __del__(self) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<Simulation of '{self._program.name}'{', closed' if self._sim is None else ''}>"

    def close(self) -> None:
        """Gives the memory back. Views of `parameters` and `inputs` end here; a second call does nothing."""
        if self._sim is not None:
            self._shared.gb_close(self._sim)
            self._sim = None
            self.parameters = self.inputs = NOTHING
            self._kept.clear()

    def record(self, rows: int | None = None) -> Record:
        """An empty record; rows: as many as there can be at most, where that is known."""
        if rows is None and self._record is not None:
            record, self._record = self._record, None
            return record
        program = self._program
        return Record(1 + program.n_total + len(program.switches) + len(program.inputs), rows)

    def give(self, record: Record) -> None:
        """Takes a record back that nobody writes to or reads any more."""
        record.raw.watches = None
        self._record = record if record.is_new else None

    def changed(self) -> None:
        """Tells the solver that `parameters` or `inputs` were written."""
        self._shared.gb_changed(self._sim)

    def set_table(
        self, index: int, kind: Kind, x: Array, y: Array, second: Array | None = None, period: float = 0.0
    ) -> Code:
        """Input `index` follows a table; `second`: second derivatives of a cubic one; period 0: constant outside."""
        x, y = np.ascontiguousarray(x, dtype=np.float64), np.ascontiguousarray(y, dtype=np.float64)
        third = None if second is None else np.ascontiguousarray(second, dtype=np.float64)
        self._kept.append((x, y, third))
        return Code(
            self._shared.gb_input_table(self._sim, index, kind, len(x), address(x), address(y), address(third), period)
        )

    def set_function(self, index: int, function: Callable[[float], float]) -> None:
        """Input `index` follows a Python function of time, called per stage. Its exception stops the run (`error`); one that
        ends the program takes the place of every error that follows from it."""

        def call(_user: int | None, _index: int, t: float, value: Any) -> int:
            try:
                value[0] = float(function(t))
            except BaseException as error:  # noqa: BLE001  an exception must not cross the C code; the caller raises it
                self.error = error
                return 1
            return 0

        native = InputFunction(call)
        self._kept.append(native)
        self._shared.gb_input_callback(self._sim, index, native, None)

    def start(self, options: Options, t0: float, y0: Array | None = None) -> Code:
        """Start at t0 from the model's start values, or from y0 (length n_total)."""
        if y0 is not None:
            y0 = self._state_vector(y0)
        return CODES[self._shared.gb_start(self._sim, options, t0, address(y0))]

    def advance(self, t: float) -> Code:
        """Go on to the communication point t."""
        return Code(self._shared.gb_advance(self._sim, t))

    @property
    def time(self) -> float:
        """The present communication point."""
        return float(self._shared.gb_time(self._sim))

    def state(self, *, stopped: bool = False) -> Array:
        """The state at the communication point, length n_total; stopped: of a run that cannot go on, too."""
        return self._filled("gb_state", self._program.n_total, stopped)

    def outputs(self) -> Array:
        """All outputs at the communication point."""
        return self._filled("gb_outputs", len(self._program.outputs))

    def energies(self) -> Array:
        """All energies at the communication point."""
        return self._filled("gb_energies", len(self._program.energies))

    def rounding_energy(self) -> float:
        """Energy [J] of which nothing can be told, where all motion so far is rounding of forces that balance; else 0."""
        return float(self._shared.gb_rounding_energy(self._sim))

    def run(self, samples: Array | None, t_end: float, record: Record, seconds: float = 0.05) -> Code:
        """Runs through the samples, or records every accepted step up to t_end; back about every `seconds` of CPU time.

        The array of samples must stay the same one from call to call of a run.
        """
        count = 0 if samples is None else len(samples)
        return CODES[self._shared.gb_run(self._sim, address(samples), count, t_end, record.raw, seconds)]

    def evaluate(self, rows: Array, pick: NDArray[np.intc], energies: bool = False) -> tuple[Code, Array, Array]:
        """Outputs pick[j] of recorded rows, shape (rows, picks), and energies, shape (rows, energies) or (rows, 0)."""
        rows = np.ascontiguousarray(rows, dtype=np.float64)
        pick = np.ascontiguousarray(pick, dtype=np.intc)
        out = np.empty((len(rows), len(pick)))
        energy = np.empty((len(rows), len(self._program.energies) if energies else 0))
        code = self._shared.gb_evaluate(
            self._sim, address(rows), len(rows), address(pick), len(pick), address(out), address(energy) if energies else None
        )  # fmt: skip
        return Code(code), out, energy

    def energies_of(self, row: Array) -> Array:
        """All energies of one recorded row, which is contiguous."""
        energy = np.empty(len(self._program.energies))
        self._shared.gb_evaluate(self._sim, address(row), 1, None, 0, None, address(energy))
        return energy

    def account(self) -> Account:
        """What limits the steps from here on, counted as they are made."""
        return Account(self._shared, self._sim, self._program.n)

    def watches(self, outputs: Sequence[int], limits: Sequence[float]) -> Watches:
        """Outputs to watch in a run that begins."""
        return Watches(self._shared, self._sim, outputs, limits)

    @property
    def handle(self) -> tuple[ctypes.CDLL, int | None]:
        """The shared object and the simulation in it, for calls that have a module of their own."""
        return self._shared, self._sim

    def rhs(self, t: float, y: Array) -> Array:
        """dy/dt at (t, y) with the present modes; length n_total."""
        dy = np.zeros(self._program.n_total)
        y = self._state_vector(y)
        _expect(self._shared.gb_rhs(self._sim, t, address(y), address(dy)), "gb_rhs")
        return dy

    def pattern(self) -> Pattern | None:
        """The pattern of the matrix of implicit methods; None where the model has none."""
        self._pattern = self._pattern or pattern_of(self._shared, self._sim)
        return self._pattern

    def _needed_pattern(self) -> Pattern:
        if pattern := self.pattern():
            return pattern
        raise RuntimeError(f"the model '{self._program.name}' has no Jacobian")

    @property
    def has_jacobian(self) -> bool:
        """Whether the model has what implicit methods need."""
        return bool(self._shared.gb_pattern_of(self._sim))

    def step_matrix_sizes(self) -> tuple[int, int, int]:
        """Numbers of kinematic states, of massless speeds, and of kinematic terms (zeros without a pattern)."""
        return sizes_of(self._shared, self._sim)

    def step_matrix(
        self, t: float, y: Array, g: float, modes: Array | None = None, *, inputs: Array | None = None,
        means: bool = False,
    ) -> StepMatrix:  # fmt: skip
        """The matrix of a step at (t, y), g = gamma h; modes, inputs and means as for `probe` (None: the present modes)."""
        modes, inputs = _doubles(modes), _doubles(inputs)
        point = PointStructure(t, int(means), address(modes), address(inputs), None)
        code, matrix = matrix_at(self._shared, self._sim, point, self._state_vector(y), g)
        _expect(code, "gb_step_matrix_at")
        return matrix

    def jacobian(
        self, t: float, y: Array, modes: Array | None = None, *, inputs: Array | None = None, means: bool = False,
        dense: bool = False,
    ) -> Any:  # fmt: skip
        """d(dy)/dy of the n states, a scipy.sparse CSC array, or a dense one; arguments as for `step_matrix`.

        Raises RuntimeError where the model has no pattern, ArithmeticError where a derivative has no bound or the speeds
        of massless groups are not determined.
        """
        if dense:
            modes, inputs = _doubles(modes), _doubles(inputs)
            point = PointStructure(t, means, address(modes), address(inputs), None)
            return self._dense_jacobian().at(point, self._state_vector(y))
        pattern, sizes = self._needed_pattern(), self.step_matrix_sizes()

        def matrix(g: float) -> StepMatrix:
            return self.step_matrix(t, y, g, modes, inputs=inputs, means=means)

        made, self._groups = state_jacobian(self, pattern, sizes[:2], matrix, self._groups)
        return made

    def _dense_jacobian(self) -> DenseJacobian:
        if self._dense is None:
            self._dense = DenseJacobian(self._shared, self._sim, self._needed_pattern(), self.step_matrix_sizes())
        return self._dense

    def inertia(self, t: float, y: Array, *, dense: bool = False) -> Any:
        """E of c/gb_model.h by the states that are not kinematic, a scipy.sparse CSC array or a dense one: inertias of the
        speeds, 1 for states of blocks. Raises RuntimeError as `jacobian`."""
        if dense:
            return self._dense_jacobian().inertia(PointStructure(t), self._state_vector(y))
        pattern = self._needed_pattern()
        last = len(pattern.order) - self.step_matrix_sizes()[1]
        return full_matrix(pattern, self.step_matrix(t, y, 0.0))[:last, :last]

    def right_side(self, m: StepMatrix, r: Array) -> Array:
        """E r_x + g dG/ds r_s of a vector over the n states; one number per unknown."""
        r, out = np.ascontiguousarray(r, dtype=np.float64), np.empty(len(m.diag))
        code = self._shared.gb_step_matrix_right_side(
            self._sim, address(m.kinematic_terms), m.g, address(r), address(out)
        )
        _expect(code, "gb_step_matrix_right_side")
        return out

    def kinematic_rates(self, m: StepMatrix, x: Array) -> Array:
        """B x: rates of the kinematic states from the unknowns."""
        x, out = np.ascontiguousarray(x, dtype=np.float64), np.empty(self.step_matrix_sizes()[0])
        code = self._shared.gb_kinematic_rates(self._sim, address(m.kinematic_terms), address(x), address(out))
        _expect(code, "gb_kinematic_rates")
        return out

    def modes(self) -> Array:
        """The present modes of all switches. Only after `start`."""
        return self._filled("gb_modes", len(self._program.switches))

    def constraints(self) -> ModelConstraints:
        """The switched constraints of the model: friction, unbounded locks, stops, lossy gears."""
        self._constraints = self._constraints or constraints_of(self._shared, self._sim)
        return self._constraints

    def constraints_at(
        self, t: float, y: Array, modes: Array | None, *, inputs: Array | None = None, means: bool = False
    ) -> ConstraintsAtPoint:
        """Slips, force bounds and constraint forces of all switched constraints at a point; arguments as for `probe`."""
        modes, inputs = _doubles(modes), _doubles(inputs)
        point = PointStructure(t, int(means), address(modes), address(inputs), None)
        code, made = constraints_at(self._shared, self._sim, point, self._state_vector(y))
        _expect(code, "gb_constraints_at")
        return made

    def probe(
        self, t: float, y: Array, modes: Array | None, wanted: str, *, inputs: Array | None = None, means: bool = False,
        rates: Array | None = None,
    ) -> Array:  # fmt: skip
        """One thing at a point, the run untouched: "rates" (n_total), "outputs", "energies", "modes" (those that fit) or
        "surfaces" (event functions by switch, 0 for those of time alone).

        modes: of all switches (None: the present ones); inputs: values of all inputs (None: their sources at t); means:
        excitations of time alone at their means; rates: n_total of them that outputs take as given. Only after `start`.
        Raises RuntimeError where an input fails.
        """
        program, number = self._program, _PROBED.index(wanted)
        n_switches = len(program.switches)
        lengths = (program.n_total, len(program.outputs), len(program.energies), n_switches, n_switches)
        result = np.zeros(lengths[number])
        y, modes, values, rates = self._state_vector(y), _doubles(modes), _doubles(inputs), _doubles(rates)
        point = PointStructure(t, means, address(modes), address(values), address(rates))
        targets: list[int | None] = [None] * len(_PROBED)
        targets[number] = address(result)
        _expect(self._shared.gb_probe(self._sim, ctypes.byref(point), address(y), *targets), "gb_probe")
        return result

    def save(self) -> bytes:
        """The whole changing state."""
        block = ctypes.create_string_buffer(self._shared.gb_snapshot_size(self._sim))
        self._shared.gb_save(self._sim, block)
        return block.raw

    def restore(self, block: bytes) -> Code:
        """Back to a saved state; ERR_STATE where the block has another length, belongs to another model or is damaged."""
        if len(block) != self._shared.gb_snapshot_size(self._sim):
            return Code.ERR_STATE
        return Code(self._shared.gb_restore(self._sim, block))

    @property
    def counters(self) -> Counters:
        """The counters at this moment."""
        counters = Counters()
        self._shared.gb_get_stats(self._sim, ctypes.byref(counters))
        return counters

    @property
    def report(self) -> Report:
        """Where and why the last call could not go on."""
        report = Report()
        self._shared.gb_get_report(self._sim, ctypes.byref(report))
        return report

    def _filled(self, name: str, length: int, stopped: bool = False) -> Array:
        values = np.zeros(length)
        code = getattr(self._shared, name)(self._sim, address(values))
        if code < 0 and not stopped:
            _expect(code, name)
        return values

    def _state_vector(self, y: Array) -> Array:
        y = np.ascontiguousarray(y, dtype=np.float64)
        if y.shape != (self._program.n_total,):
            raise ValueError(f"a state vector of length {self._program.n_total} is needed, not shape {y.shape}")
        return y


def _doubles(values: Array | None) -> Array | None:
    return None if values is None else np.ascontiguousarray(values, dtype=np.float64)


def _expect(code: int, name: str) -> None:
    if code < 0:
        raise RuntimeError(f"{name} answered {Code(code).name}")
