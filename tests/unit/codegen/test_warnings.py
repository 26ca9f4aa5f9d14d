"""Generated C of trains of every kind compiles without a remark, with no flag of ours."""

import pytest

import gearblocks as gb
from gearblocks.solver.compiler import find_compiler
from gearblocks.solver.library import core_files


def _sensed(read):
    """A train whose torque reads an output."""
    rig = gb.Drivetrain("sensed")
    one, two = rig.add("one", gb.Inertia(J=1.0)), rig.add("two", gb.Inertia(J=2.0))
    shaft, drive = rig.add("shaft", gb.Shaft(k=9.0, c=0.1)), rig.add("drive", gb.Torque(tau=gb.sense(read)))
    rig.chain(drive, one, shaft, two, rig.add("fan", gb.Torque(tau=gb.sin(gb.time))))
    return rig


def _massless():
    rig = gb.Drivetrain("massless")
    one, two = rig.add("one", gb.Inertia(J=1.0)), rig.add("two", gb.Inertia(J=2.0))
    left, right = rig.add("left", gb.Shaft(k=9.0)), rig.add("right", gb.Shaft(k=9.0))
    rig.chain(one, left, right, two)
    return rig


def _switched():
    rig = gb.Drivetrain("switched")
    one, two = rig.add("one", gb.Inertia(J=1.0)), rig.add("two", gb.Inertia(J=2.0))
    clutch, drive = rig.add("clutch", gb.Clutch(capacity=1.0)), rig.add("drive", gb.Torque(tau=gb.sin(gb.time)))
    rig.chain(drive, one, clutch, two)
    return rig


def _prescribed(angle):
    rig = gb.Drivetrain("prescribed")
    motor = rig.add("motor", gb.Angle(phi=gb.sin(gb.time)) if angle else gb.Speed(w=1.0))
    shaft, load = rig.add("shaft", gb.Shaft(k=9.0)), rig.add("load", gb.Inertia(J=1.0))
    rig.chain(motor, shaft, load)
    return rig


def _joint():
    rig = gb.Drivetrain("joint")
    one, two = rig.add("one", gb.Inertia(J=1.0, w0=1.0)), rig.add("two", gb.Inertia(J=2.0))
    rig.chain(one, rig.add("joint", gb.UniversalJoint(angle=0.3)), two)
    return rig


def _long():
    rig = gb.Drivetrain("long")
    row = [
        part
        for i in range(300)
        for part in (rig.add(f"disc{i}", gb.Inertia(J=1.0)), rig.add(f"shaft{i}", gb.Shaft(k=9.0)))
    ]
    rig.chain(*row, rig.add("end", gb.Inertia(J=1.0)))
    return rig


RIGS = {
    "nothing to sense": _massless,
    "a speed": lambda: _sensed("two.w"),
    "an output of time alone": lambda: _sensed("fan.torque"),
    "switched constraints": _switched,
    "a prescribed speed": lambda: _prescribed(False),
    "a prescribed angle": lambda: _prescribed(True),
    "gains that change": _joint,
    "long tables": _long,
}

QUICK = ("a speed", "switched constraints", "a prescribed angle", "gains that change")


@pytest.mark.few(1)
@pytest.mark.parametrize("kind", [pytest.param(kind, marks=[pytest.mark.long] * (kind not in QUICK)) for kind in RIGS])
def test_generated_c_compiles_without_a_remark(kind, tmp_path):
    for name, data in core_files().items():
        (tmp_path / name).write_bytes(data)
    (tmp_path / "model.c").write_text(gb.build(RIGS[kind]()).program.source, encoding="utf-8")
    remarks = ("-Wall", "-Wextra", "-Wpedantic", "-Werror")
    find_compiler().run(["-std=c99", "-O2", *remarks, "-c", "model.c", "-o", "model.o"], tmp_path)
