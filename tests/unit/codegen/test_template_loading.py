"""Compiled templates are kept, and taken again only where they are those of the sources."""

import pytest

import gearblocks as gb
from gearblocks.assembly.assemble import assemble
from gearblocks.codegen.generate import generate


class _Place:
    """Keeps bytes in memory and counts."""

    def __init__(self, kept=None):
        self.kept, self.writes = dict(kept or {}), 0

    def read(self, kind, key):
        return self.kept.get((kind, key))

    def write(self, kind, key, data):
        self.kept[kind, key] = data
        self.writes += 1


def _program(place):
    rig = gb.Drivetrain("two bodies")
    rig.chain(rig.add("one", gb.Inertia(J=1.0)), rig.add("shaft", gb.Shaft(k=2.0)), rig.add("two", gb.Inertia(J=3.0)))
    return generate(assemble(rig.train()), place)


def test_what_is_kept_is_not_compiled_again():
    first = _Place()
    program = _program(first)
    assert first.writes > 10
    second = _Place(first.kept)
    assert _program(second).to_bytes() == program.to_bytes() == _program(None).to_bytes()
    assert second.writes == 0


@pytest.mark.long
def test_bytes_of_another_jinja_are_compiled_anew():
    first = _Place()
    program = _program(first)
    other = _Place(dict.fromkeys(first.kept, b"no bytecode of jinja"))
    assert _program(other).source == program.source
    assert other.writes == first.writes
