"""What the motion does not see (order and sense of parts, a pause of the run), and what a train loses with an effect."""

import numpy as np
import pytest

import gearblocks as gb

NEAR = 1e-9  # hundreds of steps at rtol 1e-12, the same equations in another order


def _two_meshes(order=range(9), flip=False, **gap):
    """motor - mesh - lay shaft - shaft - pinion - mesh - wheel, with all effects."""
    variation = gb.Fourier(cos=(0.2,), driven_by=gb.Parameter("mesh_frequency", 4000.0, "rad/s"))
    gap = {"backlash": gb.Backlash(half_gap=2e-5), **gap}
    shaft = gb.Shaft(k=3e4, damping_ratio=0.03)
    first = {"teeth": (20, 30), "r_base": (0.02, 0.03), "external": True, "k": 1e8, "damping_ratio": 0.05}
    second = {"teeth": (18, 54), "r_base": (0.018, 0.054), "external": True, "k": 1.5e8, "damping_ratio": 0.05}
    parts = [
        ("motor", gb.Inertia(J=1e-3)), ("first", gb.GearMesh(**first, stiffness_variation=variation, **gap)),
        ("lay", gb.Inertia(J=2e-3)), ("shaft", shaft), ("pinion", gb.Inertia(J=5e-4)),
        ("second", gb.GearMesh(**second, transmission_error=gb.Harmonic(cos=(5e-6,), driven_by=4000.0))),
        ("wheel", gb.Inertia(J=2e-2)), ("drive", gb.Torque(tau=30 + 20 * gb.sin(900 * gb.time))),
        ("load", gb.Torque(tau=-135.0)),
    ]  # fmt: skip
    rig = gb.Drivetrain("two meshes")
    h = {}
    for i in order:
        h[parts[i][0]] = rig.add(*parts[i])
    ends = ("b", "a") if flip else ("a", "b")
    rig.connect(h["drive"].flange, h["motor"].a)
    rig.connect(h["motor"].b, h["first"].pinion)
    rig.connect(h["first"].wheel, h["lay"].b if flip else h["lay"].a)
    rig.connect(h["lay"].a if flip else h["lay"].b, getattr(h["shaft"], ends[0]))
    rig.connect(getattr(h["shaft"], ends[1]), h["pinion"].a)
    rig.connect(h["pinion"].b, h["second"].pinion)
    rig.connect(h["second"].wheel, h["wheel"].a)
    rig.connect(h["wheel"].b, h["load"].flange)
    return rig


T = np.linspace(0, 5e-3, 101)


@pytest.mark.long
def test_the_order_of_parts_does_not_change_the_motion(distance):
    run = gb.simulate(_two_meshes(), t=T, rtol=1e-12)
    for order in ((8, 7, 6, 5, 4, 3, 2, 1, 0), (3, 1, 5, 0, 7, 2, 8, 6, 4)):
        other = gb.simulate(_two_meshes(order), t=T, rtol=1e-12)
        for name in ("motor.w", "first.force", "shaft.torque", "second.deflection"):
            assert distance(other[name], run[name]) < NEAR


@pytest.mark.long
def test_a_part_turned_round_gives_the_same_motion(distance):
    run, other = gb.simulate(_two_meshes(), t=T, rtol=1e-12), gb.simulate(_two_meshes(flip=True), t=T, rtol=1e-12)
    assert distance(other["wheel.w"], run["wheel.w"]) < NEAR
    assert distance(-other["shaft.twist"], run["shaft.twist"]) < NEAR


def test_a_train_without_compliance_is_rigid_and_known_in_closed_form():
    rig = _two_meshes().without("*.compliance")
    assert set(rig.dropped) == set(_two_meshes().effects())  # nothing lives on without compliance
    run = gb.simulate(rig, t=T, rtol=1e-12, watch=False)
    i, j = -30 / 20, -54 / 18
    J = 1e-3 + (2e-3 + 5e-4 + 2e-2 / j**2) / i**2
    alpha = (30 + 20 * np.sin(900 * T) + -135.0 / (i * j)) / J
    # torque balance: 30 N m times 4.5 are the load of 135 N m
    assert np.allclose(run["motor.alpha"], alpha, rtol=1e-12, atol=1e-9)
    assert np.allclose(run["wheel.alpha"], alpha / (i * j), rtol=1e-12, atol=1e-9)
    w = 20 * (1 - np.cos(900 * T)) / 900 / J
    assert np.allclose(run["motor.w"], w, rtol=1e-10, atol=1e-10 * w.max())
    assert np.allclose(run["first.force"], (30 + 20 * np.sin(900 * T) - 1e-3 * alpha) / 0.02, rtol=1e-11)
    lay = (2e-3 + 5e-4) * alpha / i
    assert np.allclose(run["second.force"] * 0.018, -run["first.force"] * 0.03 - lay, rtol=1e-10)


