"""The transmission of non-circular gears with its selectors against runs from elsewhere (tests/data/cvt_*.json).

Those were computed with 20 digits from the equations of the branches (two methods agree to 6e-12); here the train is
composed of pairs, differentials, shafts and clutches or dogs. Modes there: 0 stuck, else the sign of the slip of the
branch over the output; ours count the output over the branch.
"""

import csv
import importlib.util
import json
import sys
from pathlib import Path

import numpy as np
import pytest

import gearblocks as gb

DATA = Path(__file__).parents[1] / "data"
FREE = 2


def _shipped():
    path = Path(__file__).parents[2] / "models" / "noncircular_cvt.py"
    spec = importlib.util.spec_from_file_location("noncircular_cvt_model", path)
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


cvt = _shipped()


def _json(name):
    return json.loads((DATA / f"{name}.json").read_text(encoding="utf8"))


def _branch_events(run):
    """(t, branch, before, after) of every change of a selector's mode, in the order of the run."""
    names = [f"selector_{j}" for j in range(3)]
    return [
        (e.t, names.index(e.component), e.before, e.after)
        for e in run.events
        if e.component in names and e.kind != "impact"
    ]


def _kind(before, after):
    if after == FREE:
        return "release"
    if before == FREE:
        return "engage"
    return "slip->stick" if after == 0 else "stick->slip" if before == 0 else "reversal"


@pytest.mark.parametrize(
    ("make", "data"),
    [
        pytest.param(cvt.build, "cvt_60_clutches", id="clutches", marks=pytest.mark.long),
        pytest.param(cvt.dogs, "cvt_120_dogs", id="dogs"),
    ],
)
def test_the_states_are_those_of_the_reference(make, data):
    true = _json(data)
    table = np.array(true["traj"])
    run = gb.simulate(make(), t=table[:, 0], rtol=1e-12)
    ours = [-run[f"shaft_{j}.twist"] for j in range(3)] + [run[f"branch_{j}.w"] for j in range(3)]
    ours += [run["output.w"], run["output.phi"]]
    for name, column, values in zip(true["state"], table[:, 1:9].T, ours, strict=True):
        # 1e-8 of the largest value, or of one rad and rad/s where that is less
        assert np.abs(values - column).max() < 1e-8 * max(1.0, np.abs(column).max()), name


@pytest.mark.long
def test_clutches_engage_stick_and_slip_when_those_of_the_reference_do():
    true = _json("cvt_60_clutches")["events"]
    run = gb.simulate(cvt.build(), t_end=0.1, rtol=1e-12)
    # the reference does not write down that a slipping clutch is let go
    ours = [e for e in _branch_events(run) if e[3] != FREE]
    assert [(_kind(before, after), j, -after) for _, j, before, after in ours] == [
        (kind, j, m) for _, kind, j, m in true
    ]
    assert np.abs(np.array([e[0] for e in ours]) - [e[0] for e in true]).max() < 1e-9


@pytest.mark.long
def test_dogs_change_over_with_the_impulses_of_the_reference():
    true = _json("cvt_120_dogs")["events"]
    run = gb.simulate(cvt.dogs(), t_end=0.1, rtol=1e-12)
    ours = [(t, "release" if after == FREE else "dog", j) for t, j, _, after in _branch_events(run)]
    ours.sort(key=lambda e: (round(e[0], 9), e[2]))  # those of one instant stand there in the order of the branches
    assert [(kind, j) for _, kind, j in ours] == [(kind.split()[0], j) for _, kind, j, _ in true]
    assert np.abs(np.array([e[0] for e in ours]) - [e[0] for e in true]).max() < 1e-9
    for t, kind, j, _ in true:
        if kind.startswith("dog"):
            impulse = float(kind.partition("impulse=")[2])
            after = run[f"selector_{j}.impulse"][np.flatnonzero(run.t <= t + 1e-9)[-1]]
            # the slip of 1.3 rad/s is a difference of speeds of 92 rad/s that are right to 1e-9
            assert abs(after) == pytest.approx(abs(impulse), rel=1e-7)


def _peaks(delta, strategy):
    """(where the reference looks: 501 instants and those just before events; on the motion itself) of the engaged shafts."""
    model = gb.build(cvt.selected(np.deg2rad(delta), strategy))
    run = gb.simulate(model, t_end=0.1, rtol=1e-11)
    before = np.array([e.t for e in run.events]) - 1e-10
    seen = gb.simulate(model, t=np.union1d(np.linspace(0, 0.1, 501), before[before > 0]), rtol=1e-11)
    return cvt.engaged_torque(seen).max(), cvt.engaged_torque(run).max()


@pytest.mark.parametrize(
    ("delta", "strategy", "data", "own"),
    [
        pytest.param(60, "blend", "cvt_60_clutches", 0.373445, marks=pytest.mark.long),
        pytest.param(120, "dog_end", "cvt_120_dogs", 0.386522, marks=pytest.mark.long),
    ],
)
def test_the_peaks_are_those_of_the_reference_at_its_samples(delta, strategy, data, own):
    seen, whole = _peaks(delta, strategy)
    assert seen == pytest.approx(float(_json(data)["peaks"]["shaft"]), abs=1e-6)
    assert whole == pytest.approx(own, abs=1e-4)  # what lies between the samples: at the accepted steps


