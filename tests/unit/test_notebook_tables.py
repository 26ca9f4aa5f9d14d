"""What results say of themselves in a notebook: small tables whose text is escaped."""

from __future__ import annotations

from typing import Any

import pytest
from lxml import html

import gearblocks as gb
from gearblocks.pages import MOST_ROWS, small_table

NAME = "two & <b>discs</b>"


@pytest.fixture(scope="module")
def model() -> gb.Model:
    rig = gb.Drivetrain(NAME)
    motor, shaft, wheel = (
        rig.add("motor", gb.Inertia(J=1.0, w0=1.0)), rig.add("shaft", gb.Lash(k=100.0, c=0.1, half_gap=1e-3)),
        rig.add("wheel", gb.Inertia(J=2.0)),
    )  # fmt: skip
    rig.chain(motor, shaft, wheel)
    return gb.build(rig)


def cells(text: str) -> list[list[str]]:
    """Rows of the table in a fragment of HTML."""
    return [[cell.text_content().strip() for cell in row] for row in html.fragment_fromstring(text).iter("tr")]


def shown(thing: Any) -> str:
    text = thing._repr_html_()
    assert isinstance(text, str) and "<b>" not in text
    return text


def test_a_run_says_what_it_is(model: gb.Model) -> None:
    run = gb.simulate(model, t_end=1.0)
    text, rows = shown(run), dict(cells(run._repr_html_()))
    assert "Run of &#39;two &amp; &lt;b&gt;discs&lt;/b&gt;&#39;" in text
    assert rows["time"] == "0 .. 1 s" and rows["samples"] == f"{len(run.t):,}"
    assert rows["events"].startswith(f"{len(run.events)}: shaft") and rows["steps"] == f"{run.stats.steps:,}"
    assert sum(run.events.counts().values()) == len(run.events) > 0
    assert rows["energy residual"].startswith(f"{run.energy.residual:.1e} of a turnover")


def test_counters_and_energy_are_tables(model: gb.Model) -> None:
    run = gb.simulate(model, t_end=1.0)
    assert ["steps", f"{run.stats.steps:,}"] in cells(shown(run.stats))
    rows = cells(shown(run.energy))
    assert rows[0] == ["stored at the start", "5.000000e-01", "J"] and rows[-1][0] == "left over"
    assert [row[0] for row in rows] == [line[:25].split("  ")[0] for line in str(run.energy).splitlines()[:-1]]


def test_modes_crossings_and_studies_are_tables(model: gb.Model) -> None:
    modes = gb.modes(model, at={"motor.phi": 0.1})
    rows = cells(shown(modes))
    assert rows[0] == ["", "Hz", "rad/s", "damping", "moves most", "strained most"] and len(rows) == 1 + len(modes)
    diagram = gb.campbell(model, "motor.w", [1.0, 5.0, 20.0], orders={"twice": 2.0}, at={"motor.phi": 0.1})
    rows = cells(shown(diagram))
    assert rows[0] == ["rpm", "Hz", "mode", "order"] and len(rows) == 1 + len(diagram.crossings) > 1
    study = gb.sweep(model, {"shaft.k": [100.0, 200.0]}, quantity=gb.peak("motor.w"), t_end=0.1)
    assert cells(shown(study))[1] == ["peak(motor.w)", "1 rad/s"]


def test_lists_and_comparisons_are_tables(model: gb.Model) -> None:
    rig = gb.Drivetrain("one")
    rig.chain(rig.add("drive", gb.Torque(tau="5 N m")), rig.add("disc", gb.Inertia(J=2.0)))
    rows = cells(shown(rig.parameters()))
    assert rows[0] == ["name", "value", "unit", "meaning"] and ["disc.J", "2", "kg m2", "moment of inertia"] in rows
    runs = [gb.simulate(model, t_end=0.1, parameters={"shaft.k": k}) for k in (100.0, 200.0)]
    found = gb.compare(*runs)
    rows = cells(shown(found))
    assert rows[1][0] == found.rows[0].name and len(rows) > 2


def test_a_part_of_a_run_says_nothing_of_steps_that_it_did_not_make(model: gb.Model) -> None:
    part = gb.simulate(model, t_end=1.0).between(0.2, "400 ms")
    assert "0.2 .. 0.4 s, 1001 samples" in repr(part) and "steps" not in repr(part) and "residual" not in repr(part)
    assert [row[0] for row in cells(shown(part))] == ["time", "samples", "outputs", "events"]


def test_a_long_table_is_cut_and_says_so() -> None:
    text = small_table("numbers", [(i, "<i>") for i in range(MOST_ROWS + 5)], numbers=(0,))
    assert len(cells(text)) == MOST_ROWS and "and 5 more rows" in text and "<i>" not in text
    assert "<table" not in small_table("nothing", ())


def test_a_notebook_shows_what_describes_a_train_as_lines() -> None:
    rig = gb.Drivetrain("two")
    rig.chain(rig.add("a", gb.Inertia(J=1.0)), rig.add("shaft", gb.Shaft(k=1.0)), rig.add("b", gb.Inertia(J=2.0)))
    told = rig.describe()
    written: list[str] = []

    class Printer:
        text = staticmethod(written.append)

    told._repr_pretty_(Printer(), False)  # type: ignore[attr-defined]
    assert written == [str(told)]
    assert isinstance(told, str)
    assert len(written[0].splitlines()) >= 4
    told._repr_pretty_(Printer(), True)  # type: ignore[attr-defined]
    assert written[1] == "..."