@pytest.mark.long
def test_the_spline_chain_without_compliance_is_one_body():
    rig = gb.Drivetrain("P1")
    discs = [rig.add(f"disc{i}", gb.Inertia(J=J)) for i, J in enumerate((5e-3, 2e-4, 2e-4, 1e-2))]
    left, right = rig.add("left", gb.Shaft(k=1e5, damping_ratio=0.05)), rig.add("right", gb.Shaft(k=1e5))
    spline = rig.add("spline", gb.SplineCoupling(teeth=20, radius=0.025, k=245e6, backlash=gb.Backlash(half_gap=2e-5)))
    drive, load = rig.add("drive", gb.Torque(tau=2600.0)), rig.add("load", gb.Torque(tau=-2000.0))
    rig.chain(drive, discs[0], left, discs[1], spline, discs[2], right, discs[3], load)
    run = gb.simulate(rig.without("*.compliance"), t=[0.0, 1.0], watch=False, rtol=1e-9)
    alpha = 600.0 / (5e-3 + 4e-4 + 1e-2)
    assert run["disc0.w"][1] == pytest.approx(alpha, rel=1e-13)
    assert run["spline.force"][0] == pytest.approx((2600 - 5.2e-3 * alpha) / 0.025, rel=1e-12)
    assert run["left.torque"][0] == pytest.approx(2600 - 5e-3 * alpha, rel=1e-12)


@pytest.mark.long
def test_an_effect_left_out_leaves_no_trace():
    rig = _two_meshes()
    full = gb.build(rig).program.source
    lean = rig.without("*.backlash")
    assert lean.dropped == ("first.backlash",)
    source = gb.build(lean).program.source
    text = str(lean.equations()) + lean.equations().latex()
    program = gb.build(lean).program
    for word in ("half_gap", "backlash"):
        assert word not in source
        assert word not in text
        assert not any(word in p.path for p in program.parameters)
    assert program.switches == ()
    assert len(source) < len(full)
    names = str(rig.equations())
    assert "half_gap" in names
    for effect, word in (
        ("*.transmission_error", "transmission"),
        ("*.damping", "damping"),
        ("*.stiffness_variation", "variation"),
    ):
        program = gb.build(rig.without(effect)).program
        assert not any(word in p.path for p in program.parameters)
        assert not any(word in line for line in program.source.splitlines())


def test_only_keeps_what_is_named_and_what_it_needs():
    rig = _two_meshes()
    assert set(rig.only("first.backlash").effects()) == {"first.backlash", "first.compliance"}
    assert set(rig.only("*.compliance").effects()) == {"first.compliance", "shaft.compliance", "second.compliance"}
    with pytest.raises(gb.ModelError, match="backlash"):
        rig.without("*.backlsh")
    assert set(rig.effects()) == set(_two_meshes().effects())  # the train itself is as before


@pytest.mark.long
def test_a_run_continued_from_an_earlier_one_is_one_run(distance):
    model = gb.build(_two_meshes())
    whole = gb.simulate(model, t=T, rtol=1e-12)
    first = gb.simulate(model, t=T[:51], rtol=1e-12)
    second = gb.simulate(model, t=T[51:], rtol=1e-12, initial=first)
    for name in ("motor.phi", "motor.w", "first.force", "second.deflection"):
        assert distance(np.concatenate([first[name], second[name]]), whole[name]) < NEAR
    assert second.energy.start == pytest.approx(first.energy.end, rel=1e-12)
    assert second.energy.residual < 1e-11
    other = gb.build(_two_meshes().without("*.backlash"))
    with pytest.raises(gb.ParameterError, match="another train"):
        gb.simulate(other, t_end=1.0, initial=first)


def test_taking_compliance_away_keeps_the_start_angle_of_the_first_body_only():
    rig = gb.Drivetrain("preloaded")
    rig.chain(
        rig.add("drive", gb.Torque(tau=3.0)), rig.add("a", gb.Inertia(J=1.0, phi0=0.5)), rig.add("shaft", gb.Shaft(k=10.0)),
        rig.add("b", gb.Inertia(J=2.0, phi0=0.2)),
    )  # fmt: skip
    rigid = rig.without("*.compliance")
    assert rigid.dropped == ("shaft.compliance", "b.phi0")
    run = gb.simulate(rigid, t=[0.0, 1.0])
    assert run["b.phi"][0] == 0.5
    assert run["b.alpha"][1] == pytest.approx(1.0, rel=1e-12)  # 3 N m on 3 kg m2


def test_part_of_a_train_can_lose_its_compliance_before_it_is_complete():
    part = gb.Drivetrain("part")
    shaft = part.add("shaft", gb.Shaft(k=10.0))
    part.expose("left", shaft.a)
    part.expose("right", shaft.b)
    assert part.without("*.compliance").dropped == ("shaft.compliance",)
