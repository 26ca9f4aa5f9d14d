"""help() of frozen classes shows what they declare, not what every object of Python has."""

from __future__ import annotations

import contextlib
import dataclasses
import inspect
import pydoc
from typing import Any

import fmu_export
import gearblocks as gb

PUBLIC = [
    kind
    for module in (gb, fmu_export)
    for name in module.__all__
    if inspect.isclass(kind := getattr(module, name)) and dataclasses.is_dataclass(kind)
]


def test_help_of_every_frozen_class_is_without_the_methods_that_python_adds() -> None:
    assert len(PUBLIC) > 30
    pages: dict[Any, str] = {kind: pydoc.plain(pydoc.render_doc(kind)) for kind in PUBLIC}
    added = ("__eq__", "__delattr__", "__setstate__", "__dataclass_fields__", "another day")
    assert [kind for kind, page in pages.items() if any(word in page for word in added)] == []
    lost = {
        kind: [f.name for f in dataclasses.fields(kind) if f.init and f.name not in page]
        for kind, page in pages.items()
    }
    assert not any(lost.values())


def test_objects_list_all_that_they_have_and_are_told_apart_by_descent() -> None:
    given = gb.Parameter("n", 3000, "rpm")
    assert {"__eq__", "__hash__", "si", "unit"} <= set(dir(given))
    assert isinstance(given, gb.Parameter) and not isinstance(given, gb.Input)


def test_signatures_show_the_defaults_themselves() -> None:
    shown: dict[str, str] = {}
    for module in (gb, fmu_export):
        for name in module.__all__:
            thing = getattr(module, name)
            if callable(thing):
                with contextlib.suppress(ValueError, TypeError):
                    shown[name] = str(inspect.signature(thing))
    assert len(shown) > 100 and "parameters: 'Mapping[str, float | str]' = {}" in shown["Scene"]
    assert [name for name, text in shown.items() if "<factory>" in text or " at 0x" in text] == []
