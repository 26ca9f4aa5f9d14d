"""export(): a train becomes one file that a simulation tool loads without anything beside it."""

from __future__ import annotations

import importlib.metadata
import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fmu_export import manifest
from fmu_export.archive import write_archive
from fmu_export.binary import build_binary, checked_platforms, source_files
from fmu_export.bounds import opened_bounds
from fmu_export.fmi2.description import Header, describe
from fmu_export.from_scene import started_as_in, with_inputs
from fmu_export.manifest import Manifest
from fmu_export.options import Experiment, SolverOptions, solver_options
from fmu_export.start import say_when, started
from fmu_export.tables import TOKEN_DIGITS, render_table, token_of
from fmu_export.templates import render
from fmu_export.variables import Variable, variables_of
from gearblocks.codegen.program import Program
from gearblocks.drawing.drawing import Drawing, shown_drawing
from gearblocks.errors import ParameterError, by_name_only, warn
from gearblocks.files import as_path, check_place
from gearblocks.language.units import seconds
from gearblocks.model.following_starts import numbers_of_their_own
from gearblocks.pages import legible_width
from gearblocks.simulation.arguments import duration
from gearblocks.simulation.plausibility import warn_of_parameters
from gearblocks.solver.library import Model

if TYPE_CHECKING:
    from gearblocks.analysis.scenes.scene import Scene
    from gearblocks.drivetrain import Drivetrain

ICON = "model.png"
FMI_VERSIONS = ("2.0",)
_PLANNED = ("3.0",)


@by_name_only
def export(
    train: Drivetrain | Model | Scene, path: str | os.PathLike[str], *, fmi: str = "2.0",
    platforms: Sequence[str] = ("native",), outputs: str | Sequence[str] = "*", method: str = "auto", rtol: float = 1e-6,
    step: float | str | None = None, max_step: float | str | None = None, locate: bool = True,
    parameters: Mapping[str, float | str] | None = None, initial: Any = None, t_end: float | str | None = None,
    communication_step: float | str | None = None, patience: float | str | None = 0.5,
) -> Path:  # fmt: skip
    """Write `train` (a train, a Model, or the train of a Scene as the scene starts it) as an FMU for co-simulation and return
    its path.

    outputs: pattern or patterns of the outputs to show. method, rtol, step, max_step, locate: as in simulate().
    parameters: start values by path, instead of the train's or the run's. initial: as in simulate(): start values by name,
    "rolling", "static" (the inputs at their start values), or an earlier run or point of an orbit, from whose end the FMU
    starts with the parameters of that run (its inputs come from outside, its time is the start time that the importer
    gives); or a state vector. With an equilibrium, a run or a vector the start values of the states take the place of
    start parameters.
    t_end, communication_step: default experiment [s] (t_end: that of the scene, else 1 s). patience: processor time [s]
    after which a step that is asked of the FMU ends on its way with fmi2Discard, to be asked for again or gone on from;
    0: after a few internal steps; None: however long it takes. Times may be text with a unit, such as "20 ms".
    All variables of an FMU are in SI and radians, as its description says: an input declared as gb.Input("target", unit="rpm")
    is one in rad/s there, with rpm as the unit that is shown (displayUnit), while simulate and check take bare numbers in rpm.
    Raises ParameterError or UnknownNameError for what cannot be exported; an existing file is replaced whole or kept.
    """
    from gearblocks.drivetrain import Drivetrain
    from gearblocks.running import build

    held: Mapping[str, float] = {}
    fmi = _version(fmi)
    target, chosen = _target(path), checked_platforms(platforms)
    if not isinstance(train, (Drivetrain, Model)):
        train, parameters, initial, t_end, held = started_as_in(train, parameters, initial, t_end)
    model = build(train)
    program = with_inputs(model.program, held)
    values, start = started(model, program, parameters or {}, initial)
    warn_of_parameters(model, parameters)
    _say_what_does_not_follow(model)
    say_when(model, values, start, initial)
    solver = solver_options(method, rtol, step, max_step, locate)
    patience = None if patience is None else seconds("patience", patience)
    if patience is not None and not patience >= 0:
        raise ParameterError(f"patience = {patience!r} s must be >= 0, or None")
    program = replace(program, parameters=opened_bounds(model, values, start, solver))
    variables = variables_of(program, values, outputs, solver, start)
    experiment = Experiment(
        1.0 if t_end is None else seconds("t_end", t_end),
        solver.rtol,
        duration("communication_step", communication_step),
    )
    drawing = None if model.tree is None else shown_drawing(model.tree)
    made = Manifest(program, values, solver, start, _shown(variables))
    content = Content(fmi, made, variables, experiment, patience, drawing)
    files = content.files(token_of(content.files("0" * TOKEN_DIGITS)))
    if chosen:
        sources = {name.removeprefix("sources/"): data for name, data in files.items() if name.startswith("sources/")}
        files.update(build_binary(sources, model_identifier(program.name)))
    write_archive(target, files)
    return target


