"""Values of a wrong sort - lists where numbers are asked, arrays, texts, handles - end in words, wherever they are given."""

from __future__ import annotations

import contextlib
import io
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import fmu_export
import gearblocks as gb
from gearblocks.errors import GearblocksError
from gearblocks.language import block
from gearblocks.language.reference import example_of

KINDS = [
    kind for name in gb.__all__
    if isinstance(kind := getattr(gb, name), type) and issubclass(kind, gb.Block) and kind is not gb.Block
]  # fmt: skip
SORTS: Mapping[str, Any] = {
    "number": 0.97, "nan": float("nan"), "text": "abc", "none": None, "truth": True, "list": [1.0, 2.0], "empty": (),
    "dict": {"a": 1.0}, "array": np.array([1.0, 2.0]), "complex": 1 + 2j, "class": gb.Backlash, "function": lambda t: t,
    "effect": gb.Backlash(half_gap=1e-4), "table": gb.Table([0.0, 1.0], [0.0, 1.0]), "parameter": gb.Parameter("p", 2.0),
    "expression": gb.sin(gb.time), "rows": [(0.0, 0.9), (1.0,)], "texts": ("1", "2"),
}  # fmt: skip

CALLS = (
    "simulate", "modes", "linearize", "response", "campbell", "sweep", "study", "poincare", "orbit", "bifurcation",
    "contact_loss", "cases", "extremes", "to", "Table", "element", "in_modes", "export",
)  # fmt: skip


@pytest.fixture(scope="module")
def examples() -> Mapping[type, gb.Block]:
    """A block of each kind, as the examples of the catalogue make it."""
    made: dict[type, gb.Block] = {}
    init = block.Declared.__init__

    def kept(self: Any, *unnamed: Any, **values: Any) -> None:
        init(self, *unnamed, **values)
        made.setdefault(type(self), self)

    with pytest.MonkeyPatch.context() as patch, contextlib.redirect_stdout(io.StringIO()):
        patch.setattr(block.Declared, "__init__", kept)
        patch.setattr(gb, "simulate", lambda *_, **__: _Anything())
        for kind in KINDS:
            exec(example_of(kind), {"gb": gb})  # noqa: S102
    return made


class _Anything:
    """A run that nobody looks at."""

    def __getitem__(self, _: Any) -> Any:
        return self

    def __getattr__(self, _: str) -> Any:
        return self

    def __call__(self, *_: Any, **__: Any) -> Any:
        return self


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__name__)
def test_a_field_takes_what_it_is_declared_for_or_says_so(
    kind: type[gb.Block], examples: Mapping[type, gb.Block]
) -> None:
    for field in kind.fields:
        for value in SORTS.values():
            with contextlib.suppress(GearblocksError):
                rig = gb.Drivetrain("rig")
                rig.add("part", examples[kind].changed(**{field: value}))
                rig.describe()


def _rig() -> gb.Drivetrain:
    rig = gb.Drivetrain("rig")
    tau = gb.Input("tau", start=2.0, unit="N m") + gb.sin(gb.Parameter("n", 30.0, "rad/s") * gb.time)
    rig.chain(
        rig.add("drive", gb.Torque(tau=tau)), rig.add("a", gb.Inertia(J=0.1)), rig.add("shaft", gb.Shaft(k=1e3, c=1.0)),
        rig.add("b", gb.Inertia(J=0.2)), rig.add("load", gb.SpeedLoad(coeffs=(0.0, 1.0, 0.0))),
    )  # fmt: skip
    return rig


@pytest.fixture(scope="module")
def calls() -> dict[str, tuple[Callable[..., Any], dict[str, Any]]]:
    """Functions, and the arguments by which they end well and soon."""
    rig, section, torque = _rig(), gb.stroboscopic("n"), gb.rms("shaft.torque")
    run = gb.simulate(rig, t_end=0.02)
    none = dict.fromkeys(("inputs", "parameters"))
    study = {"quantity": torque, "t_end": 0.01, "threads": 1, "method": "auto", **none}
    return {
        "simulate": (gb.simulate, {"train": rig, "t_end": 0.01, "outputs": "*", "method": "auto", "watch": True, **none}),
        "modes": (gb.modes, {"train": rig, "count": None, "parameters": None, "frozen_angles": False}),
        "linearize": (gb.linearize, {"train": rig, "outputs": "*", "inputs": None, "parameters": None}),
        "response": (
            gb.frequency_response, {"train": rig, "input": "tau", "outputs": "b.w", "frequencies": [1.0], "parameters": None},
        ),
        "campbell": (
            gb.campbell, {"train": rig, "speed": "a.w", "speeds": [1.0, 2.0], "orders": [1.0], "count": None},
        ),
        "sweep": (gb.sweep, {"train": rig, "values": {"shaft.k": [1e3, 2e3]}, **study}),
        "study": (gb.study, {"train": rig, "cases": [{"shaft.k": 1e3}], **study}),
        "poincare": (gb.poincare, {"train": rig, "section": section, "of": ["a.w"], "transient": 2, "keep": 2}),
        "orbit": (gb.periodic_orbit, {"train": rig, "section": section, "transient": 2, "periods": 1, "parameters": None}),
        "bifurcation": (
            gb.bifurcation,
            {"train": rig, "parameter": "n", "values": [20.0], "section": section, "of": "a.w", "transient": 2, "keep": 2},
        ),
        "contact_loss": (gb.contact_loss, {"run": run, "component": "a"}),
        "cases": (gb.latin_hypercube, {"bounds": {"n": (0.0, 1.0)}, "number": 3, "seed": 0}),
        "extremes": (run.extremes, {"name": "shaft.torque", "after": None, "before": None}),
        "to": (run.to, {"name": "shaft.torque", "unit": "kN m"}),
        "Table": (gb.Table, {"x": [0, 1], "y": [0, 1], "kind": "linear", "periodic": False}),
        "element": (rig.equations().element, {"path": "shaft"}),
        "in_modes": (rig.equations().in_modes, {"modes": {}}),
        "export": (
            fmu_export.export,
            {"train": rig, "path": "rig.fmu", "platforms": (), "outputs": "*", "method": "auto", "parameters": None},
        ),
    }  # fmt: skip


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("name", CALLS)
def test_an_argument_takes_what_it_is_annotated_with_or_says_so(
    name: str, calls: Mapping[str, tuple[Callable[..., Any], dict[str, Any]]], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:  # fmt: skip
    monkeypatch.chdir(tmp_path)
    function, arguments = calls[name]
    for argument in arguments:
        for value in SORTS.values():
            with contextlib.suppress(GearblocksError):
                function(**arguments | {argument: value})
