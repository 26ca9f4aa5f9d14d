"""Help, signatures and examples of blocks: everything that a class declares is in what Python says about it."""

from __future__ import annotations

import inspect
import pydoc

import pytest

import gearblocks as gb
from gearblocks.language import reference as module
from gearblocks.language.reference import annotation_of, effect_classes, example_of, written_doc

KINDS = [
    kind
    for name in gb.__all__
    if isinstance(kind := getattr(gb, name), type) and issubclass(kind, gb.Block | gb.Effect)
    if kind not in (gb.Block, gb.Effect)
]


class Motor(gb.Block):
    """A motor with a resistance.

    Example:
        motor = Motor(R=1.0)

        other = Motor(R=2.0)

    What follows is no example.
    """

    shaft = gb.Flange("output shaft")
    R: float = gb.param("resistance", "ohm", gt=0)
    u = gb.signal("voltage", "V", default=0.0)
    i = gb.State("current", "A", start=0.5)

    def physics(self, s):
        yield gb.Acts(s.shaft, s.i)
        yield gb.Rate(s.i, s.u - s.R * s.i)
        yield gb.Shows("torque", s.i, "N m", "torque on the shaft")


@pytest.mark.parametrize("kind", KINDS)
def test_every_field_flange_and_state_stands_in_the_help_with_words_and_unit(kind: type[gb.Block]) -> None:
    text = " ".join(kind.__doc__.split())
    assert text.startswith(" ".join(written_doc(kind).split()))
    assert written_doc(kind)
    for name, field in kind.fields.items():
        unit = "" if field.unit == "1" else f"{field.unit} "
        assert f" {name} " in text
        assert f"{unit}{'required' if field.required else ''}" in text
        assert field.words in text
    for name, declared in {**kind.flanges, **kind.states}.items():
        assert f" {name} " in text
        assert declared.words in text


@pytest.mark.parametrize("kind", KINDS)
def test_the_signature_has_every_field_by_name_and_asks_for_what_is_required(kind: type[gb.Block]) -> None:
    parameters = inspect.signature(kind).parameters
    assert list(parameters) == list(kind.fields)
    assert {p.kind for p in parameters.values()} <= {inspect.Parameter.KEYWORD_ONLY}
    for name, field in kind.fields.items():
        required = parameters[name].default is inspect.Parameter.empty
        assert required == field.required
        assert required or parameters[name].default is field.default


def test_bounds_defaults_and_effects_are_told() -> None:
    lines = gb.GearMesh.__doc__.splitlines()
    assert any(line.split()[:6] == ["module", "number", "m", "None", ">", "0"] for line in lines)
    assert any(line.split() == ["backlash", "gb.Backlash"] for line in lines)
    assert any(" ".join(line.split()) == "carrier turns; ground when open carrier of both axes" for line in lines)
    assert (
        'damping is present by c, damping_ratio, contact_damping; rig.without("*.damping") takes it away'
        in " ".join(" ".join(lines).split())
    )


def test_help_shows_the_tables_of_a_block_of_a_user_too() -> None:
    text = pydoc.render_doc(Motor, renderer=pydoc.plaintext)
    for line in ("Motor(*, R: float, u: Any = 0.0)", "R  number  ohm  required  > 0  resistance", "i  A  0.5  current"):
        assert line in text
    assert "torque  N m  torque on the shaft" in text


def test_a_class_without_a_docstring_does_not_borrow_that_of_its_base() -> None:
    class Bare(Motor):
        pass

    assert written_doc(Bare) == ""
    assert Bare.__doc__.startswith("\nFields")


def test_nothing_is_written_when_a_class_is_made_and_but_once_when_it_is_read() -> None:
    before = module._reference.cache_info()

    class Other(Motor):
        """Another motor."""

    assert module._reference.cache_info() == before
    assert Other.__doc__ is Other.__doc__
    assert module._reference.cache_info().misses == before.misses + 1


def test_the_base_classes_say_what_was_written_alone() -> None:
    assert gb.Block.__doc__ == written_doc(gb.Block)
    assert gb.Effect.__doc__.startswith("A modelled phenomenon")


def test_the_example_is_what_stands_under_its_word() -> None:
    assert example_of(Motor) == "motor = Motor(R=1.0)\n\nother = Motor(R=2.0)\n"
    assert example_of(gb.Block) == ""


def test_annotations_are_told_as_they_were_written() -> None:
    assert annotation_of(Motor, "R") == "float"
    assert annotation_of(Motor, "u") is None
    assert annotation_of(gb.Harmonic, "driven_by") == "Signal"


def test_the_classes_of_an_effect_are_those_of_its_annotation() -> None:
    assert effect_classes(gb.GearMesh, "stiffness_variation") == (gb.Fourier, gb.Square, gb.Profile)
    assert effect_classes(gb.GearMesh, "teeth") == ()
    assert effect_classes(Motor, "u") == ()


def test_what_may_slide_says_its_units_there() -> None:
    assert "where it slides, m stands for rad" in gb.Shaft.__doc__
    assert "where it slides" not in gb.GearMesh.__doc__
    assert "f is the force that the block exerts" in gb.Rack.__doc__