def _target(path: str | os.PathLike[str]) -> Path:
    """Where the file goes. Raises ParameterError for a name that is none of an FMU."""
    target = as_path(path)
    if target.suffix.lower() != ".fmu":
        raise ParameterError(f"'{target}': the name of an FMU ends in .fmu, such as {target.with_suffix('.fmu').name}")
    check_place("the FMU", target)
    return target


def _say_what_does_not_follow(model: Model) -> None:
    """A warning where start values follow from Parameters."""
    if fixed := numbers_of_their_own(model):
        given = ", ".join(sorted(model.start_parameters))
        warn(
            f"'{model.program.name}': {', '.join(fixed)} follow from {given} here, but stay in an FMU as they are: set them "
            f"there together",
        )


@dataclass(frozen=True, slots=True)
class Content:
    """What an FMU is made of, but for the binary."""

    fmi: str
    manifest: Manifest
    variables: tuple[Variable, ...]
    experiment: Experiment
    patience: float | None
    drawing: Drawing | None

    def files(self, token: str) -> dict[str, bytes]:
        """Every file but the binary, by its name in the archive, with `token` wherever the token stands."""
        made, program = self.manifest, self.manifest.program
        table = render_table(program, self.variables, made.solver, self.patience, token)
        sources = source_files(self.fmi, program.source, table)
        words = f"Drivetrain '{program.name}'"
        names = (program.name, model_identifier(program.name))
        header = Header(*names, token, words, _tool(), list(sources), self.experiment)
        return {
            **{f"sources/{name}": data for name, data in sources.items()},
            "modelDescription.xml": describe(header, self.variables),
            "documentation/index.html": _documentation(program, self.variables, made.solver, self.drawing),
            manifest.NAME: manifest.to_json(made, token),
            **({ICON: self.drawing.icon()} if self.drawing is not None else {}),
        }


def _shown(variables: Sequence[Variable]) -> tuple[tuple[str, int], ...]:
    return tuple((v.name, v.index) for v in variables if v.kind == "output")


def model_identifier(name: str) -> str:
    """`name` as a C identifier, which FMI asks of file and model identifiers."""
    text = re.sub(r"\W+", "_", name, flags=re.ASCII).strip("_") or "drivetrain"
    return text if not text[0].isdigit() else f"m{text}"


def _version(fmi: Any) -> str:
    """A version that can be written; 2.0 as a number is understood. Raises ParameterError."""
    if str(fmi) in FMI_VERSIONS:
        return str(fmi)
    possible = " or ".join(f"'{version}'" for version in FMI_VERSIONS)
    if str(fmi) in _PLANNED:
        raise ParameterError(f"FMI {fmi} is not available in this version; possible: fmi={possible}")
    raise ParameterError(f"fmi = {fmi!r} is unknown; possible: fmi={possible}")


def _tool() -> str:
    try:
        return f"gearblocks {importlib.metadata.version('gearblocks')}"
    except importlib.metadata.PackageNotFoundError:
        return "gearblocks"


def _documentation(
    program: Program, variables: Sequence[Variable], solver: SolverOptions, drawing: Drawing | None
) -> bytes:
    """A short page: the scheme of the train, the settings and every variable with its unit and start value."""
    control = f"fixed steps of {solver.step!r} s" if solver.step is not None else f"relative tolerance {solver.rtol!r}"
    text = render(
        "documentation.html.jinja",
        name=program.name,
        drawing="" if drawing is None else drawing.text,
        least=0 if drawing is None else legible_width(drawing.text),
        n_states=program.n,
        n_switches=len(program.switches),
        steps=f"{solver.method}, {control}",
        structural=program.structural,
        variables=variables,
    )
    return text.encode()
