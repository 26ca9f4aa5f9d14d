"""Neighbours of a scene: the same question at load and speed 10 % lower and higher.

Load: the torques and forces of all sources, of engines (their map) and of loads over speed and, where these are Parameters,
those. Speed: Parameters, prescribed and governed speeds and start speeds in rad/s or m/s. A signal that is written in numbers
alone is multiplied as a whole, an Input as it is given: number, series or function of time. Knows nothing of verdicts.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from gearblocks.analysis.scenes.scene import Scene
from gearblocks.blocks.machines import EddyCurrentBrake, Engine, Governor
from gearblocks.blocks.sources import Speed, SpeedLoad, Torque
from gearblocks.blocks.translational import Force
from gearblocks.drivetrain import Drivetrain
from gearblocks.language.block import start_fields
from gearblocks.language.expression import Expr
from gearblocks.language.fields import SPEED
from gearblocks.language.signals import Input, Parameter, Table
from gearblocks.language.starts import Rolling
from gearblocks.language.tables import Table2
from gearblocks.language.units import check_unit
from gearblocks.simulation.input_series import with_tables
from gearblocks.train.values import leaves_of

_TEXT = re.compile(r"\s*([-+0-9.]+(?:[eE][-+]?[0-9]+)?)\s*(.*)")
SHARES = (0.9, 1.1)
_LOADS, _SPEEDS = ("N m", "N"), ("rad/s", "m/s")
_SIGNALS: dict[type, tuple[str, tuple[str, ...]]] = {
    Torque: ("tau", _LOADS), Force: ("f", _LOADS), SpeedLoad: ("coeffs", _LOADS), Engine: ("torque_map", _LOADS),
    EddyCurrentBrake: ("tau_nominal", _LOADS), Speed: ("w", _SPEEDS), Governor: ("target", _SPEEDS),
}  # fmt: skip
"""What makes a block a source of load or speed: the field, and which of both it is."""


def neighbours(scene: Scene) -> Iterator[tuple[str, Scene]]:
    """Scenes at other loads and speeds, by what is said of them ("load -10 %"), as far as the train has any."""
    for what, units in (("load", _LOADS), ("speed", _SPEEDS)):
        for share in SHARES:
            found = _scaled(scene, units, share)
            if found is not None:
                yield f"{what} {100 * (share - 1):+.0f} %", found


def _scaled(scene: Scene, units: tuple[str, ...], share: float) -> Scene | None:
    """The scene with everything that drives it in these units times `share`; None where nothing does."""
    train, speeds = scene.drivetrain, units is _SPEEDS
    named = _named(train, units, everywhere=speeds)
    driving = {path: _times(share, value) for path, value in _signals(train, units, named)}
    starts = {path: share * value for path, value in _start_speeds(train, named)} if speeds else {}
    given = with_tables(scene.inputs)
    inputs = {name: _times(share, value) for name, value in _inputs(train, given, units, everywhere=speeds)}
    if not (driving or named or inputs or starts):
        return None
    parameters = {k: _times(share, v) if _is_one_of(k, [*driving, *starts]) else v for k, v in scene.parameters.items()}
    parameters |= {name: _times(share, scene.parameters.get(name, value)) for name, value in named.items()}
    initial = scene.initial
    if speeds and isinstance(initial, Mapping):
        initial = _faster(share, initial)
    elif speeds and isinstance(initial, Rolling):
        initial = Rolling(_faster(share, initial.values))
    changed = driving | starts
    return scene.changed(
        drivetrain=train.set(changed) if changed else train, parameters=parameters, inputs={**scene.inputs, **inputs},
        initial=initial,
    )  # fmt: skip


def _faster(share: float, values: Mapping[str, Any]) -> dict[str, Any]:
    """Start values with speeds times `share`."""
    return {k: _times(share, v) if k.endswith((".w", ".v")) else v for k, v in values.items()}


def _times(share: float, given: Any) -> Any:
    """A value as `gb.simulate` takes it, times `share`: a number, text with a unit, a table over time or a function of it."""
    if isinstance(given, str):
        number, unit = _TEXT.fullmatch(given).groups()  # type: ignore[union-attr]  # it was read before
        return f"{share * float(number)!r} {unit}"
    if isinstance(given, Table):
        return replace(given, y=share * np.asarray(given.y))
    if isinstance(given, Table2):
        return replace(given, z=share * np.asarray(given.z))
    if callable(given):
        return lambda t: share * given(t)
    return share * given


def _is_one_of(name: str, paths: Sequence[str]) -> bool:
    """Whether a name, as it may be shortened, is that of one of the paths."""
    return any(path == name or path.endswith(f".{name}") for path in paths)


def _measures(unit: str, units: tuple[str, ...]) -> bool:
    return unit in units or any(check_unit("a unit", unit).measures(check_unit("a unit", one)) for one in units if unit)


def _named(train: Drivetrain, units: tuple[str, ...], everywhere: bool) -> dict[str, float]:
    """Parameters in these units that sources read, or any block, and their values in the unit that they are given in."""
    found: dict[str, float] = {}
    for c in train.train().components:
        if everywhere or type(c.block) in _SIGNALS:
            for leaf in leaves_of(c.block):
                if isinstance(leaf, Parameter) and leaf.unit and _measures(leaf.unit, units):
                    found[leaf.name] = leaf.value
    return found


def _signals(train: Drivetrain, units: tuple[str, ...], named: Mapping[str, float]) -> Iterator[tuple[str, Any]]:
    """Signals of sources in these units that neither a Parameter nor an Input of them drives, by path."""
    for c in train.train().components:
        field, kind = _SIGNALS.get(type(c.block), ("", ()))
        if kind != units:
            continue
        given = c.block.__dict__[field]
        parts = {f"[{i}]": one for i, one in enumerate(given)} if isinstance(given, tuple) else {"": given}
        for part, value in parts.items():
            leaves = _leaves(value)
            if not {leaf.name for leaf in leaves} & set(named) and not any(isinstance(leaf, Input) for leaf in leaves):
                yield f"{c.path}.{field}{part}", value


def _leaves(value: Any) -> list[Parameter | Input]:
    """Parameters and Inputs in a value."""
    if isinstance(value, Expr):
        return [leaf.args[0] for leaf in value.leaves() if leaf.op in ("parameter", "input")]
    return [value] if isinstance(value, (Parameter, Input)) else []


def _inputs(
    train: Drivetrain, given: Mapping[str, Any], units: tuple[str, ...], everywhere: bool
) -> Iterator[tuple[str, Any]]:
    """Inputs in these units that sources read, or any block, and what they are given."""
    for c in train.train().components:
        if everywhere or type(c.block) in _SIGNALS:
            for leaf in leaves_of(c.block):
                if isinstance(leaf, Input) and leaf.unit and _measures(leaf.unit, units):
                    yield leaf.name, given.get(leaf.name, leaf.start)


def _start_speeds(train: Drivetrain, named: Mapping[str, float]) -> Iterator[tuple[str, Any]]:
    """Start speeds that no Parameter of them gives, by path of their field."""
    for c in train.train().components:
        field = start_fields(type(c.block)).get(SPEED)
        value = None if field is None else c.block.__dict__[field]
        if isinstance(value, Expr):
            follows = any(leaf.op == "parameter" and leaf.args[0].name in named for leaf in value.leaves())
        else:
            follows = not isinstance(value, (int, float)) or value == 0.0
        if not follows:
            yield f"{c.path}.{field}", value