@pytest.mark.long
@pytest.mark.parametrize(
    ("delta", "strategy", "printed"),
    [
        (60, "blend", 0.370), (60, "inst_mid", 0.380), (60, "inst_end", 0.380), (60, "inst_late", 0.765),
        (60, "dog_end", 0.380), (60, "dog_late", 0.765),
        (120, "inst_mid", 0.386), (120, "inst_end", 0.386), (120, "inst_late", 0.765), (120, "dog_end", 0.386),
        (120, "dog_late", 0.765),
    ],
)  # fmt: skip
def test_the_peaks_of_all_strategies_round_to_those_of_the_page(delta, strategy, printed):
    seen, _ = _peaks(delta, strategy)
    assert abs(seen - printed) <= 0.5e-3


def test_a_strategy_that_a_phase_leaves_no_room_for_is_refused():
    with pytest.raises(gb.ParameterError, match=r"'blend' at delta = 120 deg: the windows .* overlap by 0 deg"):
        cvt.selected(np.deg2rad(120))
    with pytest.raises(gb.ParameterError, match="overlap by -30 deg"):
        cvt.selected(np.deg2rad(150), "dog_end")
    with pytest.raises(gb.ParameterError, match="strategy = 'early' must be one of blend, inst_mid"):
        cvt.selected(np.deg2rad(60), "early")


def test_the_matching_of_branches_segments_and_phases_is_that_of_the_reference():
    true = _json("noncircular_matching")
    rad = np.deg2rad
    for n, row in true["zeta_X240"].items():
        for delta, zeta in row.items():
            found = cvt.matching(int(n), cvt.X, rad(float(delta)))
            assert found.zeta == pytest.approx(zeta, rel=1e-12)
            assert found.verdict == ("no buffer" if abs(zeta - 1) < 1e-9 else "gap" if zeta < 1 else "buffer")
    for n, row in true["X_min_deg"].items():
        for delta, least in row.items():
            assert np.rad2deg(cvt.matching(int(n), phase=rad(float(delta))).least) == pytest.approx(least, rel=1e-12)
    for n, row in true["delta_max_deg"].items():
        for segment, most in row.items():
            found = cvt.matching(int(n), rad(float(segment)))
            assert np.rad2deg(found.most) == pytest.approx(most, abs=1e-12 * 360)


def test_table_1_is_refused_and_norm_is_a_design():
    with pytest.raises(gb.RatioLawError, match=r"must stay > 0.*largest feasible X is 103\.53 deg"):
        cvt.design(0.7, 0.5)
    assert cvt.design().law == cvt.LAW and cvt.design().transition == pytest.approx(63.0, rel=1e-13)


@pytest.mark.long
def test_the_train_turns_its_branches_as_in_the_reference():
    """Speed of every branch behind its differential, over the input's, to 1e-12; and the ratio of the branch selected."""
    with (DATA / "noncircular_kin_NORM_d60.csv").open(encoding="utf8") as file:
        rows = list(csv.DictReader(file))
    table = {key: np.array([float(row[key]) for row in rows]) for key in rows[0]}
    delta, begin = np.pi / 3, (cvt.X - np.pi / 3) / 2
    later = table["theta"] > begin + 0.01
    run = gb.simulate(cvt.late(), t=(table["theta"][later] - begin) / cvt.SPEED, rtol=1e-10)
    for j in range(3):
        assert np.abs(cvt.branch_ratio(j, table["theta"], delta) - table[f"u{j}"]).max() < 1e-12
        ratio = run[f"differential_{j}.right.w"] / cvt.SPEED
        assert np.abs(ratio - table[f"u{j}"][later]).max() < 1e-12
    assert np.abs(table["u_sel"] - cvt.i_out(delta)).max() < 1e-12  # zeta = 1.5: even all the time


@pytest.mark.long
@pytest.mark.parametrize("strategy", ["inst_end", "dog_end"])
def test_geared_neutral_and_reverse_run_with_switched_selectors_too(strategy):
    still = gb.simulate(cvt.selected(0.0, strategy), t_end=0.05, rtol=1e-9)
    assert np.abs(still["output.phi"]).max() < 0.1 and still.complete
    if strategy == "dog_end":
        back = gb.simulate(cvt.selected(-np.pi / 3, strategy), t_end=0.05, rtol=1e-9)
        mean = back["output.phi"][-1] / 0.05 / cvt.SPEED
        assert mean == pytest.approx(cvt.i_out(-np.pi / 3), rel=0.05)  # ripple of shafts that wind up


@pytest.mark.long
def test_geared_neutral_holds_the_output_and_goes_on():
    run = gb.simulate(cvt.neutral(), t_end=0.1)
    before = run.t < 0.0019  # the first change-over begins at 2 ms
    # both pairs turn by the same law; what is left of their difference is rounding of 262 rad/s
    assert np.abs(run["output.w"][before]).max() < 1e-12
    assert np.abs(run["branch_0.w"][before]).max() < 1e-12
    # a branch gives by LOAD/K_SHAFT = 2 mrad where it takes over, in three change-overs a turn of the input
    takeovers = sum(after == 0 for _, _, _, after in _branch_events(run))
    assert takeovers >= 12
    assert np.abs(run["output.phi"]).max() < 0.1
