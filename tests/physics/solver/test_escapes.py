"""Motion that leaves every bound: unstable fixed steps, growth without end, records that fill up, energy from nowhere."""

import math
import warnings

import numpy as np
import pytest

import gearblocks as gb
from gearblocks.errors import GearblocksWarning
from gearblocks.simulation import run as running


def _chain(*parts):
    rig = gb.Drivetrain("escape")
    rig.chain(*(rig.add(name, block) for name, block in parts))
    return rig


def _pair(k=1e5, c=None, w0=1.0):
    return _chain(("a", gb.Inertia(J=1e-3, w0=w0)), ("s", gb.Shaft(k=k, c=c)), ("b", gb.Inertia(J=1e-3)))


def _fed(torque, **start):
    return _chain(("feed", gb.Torque(tau=torque)), ("rotor", gb.Inertia(J=1.0, **start)))


W, PHI = gb.sense("rotor.w"), gb.sense("rotor.phi")

# -- fixed steps: |R(z)| = 1 at z = 2.83 i and -2.785 (order 4), -3.31 (order 5), 5.96 i and -6.39 (order 8) ------------


@pytest.mark.parametrize(
    ("method", "damped", "limit"),
    [("rk4", False, 2.828), ("rk4", True, 2.785), ("dp5", True, 3.306), ("dp8", False, 5.96), ("dp8", True, 6.39)],
)
@pytest.mark.few(1)
def test_a_fixed_step_outside_the_stability_of_its_method_stops_the_run(method, damped, limit):
    """An undamped pair vibrates at sqrt(2 k/J); one that is all damping decays at 2 c/J."""
    model = gb.build(_pair(k=1e-3, c=2.0) if damped else _pair())
    rate = 4000.0 if damped else math.sqrt(2e8)
    with pytest.raises(gb.SimulationError, match=r"the fixed step = .* s is too long.*give a shorter step") as caught:
        gb.simulate(model, t_end=2000 / rate, method=method, step=1.04 * limit / rate)
    assert caught.value.component in ("a", "b", "s")
    largest = max(np.abs(caught.value.trajectory[f"{name}.w"]).max() for name in "ab")
    assert largest < 1e6  # it started at 1 rad/s
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", GearblocksWarning)  # far from right, but stable
        inside = gb.simulate(model, t_end=2000 / rate, method=method, step=0.96 * limit / rate)
    assert max(np.abs(inside[f"{name}.w"]).max() for name in "ab") <= 1.0 + 1e-9


@pytest.mark.long
def test_an_unstable_step_is_told_on_shafts_that_turn_fast_and_on_meshes_with_backlash():
    k, radius, inertia = 2e8, 0.025, 2e-4
    rig = _chain(
        ("drive", gb.Torque(tau=50.0)),
        ("a", gb.Inertia(J=inertia, w0=4e3)),
        (
            "mesh",
            gb.SplineCoupling(teeth=20, radius=radius, k=k, damping_ratio=0.02, backlash=gb.Backlash(half_gap=2e-5)),
        ),
        ("b", gb.Inertia(J=inertia, w0=4e3)),
        ("load", gb.Torque(tau=-50.0)),
    )
    rate = radius * math.sqrt(k * 2 / inertia)
    model = gb.build(rig)
    with pytest.raises(gb.SimulationError, match=r"the fixed step = .* s is too long"):
        gb.simulate(model, t_end=4000 / rate, method="rk4", step=3.8 / rate)
    assert gb.simulate(model, t_end=400 / rate, method="rk4", step=0.2 / rate).energy.residual < 1e-3


def test_short_fixed_steps_from_rest_are_left_alone():
    """Values that begin at exactly 0: the first errors are as large as the motion, and no sign of an unstable step."""
    rig = _fed(20 * (1 - gb.cos(10 * gb.time)))
    run = gb.simulate(rig, t_end=1.0, method="rk4", step=1e-3)
    assert run["rotor.w"][-1] == pytest.approx(20 * (1 - math.sin(10) / 10), rel=1e-9)


