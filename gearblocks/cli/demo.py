"""The main job, shown on the spline coupling: equations, four speeds, cost, FMU, one page that ties it together."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from gearblocks import __version__
from gearblocks.analysis.regimes.regime import classify
from gearblocks.analysis.scenes.work_precision import work_precision
from gearblocks.analysis.scenes.work_precision_points import Point
from gearblocks.analysis.sections import stroboscopic
from gearblocks.cli import scripts
from gearblocks.cli.report import regimes
from gearblocks.drivetrain import Drivetrain
from gearblocks.errors import GearblocksError
from gearblocks.files import make_folder, write_text
from gearblocks.language.functions import rpm as radians_per_second
from gearblocks.pages import page
from gearblocks.running import build
from gearblocks.simulation.plotting import Plane, planes
from gearblocks.solver.library import Model

Say = Callable[[str], None]

HALF_GAP = "spline.backlash.half_gap"
PUBLISHED = {300: "harmonic", 348: "period 2", 360: "period 5", 1080: "chaos"}
EXPECTED = {300: "period 1", 348: "period 2", 360: "period 5", 1080: "chaotic"}
LEVELS = (1e-2, 1e-4, 1e-6, 1e-8)
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
    price = _cost(folder, tell)
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
        phase, section = regimes.phase(coupling, answer, label.label), regimes.section(coupling, answer, label.label)
        regime = Regime(rpm, label.label, "; ".join(label.evidence), phase, section)
        regimes.traces(coupling, answer, folder / regime.picture)
        answer.last.to_csv(folder / regime.data)
        found.append(regime)
    planes([regime.phase for regime in found], path=folder / "phase.png")
    planes([regime.section for regime in found], path=folder / "poincare.png")
    return found


def _first_of_each(tell: Say) -> Say:
    """Says of the runs of a work-precision study the first at each tolerance or step alone: there are a dozen of each."""
    said: set[str] = set()

    def shown(words: str) -> None:
        accuracy = words.partition(", ")[2].partition(",")[0] or words
        if accuracy not in said:
            said.add(accuracy)
            tell(f"what accuracy costs: {accuracy}")

    return shown


def _cost(folder: Path, tell: Say) -> dict[str, Any]:
    """Work and precision of the largest force at 360 rpm, where the teeth part in every turn."""
    scene = scripts.scene("spline_coupling:period_5")
    found = work_precision(scene, progress=_first_of_each(tell))
    found.plot(folder / "cost.png")
    found.to_csv(folder / "cost.csv")
    lines = [line for line in found.lines() if any(not point.failure for point in line)]
    return {
        "question": f"The question: {scene}.",
        "levels": LEVELS,
        "rows": [_row(line) for line in lines],
        "notes": found.notes,
        "sentence": found.sentence,
    }


def _row(line: list[Point]) -> dict[str, Any]:
    """What a method costs at the levels: its cheapest run from which on all are within them."""
    done = [point for point in line if not point.failure]
    sure = [next((p for i, p in enumerate(done) if _largest(done[i:]) <= level), None) for level in LEVELS]
    located = "" if line[0].effort.locate else ", corners not located"
    return {
        "label": line[0].effort.method + located,
        "cells": ["-" if p is None else f"{1e3 * p.seconds:.3g} ms" for p in sure],
        "best": f"{min(float(p.errors.max()) for p in done):.0e}",
    }


def _largest(points: list[Point]) -> float:
    return max(float(point.errors.max()) for point in points)


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
