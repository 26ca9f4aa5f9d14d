"""Pages of equations: wide conditions stand in lines, and a page is the same in every process."""

import os
import re
import subprocess
import sys

import pytest

import gearblocks as gb

CONDITIONS = """
import gearblocks as gb
rig = gb.Drivetrain("shift")
body, other = rig.add("body", gb.Inertia(J=1.0, w0=1.0)), rig.add("other", gb.Inertia(J=1.0, w0=2.0))
speed, pace = gb.sense("body.w"), gb.sense("other.w")
one, two = (gb.piecewise((2.0, x > 3.0), (1.0, True)) for x in (speed, pace))
rig.connect(body.a, rig.add("drive", gb.Torque(tau=one * two + one * pace)).flange)
print(rig.equations().latex())
"""


@pytest.mark.parametrize("seeds", [("1", "2"), pytest.param(("1", "3", "4"), marks=pytest.mark.long)])
def test_a_page_is_the_same_whatever_seeds_the_hashes(seeds):
    printed = []
    for seed in seeds:
        command, environment = [sys.executable, "-c", CONDITIONS], {**os.environ, "PYTHONHASHSEED": seed}
        done = subprocess.run(command, capture_output=True, text=True, check=True, env=environment)
        printed.append(done.stdout)
    assert printed[0].count("begin{cases}") == 2
    assert len(set(printed)) == 1


def _tables(words):
    """How many tables of MathML a page with a condition on four limits has."""
    rig = gb.Drivetrain("wide")
    body = rig.add("body", gb.Inertia(J=1.0, w0=1.0))
    limits = [gb.Parameter(f"{words}{i}", 1.0, "rad/s") for i in range(4)]
    speed = gb.sense("body.w")
    within = (speed > limits[0]) & (speed < limits[1]) | (speed > limits[2]) & (speed < limits[3])
    rig.connect(body.a, rig.add("drive", gb.Torque(tau=gb.piecewise((2.0, within), (1.0, True)))).flange)
    return rig.equations().html().count("<mtable>")


def test_a_wide_condition_stands_in_lines():
    """Those that do not fit into a line of their cell make a table in the table of the cases."""
    assert _tables("u") == 1
    assert _tables("least_speed_of_the_wheels_") == 2


def test_the_nomenclature_of_a_page_has_its_units_as_they_are_printed():
    rig = gb.Drivetrain("units")
    gap, drag = gb.Backlash(half_gap="60 um"), gb.SpeedLoad(coeffs=(0.0, 0.1, 0.2))
    mesh = gb.GearMesh(teeth=(20, 30), external=True, module="2 mm", pressure_angle="20 deg", k=1e8, backlash=gap)
    rig.chain(rig.add("pinion", gb.Inertia(J=1e-3)), rig.add("mesh", mesh), rig.add("wheel", gb.Inertia(J=1e-3)))
    rig.connect(rig.add("drag", drag).flange, rig["wheel"].b)
    page = rig.equations().html(rig._repr_svg_())
    for unit in ("kg m²", "µm", "N m s²/rad²", "deg"):
        assert f'<td class="unit">{unit}</td>' in page
    assert "m2<" not in page and '<td class="unit">1</td>' not in page
    width = float(re.search(r'<svg [^>]*?width="([0-9.]+)"', page)[1])
    assert f"--least: {round(0.75 * width)}px" in page  # on a telephone it is moved aside, not made small
    assert "--least:" not in rig.equations().html().partition("</head>")[2]


def test_what_a_notebook_shows_touches_nothing_beside_it():
    rig = gb.Drivetrain("two")
    rig.chain(rig.add("a", gb.Inertia(J=1.0)), rig.add("shaft", gb.Shaft(k=1.0)), rig.add("b", gb.Inertia(J=2.0)))
    for thing in (rig.equations(), rig.equations().document(), gb.linearize(rig)):
        shown = thing._repr_html_()
        assert shown.startswith('<div class="gearblocks">') and "<html" not in shown and "<body" not in shown
        style = shown.partition("<style>")[2].partition("</style>")[0].replace("@media (max-width: 40rem) {", "")
        rules = [rule.partition("{")[0].strip() for rule in style.split("}")]
        assert {rule.split()[0] for rule in rules if rule} == {".gearblocks"}
    page = rig.equations().html()
    assert page.startswith("<!DOCTYPE html>") and '<body class="gearblocks">' in page and page.count("<style>") == 1


def test_a_long_name_breaks_and_what_is_wide_goes_on_in_its_own_box():
    """On a telephone nothing but these boxes moves aside."""
    rig = gb.Drivetrain("rolling")
    name = "quadratic_speed_dependent_force_of_the_driver"
    rig.connect(rig.add("body", gb.Inertia(J=1.0)).a, rig.add(name, gb.SpeedLoad(coeffs=(0.0, 0.1, 0.2))).flange)
    page = rig.equations().html()
    assert f"<h2>{name} (SpeedLoad)</h2>" in page
    rules = dict(re.findall(r"^ *(\.[^{}]+?) \{([^{}]*)\}", page.split("@media")[0], re.MULTILINE))
    assert "overflow-wrap: break-word" in rules[".gearblocks"]
    for box in (".gearblocks .wide", ".gearblocks .equation > div"):
        assert "overflow-x: auto" in rules[box]
    assert "no-repeat scroll" in rules[".gearblocks :is(.wide, .equation > div)"]  # a shadow where it goes on
    assert "overflow-wrap: break-word" in gb.simulate(rig, t_end=0.1)._repr_html_()
