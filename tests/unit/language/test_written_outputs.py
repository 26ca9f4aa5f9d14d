"""Outputs read off the source of `physics`: every output that a block of a program shows is among them."""

from __future__ import annotations

from typing import Any

import pytest

import gearblocks as gb
from gearblocks.cli import scripts
from gearblocks.language.reference import example_of
from gearblocks.language.written_outputs import written_outputs
from gearblocks.model.build import make_program
from gearblocks.train.graph import Train

BLOCKS = [getattr(gb.blocks, name) for name in gb.blocks.__all__]
EXAMPLES = {kind: example_of(kind) for kind in BLOCKS if issubclass(kind, gb.Block)}


def _assert_known(train: Train) -> int:
    """That each output of each block stands in its source with its unit and words; how many those are."""
    outputs = {q.name: q for q in make_program(train).outputs}
    count = 0
    for c in train.components:
        own = {name.removeprefix(f"{c.path}."): q for name, q in outputs.items() if name.startswith(f"{c.path}.")}
        known = {x.name: x for x in written_outputs(type(c.block))}
        for name, q in own.items():
            if "." in name:
                continue  # of a flange
            count += 1
            assert name in known, f"{c.path}.{name}"
            if not c.slides:
                assert known[name].unit == q.unit
                assert q.words in known[name].words
    return count


@pytest.mark.parametrize("kind", EXAMPLES)
@pytest.mark.few(15)
def test_outputs_of_the_example_of_a_block_are_known(kind: type[gb.Block]) -> None:
    scope: dict[str, Any] = {"gb": gb}
    composed = "\n".join(line for line in EXAMPLES[kind].splitlines() if "gb.simulate" not in line)
    exec(composed, scope)  # noqa: S102  our own docstring
    assert _assert_known(scope["rig"].train()) > 0


@pytest.mark.parametrize("model", [pytest.param(name, marks=pytest.mark.long) for name in scripts.shipped()])
def test_outputs_of_shipped_models_are_known(model: str) -> None:
    assert _assert_known(scripts.make(model).train()) > 0


def _shown(words: str, both: bool = False):
    yield gb.Shows("shared", 1, "N", words)
    if both:
        yield gb.Shows("both", 1)
    else:
        yield gb.Shows("one", 1)


class Shower(gb.Block):
    """Shows outputs in all ways."""

    flange = gb.Flange("shaft")

    def physics(self, s):
        yield from _shown("first", both=True)
        yield from _shown("second", True)
        for name in ("left", "right"):
            yield gb.Shows(f"at_{name}", s.flange.phi, unit="rad", words=f"angle on the {name}")
        for name, angle in (("in", s.flange.phi), ("out", -s.flange.phi)):
            yield gb.Shows(f"{name}_angle", angle)
        yield from self.more(s)
        for i in range(2):
            yield gb.Shows(f"number_{i}", 1)  # only a run knows the names

    def more(self, s):
        if s.flange is None:
            yield gb.Shows("perhaps", 1)


def test_functions_loops_over_names_and_conditions_on_constants_are_followed() -> None:
    assert [(x.name, x.unit, x.words) for x in written_outputs(Shower)] == [
        ("shared", "N", "first / second"),
        ("both", "1", ""),
        ("at_left", "rad", "angle on the left"),
        ("at_right", "rad", "angle on the right"),
        ("in_angle", "1", ""),
        ("out_angle", "1", ""),
        ("perhaps", "1", ""),
    ]


def test_a_block_without_source_has_help_without_outputs() -> None:
    scope: dict[str, Any] = {"gb": gb}
    lines = ["class Typed(gb.Block):", " f = gb.Flange('shaft')", " def physics(self, s):", "  yield gb.Shows('x', 1)"]
    exec("\n".join(lines), scope)  # noqa: S102  as at a prompt, which keeps no source
    assert written_outputs(scope["Typed"]) == ()
    assert "Flanges" in scope["Typed"].__doc__
