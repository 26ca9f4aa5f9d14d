"""Campbell diagrams: natural frequencies over speed, and where the orders of meshes and shafts cross them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple, final

import numpy as np

from gearblocks.analysis.modes import body_speeds, modes_at
from gearblocks.analysis.operating_point import OperatingPoint, operating_point
from gearblocks.codegen.program import ParameterInfo, Program
from gearblocks.drivetrain import Drivetrain
from gearblocks.errors import (
    ParameterError,
    SimulationError,
    UnknownNameError,
    arguments_told,
    by_name_only,
    did_you_mean,
)
from gearblocks.language.tidy import Tidy
from gearblocks.language.units import row_in_si
from gearblocks.pages import small_table
from gearblocks.plurals import singular
from gearblocks.running import build
from gearblocks.simulation.arguments import resolve
from gearblocks.simulation.plausibility import warn_of_parameters
from gearblocks.simulation.plotting import COLOURS, DASHES, finished, legend, new_figure, style
from gearblocks.solver.kinematics import kinematics
from gearblocks.solver.library import Model
from gearblocks.solver.point import Point
from gearblocks.solver.structures import Array

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class Crossing(NamedTuple):
    """An order meets a natural frequency: speed [rad/s], frequency [rad/s], number of the mode, name of the order."""

    speed: float
    frequency: float
    mode: int
    order: str


@final
@arguments_told
@dataclass(frozen=True, eq=False)
class Campbell(metaclass=Tidy):
    """Natural frequencies [rad/s], shape (speeds, modes), over speeds [rad/s]; orders: excitations per turn by name."""

    name: str
    speed: str
    speeds: Array
    frequencies: Array
    damping: Array
    orders: Mapping[str, float]
    crossings: tuple[Crossing, ...]

    def __repr__(self) -> str:
        counts = f"{len(self.speeds)} speeds, {self.frequencies.shape[1]} modes, {len(self.orders)} orders"
        return singular(f"<Campbell of '{self.name}' over {self.speed}: {counts}, {len(self.crossings)} crossings>")

    def _repr_html_(self) -> str:
        rows = [
            (f"{c.speed * 30 / np.pi:.6g}", f"{c.frequency / (2 * np.pi):.6g}", f"{c.mode}", c.order)
            for c in self.crossings
        ]
        title = singular(f"{self.name}: {self.frequencies.shape[1]} modes over {self.speed}, {len(rows)} crossings")
        orders = ", ".join(f"{name} ({order:.4g})" for name, order in self.orders.items())
        head = ("rpm", "Hz", "mode", "order")
        return small_table(title, rows, head=head, numbers=(0, 1, 2), notes=[f"orders: {orders}"] if orders else ())

    def __str__(self) -> str:
        head = singular(
            f"{self.name}: {self.frequencies.shape[1]} modes over {self.speed}, {len(self.crossings)} crossings"
        )
        rows = [
            f"  {c.speed * 30 / np.pi:10.6g} rpm  {c.frequency / (2 * np.pi):10.6g} Hz  mode {c.mode}  {c.order}"
            for c in self.crossings
        ]
        return "\n".join([head, *rows])

    def plot(self, path: Any = None) -> Figure:
        """Frequencies, order lines and crossings over the speed in rpm; saved to `path` where given."""

        return campbell_picture(self, path)


@by_name_only
def campbell(
    train: Drivetrain | Model, speed: str, speeds: Sequence[float | str] | Array, *,
    orders: Mapping[str, float] | Sequence[float] | None = None, reference: str | None = None, at: OperatingPoint = "static",
    count: int | None = None, parameters: Mapping[str, float | str] | None = None,
) -> Campbell:  # fmt: skip
    """Natural frequencies over a speed [rad/s], orders and their crossings.

    speed: a Parameter, or the speed of a body ("motor.w") with which all bodies turn in their ratios. orders: by name or
    as numbers; left out, they follow from the train: one per shaft speed and one per GearMesh (its teeth) or planetary set
    (the teeth that pass its carrier), relative to the body `reference` (default: the body of `speed`, else the first one; of
    a train that a Parameter drives, such as gb.Speed(w=n), to that speed). count: the lowest modes only.
    """
    model = build(train)
    values = row_in_si("speeds", speeds, "rad/s")
    if values.ndim != 1 or len(values) == 0 or (np.diff(values) <= 0).any():
        raise ParameterError(f"speeds = {speeds!r:.80} must be a row of numbers that increase")
    names = {p.path: i for i, p in enumerate(model.program.parameters) if p.tunable}
    body = _body_of(model, speed)
    if body is None and isinstance(speed, str) and speed not in names:
        speeds_of_bodies = [f"{name}.w" for name in body_speeds(model.program)[0]]
        if near := did_you_mean(speed, speeds_of_bodies):
            raise UnknownNameError(f"there is no Parameter and no speed of a body '{speed}'{near}")
    driven = None if body is not None else model.program.parameters[resolve(speed, names, "parameter")]
    warn_of_parameters(model, parameters)
    found, damping = [], []
    for value in values:
        with operating_point(
            model, at, None, {**(parameters or {}), **(_set_to(driven, float(value)) if driven else {})}
        ) as point:
            turning = point if body is None else _turning(point, body, float(value))
            swinging = modes_at(turning, count)
            found.append(swinging.frequencies[swinging.free :])
            damping.append(swinging.damping[swinging.free :])
            lines = _given(orders) if orders is not None else _orders(train, point, reference or body)
    if lines is None and driven is not None and reference is None:
        rolled = [_rolled(model, {**(parameters or {}), **_set_to(driven, float(v))}) / v for v in values[[0, -1]] if v]
        lines = _driven_orders(train, model.program, rolled)
    if lines is None:
        raise ParameterError(
            f"orders: no speed of '{speed}' turns the train as one piece in fixed ratios, so they are unknown; give "
            "orders={'name': per turn}"
        )
    width = min(map(len, found))
    table = np.array([row[:width] for row in found])
    crossings = _crossings(values, table, lines)
    return Campbell(
        model.program.name, speed, values, table, np.array([row[:width] for row in damping]), lines, crossings
    )


def _set_to(driven: ParameterInfo, speed: float) -> dict[str, float | str]:
    """The parameter at a speed [rad/s], whatever unit bare numbers of it are in."""
    return {driven.path: speed if not driven.given_in else f"{speed!r} {driven.unit}"}


def _body_of(model: Model, speed: str) -> str | None:
    bodies, _ = body_speeds(model.program)
    return speed[:-2] if speed.endswith(".w") and speed[:-2] in bodies else None


def _free_turn(point: Point, reference: str | None) -> tuple[Array, Array] | None:
    """Speeds of the states and of all outputs where the reference body turns at 1 rad/s; None if nothing turns freely."""
    kin = kinematics(point)
    bodies, numbers = body_speeds(point.program)
    chosen = bodies.index(reference) if reference is not None else 0
    y = point.y.copy()
    for column in kin.N.toarray().T:
        y[kin.speeds] = column
        turned = point.outputs(y)
        own = turned[numbers[chosen]]
        if own != 0:
            return column / own, turned / own
    return None


def _turning(point: Point, body: str, speed: float) -> Point:
    """The point with every body turning along with one."""
    turn = _free_turn(point, body)
    if turn is None:
        raise ParameterError(f"'{body}' cannot turn freely, so no speed of it can be set; name a Parameter")
    y = point.y.copy()
    y[kinematics(point).speeds] = turn[0] * speed
    return point.at(y=y).settled()


def _given(orders: Mapping[str, float] | Sequence[float]) -> dict[str, float]:
    if isinstance(orders, Mapping):
        return {str(k): float(v) for k, v in orders.items()}
    return {f"order {v:g}": float(v) for v in orders}


def _orders(train: Drivetrain | Model, point: Point, reference: str | None) -> dict[str, float] | None:
    """Excitations per turn of the reference, by name; None where nothing turns freely."""
    bodies, _ = body_speeds(point.program)
    if reference is not None and reference not in bodies:
        raise ParameterError(f"reference = {reference!r} is no body of the train; it has {', '.join(bodies[:12])}")
    turn = _free_turn(point, reference)
    return None if turn is None else _lines(train, point.program, turn[1])


def _rolled(model: Model, parameters: Mapping[str, float | str]) -> Array:
    """All outputs where what is driven turns along in its ratios, twisting nothing; NaN where there is no such motion."""
    try:
        with operating_point(model, "rolling", None, parameters) as point:
            return point.outputs(point.y)
    except (ParameterError, SimulationError):
        return np.full(len(model.program.outputs), np.nan)


def _driven_orders(train: Drivetrain | Model, program: Program, rolled: Sequence[Array]) -> dict[str, float] | None:
    """Excitations per turn of the speed that drives; rolled: outputs over that speed, which must be the same at each."""
    _, numbers = body_speeds(program)
    if not rolled or not all(np.allclose(x[numbers], rolled[0][numbers], rtol=1e-9, atol=1e-12) for x in rolled):
        return None
    return _lines(train, program, rolled[-1]) or None


def _lines(train: Drivetrain | Model, program: Program, outputs: Array) -> dict[str, float]:
    """Orders of shafts and teeth, by name, from the outputs per turn."""
    bodies, numbers = body_speeds(program)
    found: dict[float, list[str]] = {}
    for body, i in zip(bodies, numbers, strict=True):
        found.setdefault(round(abs(float(outputs[i])), 9), []).append(body)
    lines = {f"shaft of {_listed(names)}": order for order, names in found.items() if order > 0}
    return lines | _mesh_orders(train, program, outputs)


def _mesh_orders(train: Drivetrain | Model, program: Program, outputs: Array) -> dict[str, float]:
    """Tooth meshes per turn of every GearMesh of the train, those of planetary sets too: past their carrier."""
    from gearblocks.blocks import GearMesh

    if isinstance(train, Model):
        return {}
    index = {q.name: i for i, q in enumerate(program.outputs)}
    found: dict[float, list[str]] = {}
    for c in train.train().components:
        if isinstance(c.block, GearMesh):
            carrier = index.get(f"{c.path}.carrier.w")
            relative = outputs[index[f"{c.path}.pinion.w"]] - (outputs[carrier] if carrier is not None else 0.0)
            found.setdefault(round(abs(float(relative)) * c.block.teeth[0], 9), []).append(c.path)
    return {f"teeth of {_listed(_sets(paths))}": order for order, paths in found.items() if order > 0}


def _sets(paths: list[str]) -> list[str]:
    """Meshes of the planets of a set, which all have one order, by the name of the set."""
    places = [path.rpartition(".")[0] if path.endswith("]") else path for path in paths]
    return list(dict.fromkeys(places))


def _listed(names: list[str]) -> str:
    return ", ".join(names[:2]) + (f" and {len(names) - 2} more" if len(names) > 2 else "")


def _crossings(speeds: Array, table: Array, orders: Mapping[str, float]) -> tuple[Crossing, ...]:
    """Where order x speed meets a frequency, by straight lines between the speeds."""
    found = []
    for name, order in orders.items():
        for mode in range(table.shape[1]):
            gap = order * speeds - table[:, mode]
            for i in np.flatnonzero(np.signbit(gap[:-1]) != np.signbit(gap[1:])):
                share = gap[i] / (gap[i] - gap[i + 1])
                speed = speeds[i] + share * (speeds[i + 1] - speeds[i])
                found.append(Crossing(float(speed), float(order * speed), mode + 1, name))
    return tuple(sorted(found))


def campbell_picture(diagram: Campbell, path: Any) -> Figure:
    """Frequencies over the speed with the order lines and their crossings."""
    rpm, hertz = diagram.speeds * 30 / np.pi, diagram.frequencies / (2 * np.pi)
    with style():
        figure, (axis,) = new_figure(path, size=(8.4, 4.8))
        top = 1.15 * float(hertz.max(initial=0.0)) or 1.0
        for mode in range(hertz.shape[1]):
            axis.plot(
                rpm, hertz[:, mode], color="#333333", linewidth=1.2, label="natural frequencies" if mode == 0 else None
            )
        for number, (name, order) in enumerate(diagram.orders.items()):
            colour = COLOURS[number % 6]
            dashes = DASHES[1 + number // 6 % (len(DASHES) - 1)]
            axis.plot(rpm, order * rpm / 60, color=colour, linestyle=dashes, label=f"{name} ({order:.4g})")
            mine = [c for c in diagram.crossings if c.order == name]
            axis.plot(
                [c.speed * 30 / np.pi for c in mine], [c.frequency / (2 * np.pi) for c in mine], "o", color=colour,
                markersize=5, markeredgecolor="white",
            )  # fmt: skip
        axis.set_ylim(0.0, top)
        axis.set_xlim(float(rpm.min()), float(rpm.max()))
        axis.set_xlabel("speed in rpm")
        axis.set_ylabel("frequency in Hz")
        axis.set_title(f"Campbell diagram of {diagram.name}")
        legend(axis, loc="upper left", bbox_to_anchor=(1.0, 1.0))
        return finished(figure, path)
