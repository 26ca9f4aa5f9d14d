"""What limits the runs of a train, told before any run."""

import numpy as np
import pytest

import gearblocks as gb
from gearblocks.model.explaining import element_of


def _chain(seed: int) -> tuple[gb.Drivetrain, str]:
    """A chain of inertias and shafts, one of which is much stiffer than the others; its name."""
    random = np.random.default_rng(seed)
    count, rig = int(random.integers(3, 9)), gb.Drivetrain("chain")
    stiff = int(random.integers(count))
    parts = [rig.add("motor", gb.Inertia(J=float(random.uniform(0.01, 0.05))))]
    for i in range(count):
        k = float(random.uniform(1e3, 5e3)) * (400 if i == stiff else 1)
        parts.append(rig.add(f"shaft_{i}", gb.Shaft(k=k, damping_ratio=0.02)))
        parts.append(rig.add(f"disc_{i}", gb.Inertia(J=float(random.uniform(0.01, 0.05)))))
    rig.chain(rig.add("drive", gb.Torque(tau=10 * gb.sin(30 * gb.time))), *parts)
    return rig, f"shaft_{stiff}"


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.few(1)
def test_the_stiff_shaft_of_a_chain_is_named_and_so_is_the_way_out(seed: int) -> None:
    rig, stiff = _chain(seed)
    said = rig.explain()
    assert said.limiting == stiff
    assert said.rigid == f"{stiff}.compliance"
    highest = gb.modes(rig).frequencies.max()
    assert said.modes[0].rate == pytest.approx(highest, rel=1e-6)
    without = rig.without(said.rigid).explain()
    assert without.limiting != stiff
    assert without.modes[0].rate < 0.4 * highest


@pytest.mark.few(1)
@pytest.mark.parametrize("seed", range(8))
def test_a_stiff_shaft_limits_its_runs_too(seed: int) -> None:
    rig, stiff = _chain(seed)
    said = gb.simulate(rig, t_end=0.2, method="dp5").explain()
    assert said.limiting == stiff
    assert any(f"'{stiff}.compliance'" in words for words in said.remedies)


@pytest.mark.long
def test_states_and_switches_are_counted_by_kind_and_component() -> None:
    rig, _ = _chain(0)
    rig.connect(rig.add("brake", gb.Brake(capacity=5.0)).a, rig["motor"].a)
    said, model = rig.explain(), gb.build(rig)
    assert sum(said.states.values()) == model.program.n
    assert sum(said.switches.values()) == len(model.program.switches)
    assert set(said.switches) == {"brake"}


@pytest.mark.long
def test_a_motion_that_decays_is_told_by_its_damper() -> None:
    rig = gb.Drivetrain("damped")
    small, large = rig.add("small", gb.Inertia(J=1e-4)), rig.add("large", gb.Inertia(J=1.0))
    rig.chain(
        rig.add("wall", gb.Fixed()),
        rig.add("spring", gb.Shaft(k=10.0)),
        large,
        rig.add("damper", gb.Damper(c=50.0)),
        small,
    )
    first = rig.explain().modes[0]
    assert (first.element, first.swings) == ("damper", False)
    assert first.rate == pytest.approx(50.0 / 1e-4, rel=1e-3)


@pytest.mark.long
def test_gears_in_their_gap_are_told_of_as_they_are_in_contact() -> None:
    rig = gb.Drivetrain("pair")
    pinion, wheel = rig.add("pinion", gb.Inertia(J=1e-3)), rig.add("wheel", gb.Inertia(J=4e-3))
    gap = gb.Backlash(half_gap=5e-5)
    block = gb.GearMesh(teeth=(20, 40), external=True, module=2e-3, pressure_angle=0.35, k=1e8, c=1.0, backlash=gap)
    rig.chain(pinion, rig.add("mesh", block), wheel)
    r1 = 0.02 * np.cos(0.35)
    assert rig.explain().modes[0].rate == pytest.approx(r1 * np.sqrt(1e8 * (1 / 1e-3 + 4 / 4e-3)), rel=1e-3)


def test_parts_of_one_element_share_its_name() -> None:
    names = "mesh", "gear.sun_mesh[2]", "stage.shaft.spring[3]", "gear.planet[1]"
    assert [element_of(name) for name in names] == ["mesh", "gear.sun_mesh", "stage.shaft", "gear.planet"]


def test_an_explanation_reads_as_sentences_and_as_a_table() -> None:
    rig, stiff = _chain(0)
    said = rig.explain()
    assert f"'{stiff}' will limit the step" in str(said)
    assert "times slower" in str(said)
    assert "<table" in said._repr_html_()
    assert stiff in repr(said)