# -- growth -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("power", "method"), [(2, "auto"), (3, "rodas"), (2, "dp5")])
@pytest.mark.few(1)
def test_growth_to_infinity_in_finite_time_is_named_as_such(power, method):
    """w' = w^p from 1 is infinite at t = 1/(p - 1)."""
    with pytest.raises(
        gb.SimulationError, match=r"'rotor': the motion grows without bound.*look for what feeds it"
    ) as caught:
        gb.simulate(_fed(W**power, w0=1.0), t_end=3.0, method=method)
    assert caught.value.time == pytest.approx(1 / (power - 1), rel=1e-5)


def test_what_becomes_quicker_as_it_grows_stops_where_no_machine_is_so_fast():
    """J w' = D w - k phi^3: the further it swings the quicker, twice as many steps every 0.1 s; not where the end is near."""
    model = gb.build(_fed(20 * W - PHI**3, w0=1.0))
    with pytest.raises(gb.SimulationError, match=r"'rotor': the motion grows without bound") as caught:
        gb.simulate(model, t=np.linspace(0, 4.0, 41))
    assert np.abs(caught.value.trajectory["rotor.w"]).max() > 1e9
    assert caught.value.time == pytest.approx(1.8, abs=0.2)
    assert np.abs(gb.simulate(model, t=np.linspace(0, 2.0, 2001))["rotor.w"]).max() > 1e12  # samples of all phases


@pytest.mark.long
@pytest.mark.parametrize("feed", ["speed", "angle", "resonance"])
@pytest.mark.few(1)
def test_growth_without_end_stops_before_numbers_do(feed):
    torque = {"speed": 5 * W, "angle": 25 * PHI, "resonance": -PHI * (1 + 0.5 * gb.cos(2 * gb.time))}[feed]
    with pytest.raises(gb.SimulationError, match=r"'rotor': the motion grows without bound") as caught:
        gb.simulate(_fed(torque, phi0=1e-3, w0=1e-3), t_end=1e4)
    assert 1e90 < np.abs(caught.value.trajectory["rotor.w"]).max() < 1e110


@pytest.mark.long
def test_what_grows_far_but_ends_or_grows_as_a_power_of_time_runs_to_its_end():
    run = gb.simulate(_fed(5 * W, w0=1e-16), t_end=10.0)  # an unstable rest, left by rounding: 73 doublings
    assert run["rotor.w"][-1] == pytest.approx(1e-16 * math.exp(50), rel=1e-4)
    fall = gb.simulate(_chain(("feed", gb.Torque(tau=1e3)), ("rotor", gb.Inertia(J=1e-6))), t_end=1e9)
    assert fall["rotor.w"][-1] == pytest.approx(1e18, rel=1e-9)


# -- progress ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("torque", "method", "counted"),
    [
        (-1e20 * W, "dp8", r"6\d{4}"),  # steps when the pace is looked at first
        (-1e20 * W, "dp5", r"6\d{4}"),
        (1e10 * gb.sin(1e20 * W), "dp5", "400"),  # it moves to the next zero of the sine; many tries are refused
    ],
)
@pytest.mark.few(1)
def test_steps_that_do_not_bring_the_run_on_end_it_by_name(torque, method, counted):
    """Rest 1e-20 s after the start, on the way to which no step of an explicit method may be longer: 1e21 of them."""
    model = gb.build(_fed(torque, w0=1.0))
    with pytest.raises(
        gb.SimulationError,
        match=rf"'rotor': {counted} steps or tries in a row hardly bring the run on.*'rodas' goes on",
    ) as caught:
        gb.simulate(model, t=[0.0, 10.0], method=method)
    assert caught.value.time < 1e-10
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", GearblocksWarning)  # of the sine, steps of 1e-20 s are worth nothing
        assert abs(gb.simulate(model, t=[0.0, 10.0], method="rodas")["rotor.w"][-1]) <= 1.0


@pytest.mark.parametrize("start", [-2.0, 3.0])
def test_many_steps_are_no_stall_wherever_the_time_begins(start):
    """70,000 steps, which are looked at once, from a time that is not 0."""
    run = gb.simulate(_pair(k=1e9), t_start=start, t=[start, start + 1e-3], method="dp5", rtol=1e-9)
    assert run.stats.steps > 65600 and run["a.w"][-1] + run["b.w"][-1] == pytest.approx(1.0, rel=1e-9)


