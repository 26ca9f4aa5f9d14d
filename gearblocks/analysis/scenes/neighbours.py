"""Neighbours of a scene: the same question at load and speed 10 % lower and higher.

Load: the torques and forces of all sources and, where these are Parameters, those. Speed: Parameters, prescribed speeds and
start speeds in rad/s or m/s. A signal that is written in numbers alone is multiplied as a whole. Knows nothing of verdicts.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from gearblocks.analysis.scenes.scene import Scene
from gearblocks.blocks.sources import Speed, Torque
from gearblocks.blocks.translational import Force
from gearblocks.drivetrain import Drivetrain
from gearblocks.language.block import start_fields
from gearblocks.language.expression import Expr
from gearblocks.language.fields import SPEED
from gearblocks.language.signals import Input, Parameter
from gearblocks.language.units import check_unit
from gearblocks.train.values import leaves_of

SHARES = (0.9, 1.1)
_LOADS, _SPEEDS = ("N m", "N"), ("rad/s", "m/s")
_SIGNALS: dict[type, str] = {Torque: "tau", Force: "f", Speed: "w"}


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
    driving = {path: share * value for path, value in _signals(train, units, named)}
    starts = {path: share * value for path, value in _start_speeds(train, named)} if speeds else {}
    inputs = _inputs(train, scene.inputs, units, share)
    if not (driving or named or inputs):
        return None
    parameters = dict(scene.parameters)
    for name, value in named.items():
        given = parameters.get(name, value)
        parameters[name] = share * (given if isinstance(given, (int, float)) else value)
    initial = scene.initial
    if speeds and isinstance(initial, Mapping):
        initial = {
            k: share * v if k.endswith((".w", ".v")) and isinstance(v, (int, float)) else v for k, v in initial.items()
        }
    changed = driving | starts
    return scene.changed(
        drivetrain=train.set(changed) if changed else train, parameters=parameters, inputs={**scene.inputs, **inputs},
        initial=initial,
    )  # fmt: skip


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
        field = _SIGNALS.get(type(c.block))
        if field is None or type(c.block).fields[field].unit not in units:
            continue
        value = c.block.__dict__[field]
        driven = {leaf.name for leaf in leaves_of(c.block)}
        if not driven & set(named) and not any(isinstance(leaf, Input) for leaf in leaves_of(c.block)):
            yield f"{c.path}.{field}", value


def _inputs(train: Drivetrain, given: Mapping[str, Any], units: tuple[str, ...], share: float) -> dict[str, Any]:
    """Inputs in these units that are numbers, or that keep their start value."""
    found: dict[str, Any] = {}
    for c in train.train().components:
        for leaf in leaves_of(c.block):
            if isinstance(leaf, Input) and leaf.unit and _measures(leaf.unit, units):
                value = given.get(leaf.name, leaf.start)
                if isinstance(value, (int, float)):
                    found[leaf.name] = share * value
    return found


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
