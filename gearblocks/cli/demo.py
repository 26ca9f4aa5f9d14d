"""The main job, shown on the spline coupling: equations, four speeds, cost, FMU, one page that ties it together."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from gearblocks import __version__
from gearblocks.analysis.sections import Label, classify, stroboscopic
from gearblocks.cli import scripts
from gearblocks.cli.report import precision, regimes
from gearblocks.drivetrain import Drivetrain
from gearblocks.errors import GearblocksError
from gearblocks.files import make_folder, write_text
from gearblocks.language.units import rpm as radians_per_second
from gearblocks.pages import page
from gearblocks.running import build
from gearblocks.simulation.plotting import Curve, Plane, cost, planes
from gearblocks.solver.library import Model

Say = Callable[[str], None]

HALF_GAP = "spline.backlash.half_gap"
PUBLISHED = {300: "harmonic", 348: "period 2", 360: "period 5", 1080: "chaos"}
EXPECTED = {300: "period 1", 348: "period 2", 360: "period 5", 1080: "not periodic"}
LEVELS = (1e-3, 1e-6, 1e-9)
TOLERANCES = tuple(10.0**-k for k in range(3, 13))
FILES = {
    "scheme.svg": "the coupling as a kinematic scheme",
    "equations.html": "equations of motion, for a browser",
    "equations.tex": "equations of motion, LaTeX",
    "model.c": "the C generated from them",
    "phase.png": "phase planes at four speeds",
    "poincare.png": "points once per turn at four speeds",
    "cost.png": "CPU time against error",
    "cost.csv": "the numbers behind it",
    "spline_coupling.fmu": "the coupling as an FMU",
    "check.txt": "what the check of the FMU says",
}


@dataclass(frozen=True, slots=True)
class Regime:
    """What was found at one speed, and the files that show it."""

    rpm: int
    label: str
    evidence: str
    phase: Plane
    section: Plane

    @property
    def published(self) -> str:
        """What the paper says of this speed."""
        return PUBLISHED[self.rpm]

    @property
    def agrees(self) -> bool:
        """Whether the label is the one known for set S."""
        return self.label == EXPECTED[self.rpm]

    @property
    def picture(self) -> str:
        """File of the trace over time."""
        return f"time_{self.rpm}.png"

    @property
    def data(self) -> str:
        """File of the last turns."""
        return f"run_{self.rpm}.csv"


def demo(out: Path, say: Say) -> bool:
    """Fill the folder `out`; True when every regime is the known one and the FMU passes its check."""
    began = time.perf_counter()
    folder = make_folder(out)
    rig = scripts.make("spline_coupling")

    def tell(words: str) -> None:
        say(f"{time.perf_counter() - began:5.1f} s  {words}")

    tell("equations of motion")
    model = _equations(rig, folder)
    coupling = regimes.Coupling(model, "speed", "spline", HALF_GAP, _value(model, HALF_GAP), ("x1", "x2", "x3"))
    found = _regimes(coupling, folder, tell)
    price = _cost(coupling, folder, tell)
    tell("FMU and its check")
    fmu = _fmu(model, folder)
    listed = dict(FILES)
    for regime in found:
        listed |= {regime.picture: f"traces at {regime.rpm} rpm", regime.data: f"the last turns at {regime.rpm} rpm"}
    values = {
        "title": "gearblocks demo: an involute spline coupling",
        "version": __version__,
        "total": time.perf_counter() - began,
        "regimes": found,
        "cost": price,
        "fmu": fmu,
        "half_gap": coupling.half_gap_path,
        "files": [{"name": name, "words": words} for name, words in listed.items() if (folder / name).is_file()],
    }
    write_text(folder / "index.html", page("gearblocks.cli.report", "index.html.jinja", **values))
    tell("done")
    for regime in found:
        if not regime.agrees:
            say(f"at {regime.rpm} rpm: {regime.label}, expected {EXPECTED[regime.rpm]}")
    if not fmu["ok"]:
        say(f"the FMU did not pass its check: see {folder / 'check.txt'}")
    return all(regime.agrees for regime in found) and bool(fmu["ok"])


def _equations(rig: Drivetrain, folder: Path) -> Model:
    equations = rig.equations()
    write_text(folder / "equations.tex", equations.latex() + "\n")
    drawing = rig.draw()
    drawing.save(folder / "scheme.svg")
    write_text(folder / "equations.html", equations.html(str(drawing)))
    model = build(rig)
    write_text(folder / "model.c", model.program.source)
    return model


def _regimes(coupling: regimes.Coupling, folder: Path, tell: Say) -> list[Regime]:
    found = []
    for rpm in PUBLISHED:
        tell(f"{rpm} rpm")
        speed = {coupling.speed: radians_per_second(rpm)}
        label = classify(coupling.model, stroboscopic(coupling.speed), transient=400, parameters=speed)
        answer = regimes.answer(coupling, rpm, transient=400, keep=3000 if label.period is None else 200, turns=10)
        phase, section = regimes.phase(coupling, answer, label.words), regimes.section(coupling, answer, label.words)
        regime = Regime(rpm, label.words, _evidence(label), phase, section)
        regimes.traces(coupling, answer, folder / regime.picture)
        answer.last.to_csv(folder / regime.data)
        found.append(regime)
    planes([regime.phase for regime in found], path=folder / "phase.png")
    planes([regime.section for regime in found], path=folder / "poincare.png")
    return found


def _evidence(label: Label) -> str:
    if not label.settled:
        return ""
    words = " and ".join(f"{rtol:.0e}" for rtol in label.accuracies)
    words = f"tolerances {words} agree: "
    if label.period is None:
        return f"{words}points do not return after any number of turns up to 16 (nearest miss {label.residual:.0e})"
    apart = f" and lie {label.separation:.2g} of it apart" if label.period > 1 else ""
    return f"{words}points repeat within {label.residual:.0e} of the motion's size{apart}"


def _cost(coupling: regimes.Coupling, folder: Path, tell: Say) -> dict[str, Any]:
    """Work-precision of ten turns at 360 rpm, where the teeth part several times in every turn."""
    rpm, turns, per_turn = 360, 10, 40
    turn = 60.0 / rpm
    t = turn * np.arange(turns * per_turn + 1) / per_turn
    steps = tuple(turn / n for n in (50, 100, 200, 400, 800, 1600, 3200))
    adaptive = [precision.Line(name, locate, TOLERANCES) for name in ("dp8", "dp5") for locate in (True, False)]
    fixed = [precision.Line("rk4", locate, steps=steps) for locate in (True, False)]
    tell("reference for cost and error")
    task, doubt = precision.pose(coupling.model, t, coupling.relative, {coupling.speed: 2.0 * np.pi / turn})
    measured = precision.curves(task, adaptive + fixed, lambda words: tell(f"cost of {words}"))
    drawn = [
        Curve(line.label, [p.error for p in points], [p.seconds for p in points], dashed=not line.locate)
        for line, points in measured
    ]
    title = f"Spline coupling, set S, {rpm} rpm, {turns} turns"
    cost(drawn, title=title, error="largest relative error of the relative coordinates", path=folder / "cost.png")
    rows = [
        f"{line.method},{int(line.locate)},{p.asked!r},{p.error!r},{p.seconds!r},{p.steps},{p.rhs_calls}"
        for line, points in measured
        for p in points
    ]
    write_text(folder / "cost.csv", "\n".join(["method,located,asked,error,cpu_seconds,steps,rhs_calls", *rows, ""]))
    return {
        "question": f"The question: the first {turns} turns at {rpm} rpm; the teeth part in each of them.",
        "doubt": doubt,
        "levels": LEVELS,
        "rows": [_row(line, points) for line, points in measured],
        "sentence": _sentence(measured),
    }


def _row(line: precision.Line, points: list[precision.Point]) -> dict[str, Any]:
    cells = [precision.at_error(points, level) for level in LEVELS]
    return {
        "label": line.label,
        "cells": ["-" if seconds is None else f"{1e3 * seconds:.3g} ms" for seconds in cells],
        "best": f"{min((point.error for point in points), default=np.inf):.0e}",
    }


def _sentence(measured: list[tuple[precision.Line, list[precision.Point]]]) -> str:
    """The dearest and the cheapest way to one error, in words."""
    level = LEVELS[1]
    reached = [
        (seconds, line) for line, points in measured if (seconds := precision.at_error(points, level)) is not None
    ]
    if len(reached) < 2:
        return f"Fewer than two of these ways reach an error of {level:.0e}."
    (fast, quick), (slow, dear) = min(reached, key=lambda one: one[0]), max(reached, key=lambda one: one[0])
    missing = len(measured) - len(reached)
    rest = f"; {missing} of the {len(measured)} do not get there at all" if missing else ""
    return (
        f"An error of {level:.0e} is cheapest with {quick.label}: {1e3 * fast:.2g} ms; it is dearest with "
        f"{dear.label}: {1e3 * slow:.2g} ms, {slow / fast:.0f} times as much{rest}."
    )


def _fmu(model: Model, folder: Path) -> dict[str, Any]:
    from markupsafe import Markup

    import fmu_export

    try:
        path = fmu_export.export(model, folder / "spline_coupling.fmu", t_end=2.0)
        report = fmu_export.check(path)
    except GearblocksError as error:
        return {"path": "", "ok": False, "report": str(error)}
    write_text(folder / "check.txt", str(report) + "\n")
    return {"path": path.name, "ok": report.ok, "report": Markup(report.to_html())}


def _value(model: Model, path: str) -> float:
    return next(
        float(value) for one, value in zip(model.program.parameters, model.values, strict=True) if one.path == path
    )
