"""A scene as an FMU: its train, started as the scene starts it, with its inputs at the values that it gives them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from gearblocks.codegen.program import Program
from gearblocks.errors import ParameterError, warn
from gearblocks.language.expression import finite_number
from gearblocks.language.signals import Table
from gearblocks.language.starts import is_rolling

if TYPE_CHECKING:
    from gearblocks.analysis.scenes.scene import Scene
    from gearblocks.drivetrain import Drivetrain


def started_as_in(
    scene: Scene, parameters: Mapping[str, float | str] | None, initial: Any, t_end: float | str | None
) -> tuple[Drivetrain, Mapping[str, Any], Any, float | str, dict[str, float]]:
    """Train, parameters, start, end [s] and constant inputs of a scene, with what is given instead. An equilibrium becomes
    the state that it is. Raises ParameterError for what is no scene."""
    from gearblocks.analysis.scenes.bench import bench_of
    from gearblocks.analysis.scenes.scene import Scene

    if not isinstance(scene, Scene):
        raise ParameterError(f"export takes a gb.Drivetrain, a gb.Model or a gb.Scene, not {scene!r:.80}")
    tuned = {**scene.parameters, **(parameters or {})}
    start = scene.initial if initial is None else initial
    if isinstance(start, str) and not is_rolling(start):
        start = bench_of(scene.changed(parameters=tuned, initial=start)).start
    held: dict[str, float] = {}
    for name, source in scene.inputs.items():
        if isinstance(source, Table) or callable(source) or np.ndim(source):
            warn(
                f"'{scene.name}': the input '{name}' follows time in the scene; an FMU gets it from outside",
            )
        else:
            held[name] = finite_number(name, source)
    return scene.drivetrain, tuned, start, scene.end if t_end is None else t_end, held


def with_inputs(program: Program, held: Mapping[str, float]) -> Program:
    """The program with its inputs at these values before anything is connected."""
    if not held:
        return program
    return replace(program, inputs=tuple(u._replace(start=held.get(u.name, u.start)) for u in program.inputs))