@pytest.mark.long
def test_a_condition_that_no_step_is_short_enough_to_tell_ends_the_run_by_name():
    """sin cos <= 1/2, which an enclosure of both does not know where each step spans many of their cycles."""
    q = 1e24 * PHI
    model = gb.build(_fed(gb.piecewise((5.0, gb.sin(q) * gb.cos(q) > 0.6), (1.0, True)), w0=1.0))
    with pytest.raises(
        gb.SimulationError, match=r"'feed': 400 steps or tries in a row hardly bring the run on.*looser rtol"
    ):
        gb.simulate(model, t_end=10.0, method="dp8")


def test_a_record_of_steps_without_end_stops_at_its_room(monkeypatch):
    monkeypatch.setattr(running, "memory_limit", lambda _: 1 << 23)
    rig = _pair()
    with pytest.raises(
        gb.SimulationError, match=r"the record of \d+ steps .* fills the memory .* give times t"
    ) as caught:
        gb.simulate(rig, t_end=100.0)
    assert len(caught.value.trajectory.t) > 100
    assert len(gb.simulate(rig, t=np.linspace(0, 0.05, 5)).t) == 5


# -- the ledger as a warning -------------------------------------------------------------------------------------------


def test_a_finished_run_whose_energy_does_not_balance_warns_by_name():
    model = gb.build(_pair())
    with pytest.warns(GearblocksWarning, match=r"run of 'escape': its energy is balanced to 0\.\d+ .*a shorter step"):
        gb.simulate(model, t_end=0.02, method="rk4", step=2.0 / math.sqrt(2e8))
    assert gb.simulate(model, t_end=0.02, method="rk4", step=0.02 / math.sqrt(2e8)).energy.residual < 1e-6


# -- stiffness below zero -----------------------------------------------------------------------------------------------

_SAW = gb.Table([0.0, 0.25, 0.75, 1.0], [0.0, 0.5, -1.2, 0.0], periodic=True)


@pytest.mark.parametrize(
    ("variation", "least"),
    [
        (gb.Fourier(cos=(1.05,)), -0.05),
        (gb.Fourier(cos=(0.5, 1.4)), -0.422321),  # 1 + a cos + b cos 2: least 1 - b - a^2/(8 b) at cos = -a/(4 b)
        (gb.Fourier(sin=(gb.Parameter("depth", 1.5),)), -0.5),
        (gb.Square(ripple=0.9, contact_ratio=1.7, driven_by=100.0), -0.26),
        (_SAW, -0.2),
    ],
    ids=["cosine", "two orders", "Parameter", "square", "table"],
)
def test_a_stiffness_below_zero_in_part_of_its_cycle_is_refused(variation, least):
    for block in (
        gb.SplineCoupling(teeth=20, radius=0.02, k=1e8, stiffness_variation=variation),
        gb.GearMesh(teeth=(20, 31), external=True, r_base=(0.02, 0.031), k=1e8, stiffness_variation=variation),
    ):
        with pytest.raises(gb.ModelError, match=r"the stiffness is .* times k, below 0") as caught:
            gb.Drivetrain("x").add("mesh", block)
        assert float(str(caught.value).split("is ")[1].split(" times")[0]) == pytest.approx(least, abs=6e-4)


@pytest.mark.parametrize("cos", [(1.0,), (0.7, 0.6), (0.9, 0.3, 0.1)])
def test_a_stiffness_that_stays_above_zero_is_taken_whatever_the_sum_of_its_amplitudes(cos):
    theta = np.linspace(0, 2 * np.pi, 100_001)
    least = sum(a * np.cos(j * theta) for j, a in enumerate(cos, 1)).min()
    assert least >= -1
    assert gb.Fourier(cos=cos).least() == pytest.approx(least, abs=1e-8)
    gb.Drivetrain("x").add(
        "mesh", gb.SplineCoupling(teeth=20, radius=0.02, k=1e8, stiffness_variation=gb.Fourier(cos=cos))
    )


