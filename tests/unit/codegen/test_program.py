"""A program says what it is in one line."""

import pickle

import gearblocks as gb
from gearblocks.codegen.program import Program


def test_a_program_prints_as_one_line_and_keeps_its_text():
    rig = gb.Drivetrain("small")
    one, two, shaft = (
        rig.add("one", gb.Inertia(J=1.0)),
        rig.add("two", gb.Inertia(J=1.0)),
        rig.add("shaft", gb.Shaft(k=9.0)),
    )
    rig.chain(one, shaft, two)
    program = gb.build(rig).program
    text = repr(program)
    assert text.startswith("Program('small': 3 states, ") and "\n" not in text and len(text) < 200
    assert program.key[:8] in text
    assert program.source not in text
    assert pickle.loads(pickle.dumps(program)) == Program.from_bytes(program.to_bytes()) == program
