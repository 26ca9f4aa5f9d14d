"""Modes of a train about an operating point: natural frequencies, damping, shapes and energies, contacts keeping their side.

    A x = s x        A: state matrix of the independent deviations; s = -zeta w +- i w sqrt(1 - zeta^2)

Free rotations are known from the structure (B N = 0 and no torque that answers), not from the size of an eigenvalue.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple, final

import numpy as np

from gearblocks.analysis.linearization import DENSE, Complex
from gearblocks.analysis.mode_pictures import shapes
from gearblocks.analysis.operating_point import OperatingPoint, operating_point
from gearblocks.analysis.reduction import reduction
from gearblocks.codegen.program import Program
from gearblocks.drivetrain import Drivetrain
from gearblocks.errors import GearblocksError, ParameterError, arguments_told, by_name_only
from gearblocks.language.tidy import Tidy, told
from gearblocks.pages import small_table
from gearblocks.plurals import among, singular
from gearblocks.running import build
from gearblocks.simulation.plausibility import warn_of_parameters
from gearblocks.solver.kinematics import Kinematics, kinematics
from gearblocks.solver.library import Model
from gearblocks.solver.point import Point, state_matrix, steps_of
from gearblocks.solver.sparse_maps import Indices
from gearblocks.solver.structures import Array

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from scipy.sparse import csc_array


_FEW = 20  # modes of a long train where none are asked for
_ROUNDING = 1e-10  # of a damping ratio
_RESISTS = 1e-8  # a smaller answer to a rotation, relative to its terms, is rounding: differences leave about 1e-10
_LEFT = 64 * np.finfo(float).eps  # of the terms, in a difference
_REAL = 1e-9  # a smaller imaginary part, relative to the eigenvalue, is rounding


class NoModeError(GearblocksError, IndexError):
    """A number that no mode has."""


class Mode(NamedTuple):
    """One mode: frequency [rad/s and Hz], damping, eigenvalue [1/s]; by body its shape and its share of the kinetic energy,
    by element its share of the strain energy."""

    number: int
    frequency: float
    hertz: float
    damping: float
    eigenvalue: complex
    shape: Mapping[str, complex]
    kinetic: Mapping[str, float]
    strain: Mapping[str, float]

    def __repr__(self) -> str:
        return f"<Mode {self.number}: {self.hertz:.6g} Hz, damping {100 * self.damping:.3g} %>"


@final
@arguments_told
@told
@dataclass(frozen=True, eq=False)
class Modes(metaclass=Tidy):
    """Modes in rising order of frequency, free rotations first.

    frequencies: undamped natural frequencies [rad/s], shape (k,), exactly 0 for free rotations; hertz: the same in Hz;
    damping: ratio of critical damping; eigenvalues: of the damped motion [1/s].
    shapes: motion of every body of `bodies`, shape (k, bodies), complex where damping shifts phases, largest entry 1.
    kinetic: share of the kinetic energy per body; strain: share of the strain energy per element of `elements` (mean
    over a cycle, rows sum to 1; 0 where the mode stores none). An element whose energy is driven by inputs or steps
    keeps no account of it and does not appear. decays: rates of motions that neither swing nor stay [1/s].
    free: number of free rotations, known from the structure; bound: the largest eigenvalue that rounding gave in their
    place [rad/s], the measure of what 0 means here. angles: the absolute angles [rad] that laws read, by name; tied:
    rotations that these laws answer, such as a stiffness driven by the angle: they are among the first modes or the decays.
    frozen: whether the slopes of these laws were left out.
    """

    name: str
    frequencies: Array
    damping: Array
    eigenvalues: Complex
    bodies: tuple[str, ...]
    shapes: Complex
    kinetic: Array
    elements: tuple[str, ...]
    strain: Array
    decays: Array
    free: int
    bound: float
    angles: Mapping[str, float] = field(default_factory=dict)
    tied: int = 0
    frozen: bool = False

    @property
    def hertz(self) -> Array:
        """Natural frequencies [Hz]."""
        return self.frequencies / (2 * np.pi)

    def __len__(self) -> int:
        return len(self.frequencies)

    def __getitem__(self, number: int) -> Mode:
        """One mode by its number in the table; from behind where that is < 0."""
        if isinstance(number, bool) or not isinstance(number, (int, np.integer)):
            fields = "frequencies, hertz, damping, shapes, kinetic, strain"
            raise ParameterError(f"modes[{number!r}]: modes are numbered, as in modes[0]; rows of all: {fields}")
        if not -len(self) <= number < len(self):
            raise NoModeError(f"modes[{number}]: {self!r} is numbered from 0 to {len(self) - 1}")
        i = int(number) % len(self)
        of_bodies, of_elements = (partial(zip, names, strict=True) for names in (self.bodies, self.elements))
        return Mode(
            i, float(self.frequencies[i]), float(self.hertz[i]), float(self.damping[i]), complex(self.eigenvalues[i]),
            dict(of_bodies(self.shapes[i].tolist())), dict(of_bodies(self.kinetic[i].tolist())),
            dict(of_elements(self.strain[i].tolist())),
        )  # fmt: skip

    def __repr__(self) -> str:
        span = f", {self.hertz.min():.6g} .. {self.hertz.max():.6g} Hz" if len(self) else ""
        return singular(f"<Modes of '{self.name}': {len(self)} modes, {among(self.free, 'free rotation')}{span}>")

    def _rows(self) -> list[tuple[str, ...]]:
        """Heading and a row for each mode."""
        rows: list[tuple[str, ...]] = [("", "Hz", "rad/s", "damping", "moves most", "strained most")]
        for i in range(len(self)):
            moves = _most(self.bodies, np.abs(self.shapes[i]), lambda x: f"{x:.2f}")
            strained = _most(self.elements, 100 * self.strain[i], lambda x: f"{x:.0f} %" if x >= 1 else f"{x:.1g} %")
            damping = self.damping[i] if abs(self.damping[i]) > _ROUNDING else 0.0
            numbers = (f"{self.hertz[i]:.6g}", f"{self.frequencies[i]:.6g}", f"{100 * damping:.3g} %")
            rows.append((str(i), *numbers, moves, strained))
        return rows

    def _words(self) -> tuple[str, list[str]]:
        """What stands above and below the rows."""
        decays = f"decays without swinging: {', '.join(f'{x:.4g}' for x in self.decays[:8])} 1/s"
        notes = [decays] * (len(self.decays) > 0)
        if self.angles:
            at = ", ".join(f"{name} = {value:.6g} rad" for name, value in list(self.angles.items())[:4])
            held = "1 rotation is" if self.tied == 1 else f"{self.tied} rotations are"
            slow = (
                f"; {held} not free, because the laws change as it goes on: slow modes or decays" if self.tied else ""
            )
            slow += " (frozen_angles=True: laws that stay)" if self.tied and not self.frozen else ""
            notes.append(f"laws over the angle, as of a mesh cycle, are those at {at}{slow}")
        return singular(f"{self.name}: {len(self)} modes, {among(self.free, 'free rotation')}"), notes

    def _repr_html_(self) -> str:
        (head, *rows), (title, notes) = self._rows(), self._words()
        return small_table(title, rows, head=head, numbers=(0, 1, 2, 3), notes=notes)

    def __str__(self) -> str:
        rows, (head, tail) = self._rows(), self._words()
        widths = [max(len(row[c]) for row in rows) for c in range(6)]
        lines = [
            "  ".join(row[c].rjust(widths[c]) if c < 4 else row[c].ljust(widths[c]) for c in range(6)) for row in rows
        ]
        return "\n".join([head, *(line.rstrip() for line in lines), *tail])

    def plot(self, path: Any = None, *, most: int = 6) -> Figure:
        """Shapes and strain energies of the first modes that swing; saved to `path` where given."""
        return shapes(self, path, most)


def _most(names: tuple[str, ...], values: Array, words: Callable[[float], str]) -> str:
    """The two names with the largest values, the second only if it is a fifth of the first."""
    if len(values) == 0 or values.max() == 0:
        return ""
    order = np.argsort(-values, kind="stable")[:2]
    return ", ".join(f"{names[i]} {words(float(values[i]))}" for i in order if values[i] > 0.2 * values[order[0]])


@by_name_only
def modes(
    train: Drivetrain | Model, at: OperatingPoint = "static", *, count: int | None = None, t: float | None = None,
    parameters: Mapping[str, float | str] | None = None, frozen_angles: bool = False,
) -> Modes:  # fmt: skip
    """The modes of a train about a point, contacts keeping their side.

    at: "static" (the equilibrium with every excitation at its mean, contact side from the load), "static_at_start" (under
    everything as it is at t), None (the start values), a dict of start values, an earlier run (its end), "rolling".
    count: only so many of the lowest beside the free rotations (default: all; 20 beyond 1000 states, where a sparse solver
    finds them). Laws over absolute angles, such as a stiffness driven by the angle, are taken with their slope at the present
    angle, which the table names; a rotation that changes them is not free: it swings slowly about a trough of the mesh
    cycle, or creeps off a crest. Frequencies move with that angle: at={"motor.phi": ...} asks for another one.
    frozen_angles: without that slope, the stiffness of a mesh cycle being what it is at the present angle: the train turns
    freely, as one with constant stiffness does. A torque over an absolute angle, such as gravity's on a pendulum, restores
    nothing then; a transmission error over the angle still answers turning through the damping of its mesh.
    """
    model = build(train)
    warn_of_parameters(model, parameters)
    with operating_point(model, at, t, parameters) as point:
        return modes_at(point, count, frozen_angles=frozen_angles)


def modes_at(point: Point, count: int | None = None, *, frozen_angles: bool = False) -> Modes:
    """The modes about a point; frozen_angles: without the slopes of laws over absolute angles."""
    if count is not None and (isinstance(count, bool) or not isinstance(count, (int, np.integer)) or count < 1):
        raise ParameterError(f"count = {count!r} must be a whole number >= 1")
    kin = kinematics(point)
    A = state_matrix(point)
    if frozen_angles and _angle_is_state(point, kin):
        A = _without_columns(A, kin.angles)
    A = _without_counts(A, kin)
    turning = _free_rotations(point, kin, A)
    small = reduction(point, A.shape[0])
    values, vectors = _eigen(A if small is None else small.matrix(A), count, 2 * turning.shape[1])
    vectors = vectors if small is None else small.R @ vectors
    values, vectors, bound = _without_free(values, vectors, turning.shape[1], _angle_is_state(point, kin))
    swinging = values.imag > _REAL * np.abs(values)
    decaying = ~swinging & (values.imag >= 0) & (np.abs(values) > _REAL * np.abs(values).max(initial=0.0))
    decays = np.sort(-values[decaying & (np.abs(values.imag) <= _REAL * np.abs(values))].real)
    order = np.argsort(np.abs(values[swinging]), kind="stable")[:count]  # beside the free rotations
    free = np.zeros((point.program.n, turning.shape[1]))
    free[kin.speeds] = turning
    values = np.concatenate([np.zeros(free.shape[1]), values[swinging][order]])
    vectors = np.concatenate([free, vectors[:, swinging][:, order]], axis=1)
    sizes = np.abs(values)
    damping = np.divide(-values.real, sizes, out=np.zeros(len(values)), where=sizes > 0)
    bodies, shapes = _shapes(point, kin, vectors)
    kinetic, elements, strain = _energies(point, kin, vectors, bodies)
    read = kin.angles.tolist() if _angle_is_state(point, kin) else []
    angles = {point.program.states[i].name: float(point.y[i]) for i in read}
    return Modes(
        point.program.name, sizes, damping, values, bodies, shapes, kinetic, elements, strain, decays, free.shape[1],
        bound, angles, kin.N.shape[1] - free.shape[1] if angles else 0, frozen_angles,
    )  # fmt: skip


# -- eigenvalues ------------------------------------------------------------------------------------------------------


def _angle_is_state(point: Point, kin: Kinematics) -> bool:
    return bool(len(kin.angles)) and bool(kin.angles.max() < point.program.n)


def _without_columns(A: csc_array, columns: Indices) -> csc_array:
    """The matrix of a system that does not see these states."""
    from scipy.sparse import csc_array, diags_array

    keep = np.ones(A.shape[1])
    keep[columns] = 0.0
    return csc_array(A @ diags_array(keep))


def _without_counts(A: csc_array, kin: Kinematics) -> csc_array:
    """The matrix without the rates of states of blocks that move nothing, such as the angle of a slip."""
    from scipy.sparse import csc_array, diags_array

    idle = kin.states[np.asarray(abs(A[:, kin.states]).sum(axis=0)).ravel() == 0]
    if len(idle) == 0:
        return A
    keep = np.ones(A.shape[0])
    keep[idle] = 0.0
    return csc_array(diags_array(keep) @ A)


def _free_rotations(point: Point, kin: Kinematics, A: csc_array) -> Array:
    """Rotations of the whole train that no torque answers, as speeds, shape (speeds, count)."""
    N: Array = kin.N.toarray()
    if N.shape[1] == 0:
        return N
    v = kin.speeds
    y, steps = np.abs(point.y[: A.shape[0]]), steps_of(point.program, point.y)[v]
    # by rows: what columns have in common must stay; a difference over a step leaves the rounding of all terms of its row
    rounding = _LEFT / _RESISTS * (abs(A) @ y) / steps.min()
    answer, size = A[:, v] @ N, (abs(A[:, v]) @ np.abs(N)).max(axis=1) + rounding
    answer[kin.coordinates] = kin.B @ N  # known without differences
    size[kin.coordinates] = (abs(kin.B) @ np.abs(N)).max(initial=0.0)
    if _angle_is_state(point, kin):
        answer[kin.angles] = 0.0
        turned = A[:, kin.angles].toarray()
        answer = np.vstack([answer, turned])
        size = np.concatenate([size, np.full(len(turned), abs(A).max() if A.nnz else 0.0)])
    size = size[:, None]
    scaled = np.divide(answer, size, out=np.zeros_like(answer), where=size > 0)
    _, sizes, rows = np.linalg.svd(scaled, full_matrices=True)
    full = np.concatenate([sizes, np.zeros(rows.shape[0] - len(sizes))])
    kept = rows[full <= _RESISTS].T
    if kept.shape[1] == N.shape[1]:
        return N
    return np.asarray(N @ kept)


def _eigen(A: csc_array, count: int | None, extra: int) -> tuple[Complex, Complex]:
    """Eigenvalues and vectors; of a long train the lowest ones, by a sparse solver."""
    n = A.shape[0]
    if n == 0:
        return np.empty(0, dtype=complex), np.empty((0, 0), dtype=complex)
    if n <= DENSE:
        values, vectors = np.linalg.eig(A.toarray())
        return values.astype(complex), vectors.astype(complex)
    from scipy.sparse.linalg import eigs

    wanted = min(2 * (count or _FEW) + extra, n - 2)
    shift = 1e-6 * np.sqrt(float(abs(A).max()))
    values, vectors = eigs(A, k=wanted, sigma=shift, ncv=min(n, 2 * wanted + 40), v0=np.ones(n))
    return values, vectors


def _without_free(values: Complex, vectors: Complex, free: int, twice: bool) -> tuple[Complex, Complex, float]:
    """Without the eigenvalues that stand for free rotations: as many of the smallest as there are."""
    gone = free * (2 if twice else 1)
    order = np.argsort(np.abs(values), kind="stable")
    bound = float(np.abs(values[order[:gone]]).max(initial=0.0))
    return values[order[gone:]], vectors[:, order[gone:]], bound


# -- shapes and energies ----------------------------------------------------------------------------------------------


def body_speeds(program: Program) -> tuple[tuple[str, ...], list[int]]:
    """Names of all bodies and the number of the output that is their speed."""
    outputs = {q.name: i for i, q in enumerate(program.outputs)}
    found: dict[str, int] = {}
    for start in program.starts:
        body, _, what = start.name.rpartition(".")
        if what in ("w", "v") and body not in found:
            own = outputs.get(start.name)
            if own is None:
                own = next(
                    (i for name, i in outputs.items() if name.startswith(body + ".") and name.endswith("." + what)),
                    None,
                )
            if own is not None:
                found[body] = own
    return tuple(found), list(found.values())


def _shapes(point: Point, kin: Kinematics, vectors: Complex) -> tuple[tuple[str, ...], Complex]:
    """Speeds of the bodies along each vector, the largest made 1; vectors are turned and scaled alike."""
    bodies, numbers = body_speeds(point.program)
    shapes = np.empty((vectors.shape[1], len(bodies)), dtype=complex)
    still = point.y.copy()
    still[kin.speeds] = 0.0
    for i in range(vectors.shape[1]):
        for part, unit in ((vectors[:, i].real, 1.0), (vectors[:, i].imag, 1j)):
            y = still.copy()
            y[kin.speeds] = part[kin.speeds]
            shapes[i] = (0 if unit == 1.0 else shapes[i]) + unit * point.outputs(y)[numbers]
        if len(bodies):
            largest = shapes[i, int(np.argmax(np.abs(shapes[i]).round(12)))]
            shapes[i] /= largest if largest != 0 else 1.0
    return bodies, shapes


def _energies(
    point: Point, kin: Kinematics, vectors: Complex, bodies: tuple[str, ...]
) -> tuple[Array, tuple[str, ...], Array]:
    """Shares of kinetic and strain energy: second differences of the energies along the shape, both parts of it."""
    program, y0 = point.program, point.y
    elements = tuple(dict.fromkeys(e.component for e in program.energies if e.part == "stored"))
    parts = {"kinetic": {n: i for i, n in enumerate(bodies)}, "stored": {n: i for i, n in enumerate(elements)}}
    shares = {part: np.zeros((vectors.shape[1], len(names))) for part, names in parts.items()}
    base = point.energies()
    for i in range(vectors.shape[1]):
        for shape in (vectors[:, i].real, vectors[:, i].imag):
            step = _along(program, kin, y0, shape)
            change = point.energies(y0 + step) - 2 * base + point.energies(y0 - step)
            ratio = float(np.abs(shape).max(initial=0.0) / (np.abs(step).max(initial=0.0) or 1.0))
            for e in program.energies:
                if e.component in parts[e.part]:
                    shares[e.part][i, parts[e.part][e.component]] += change[e.offset] * ratio**2
    for table in shares.values():
        total = table.sum(axis=1, keepdims=True)
        np.divide(table, total, out=table, where=total > 1e-9 * np.abs(table).max(axis=1, keepdims=True, initial=0.0))
        table[(total <= 0).ravel()] = 0.0
    return shares["kinetic"], elements, shares["stored"]


def _along(program: Program, kin: Kinematics, y0: Array, shape: Array) -> Array:
    """The shape as a step in the state vector, its deflections as large as those at the point."""
    step = np.zeros(program.n_total)
    step[: program.n] = shape
    largest = float(np.abs(shape[kin.coordinates]).max(initial=0.0))
    at_point = float(np.abs(y0[kin.coordinates]).max(initial=0.0))
    return step * ((at_point or 1e-3) / largest if largest > 0 else 1.0)