# -- what ends the program, ends it ------------------------------------------------------------------------------------


@pytest.mark.parametrize("initial", [None, "static"])
@pytest.mark.parametrize("end", [KeyboardInterrupt, SystemExit])
def test_an_input_function_that_ends_the_program_at_its_first_call_ends_it(end, initial):
    def source(t):
        raise end

    rig = _chain(
        ("drive", gb.Torque(tau=gb.Input("u"))),
        ("a", gb.Inertia(J=1.0)),
        ("s", gb.Shaft(k=1e3, c=1.0)),
        ("g", gb.Fixed()),
    )
    with pytest.raises(end):
        gb.simulate(rig, t_end=1.0, inputs={"u": source}, initial=initial)


@pytest.mark.long
@pytest.mark.parametrize("sampled", [True, False])
@pytest.mark.parametrize("end", [SystemExit, GeneratorExit])
def test_an_input_function_that_ends_the_program_later_ends_it_then(end, sampled):
    """Ctrl-C alone keeps what there is of the run."""

    def source(t):
        if t > 0.5:
            raise end
        return 1.0

    rig = _chain(("drive", gb.Torque(tau=gb.Input("u"))), ("a", gb.Inertia(J=1.0)))
    how = {"t": [0.0, 0.2, 1.0]} if sampled else {"t_end": 1.0}
    with pytest.raises(end):
        gb.simulate(rig, inputs={"u": source}, **how)


_IN_A_GAP = {
    "lash": lambda **more: gb.Lash(half_gap=0.02, k=1e3, c=2.0, **more),
    "spline": lambda **more: gb.SplineCoupling(
        teeth=20, radius=0.5, k=4e3, c=8.0, backlash=gb.Backlash(half_gap=0.01), **more
    ),
    "mesh": lambda **more: gb.GearMesh(
        teeth=(20, 30), external=True, r_base=(0.5, 0.75), k=4e3, c=8.0, backlash=gb.Backlash(half_gap=0.01), **more
    ),
}


@pytest.mark.long
@pytest.mark.parametrize("name", _IN_A_GAP)
def test_a_shaft_without_inertia_that_one_mode_leaves_undamped_says_what_damps_it(name):
    def rig(**more):
        return _chain(
            ("drive", gb.Torque(tau=3 * gb.sin(5 * gb.time))),
            ("a", gb.Inertia(J=1.0)),
            ("s", gb.Shaft(k=100.0)),
            ("node", gb.Inertia(J=0.0)),
            ("teeth", _IN_A_GAP[name](**more)),
            ("b", gb.Inertia(J=1.0)),
        )

    with pytest.raises(gb.SimulationError, match=r"node\.J = 0.*damps it, in every mode.*contact_damping='always'"):
        gb.simulate(rig(), t_end=2.0)
    assert gb.simulate(rig(contact_damping="always"), t_end=2.0).energy.residual < 1e-6


@pytest.mark.parametrize(
    ("tau", "became"),
    [
        (1 / gb.time, "infinite at t = 0 s"),
        (gb.sqrt(0.3 - gb.time), "NaN at t = 0.3 s"),
        (gb.sqrt(2 - gb.sense("rotor.w")), "NaN at t = "),
    ],
)
@pytest.mark.parametrize("held", [False, True])
def test_a_law_without_a_finite_number_is_named_by_its_own_part_and_not_by_the_body_that_it_moves(tau, became, held):
    rig = _chain(("push", gb.Torque(tau=5 + tau)), ("rotor", gb.Inertia(J=1.0)))
    if held:
        rig.connect(rig.add("brake", gb.Brake(capacity=1.0)).a, rig["rotor"].b)
    with pytest.raises(gb.SimulationError, match=rf"'push': its torque on the flange \(push\.torque\) became {became}"):
        gb.simulate(rig, t_end=1.0)
    study = gb.sweep(rig, {"rotor.J": [0.5, 1.0]}, quantity=gb.last("rotor.w"), t_end=1.0)
    assert all(x.message.count("push.torque") == 1 for x in study.failures) and len(study.failures) == 2
