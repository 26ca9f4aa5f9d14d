"""Contacts that remember the speed at which they started."""

import numpy as np
import pytest

import gearblocks as gb
from gearblocks.geometry.restitution import restitution_damping
from gearblocks.train.handles import FlangeHandle

TIGHT = {"rtol": 1e-11}
B, K, W = 0.1, 400.0, 4.0


def _ball(restitution=0.5, gap=None, **body):
    """J = 1 between two springy walls at +-0.1."""
    rig = gb.Drivetrain("ball")
    gap = gap or gb.Backlash(half_gap=B)
    spline = gb.SplineCoupling(
        teeth=3, radius=1.0, k=K, backlash=gap, contact_damping=gb.HuntCrossley(restitution=restitution)
    )
    ball = rig.add("ball", gb.Inertia(J=1.0, **{"w0": W, **body}))
    rig.chain(ball, rig.add("wall", spline), rig.add("ground", gb.Fixed()))
    return rig


def _leaving(contact):
    """Rows at which a contact has just ended."""
    return [i for i in range(1, len(contact)) if contact[i] == 0 and contact[i - 1] != 0]


@pytest.mark.parametrize("e", [0.9999, 0.99, 0.9, 0.5, 0.2])
@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.few(3)
def test_a_body_is_thrown_back_with_the_restitution_times_its_speed_again_and_again(e, sign):
    run = gb.simulate(_ball(e), t_end=0.7, initial={"ball.w": sign * W}, **TIGHT)
    left = _leaving(run["wall.contact"])
    assert len(left) >= 2 or e == 0.2
    # the exact condition on chi, solved to 1e-8 where e is next to 1
    assert np.abs(run["ball.w"][left]) == pytest.approx([W * e ** (i + 1) for i in range(len(left))], rel=1e-8)
    assert run.energy.residual < 1e-10  # 10 rtol
    assert run.energy.supplied == {}


def test_the_damping_of_a_restitution_meets_its_condition_in_python_and_in_c():
    for e in (1.0, 1 - 1e-5, 0.99, 0.7, 0.3, 0.05):
        a = restitution_damping(e)
        # e = 0.05: 1 - e a = 2e-8 loses half of the digits; next to 1 the condition is a small difference of logarithms
        assert a * (1 + e) == pytest.approx(np.log1p(a) - np.log1p(-e * a), rel=1e-8, abs=1e-13)
    assert restitution_damping(0.9999) == pytest.approx(1.5e-4, rel=1e-3)  # 3 (1 - e)/2
    assert restitution_damping(1 - 0.99e-4) == pytest.approx(restitution_damping(1 - 1.01e-4) * 0.99 / 1.01, rel=1e-5)
    for e in (0.0, -1.0, 1.1, np.nan):
        assert np.isnan(restitution_damping(e))
    model = gb.build(_ball())
    for e in (1.0, 0.99995, 0.9, 0.4):
        run = gb.simulate(model, t=[0.05], parameters={"wall.contact_damping.restitution": e}, initial={
            "ball.phi": 0.2, "wall.contact_damping.slowness": 1 / W
        })  # fmt: skip
        x, v = run["wall.deflection"][0], run["ball.w"][0]
        assert run["wall.force"][0] == pytest.approx(K * (x - B) * (1 + restitution_damping(e) * v / W), rel=1e-12)


@pytest.mark.long
def test_a_motion_with_impacts_and_a_load_is_that_of_an_independent_integration(reference, distance):
    e = 0.6
    rig = _ball(e)
    drive = rig.add("drive", gb.Torque(tau=9.0 * gb.sin(11.0 * gb.time)))
    rig.connect(drive.flange, FlangeHandle(rig, "ball", "b"))
    t = np.linspace(0, 2, 201)
    run = gb.simulate(rig, t=t, **TIGHT)
    a = restitution_damping(e)
    starts = [ev for ev in run.events if ev.component == "wall" and ev.after != 0]
    assert len(starts) > 3
    # by hand, from one start of contact to the next, with the speed there
    rows, at, y = [], 0.0, np.array([0.0, W])
    edges = [ev.t for ev in run.events if ev.component == "wall"] + [2.0]
    side, slow = 0.0, 0.0
    for event, edge in zip([*(ev for ev in run.events if ev.component == "wall"), None], edges, strict=True):
        inside = np.unique(np.concatenate([[at], t[(t >= at) & (t < edge)], [edge]]))

        def rates(time, z, _, side=side, slow=slow):
            push = max(1 + a * slow * side * z[1], 0.0)
            return z[1], 9.0 * np.sin(11.0 * time) - K * (z[0] - side * B) * push * side**2

        piece = reference(rates, y, inside, max_step=1e-3)
        rows += [(time, *row) for time, row in zip(inside, piece, strict=True) if np.any(t == time)]
        at, y = edge, piece[-1]
        if event is not None:
            assert abs(abs(y[0]) - B) < 1e-8  # located where the independent motion meets the wall
            side = event.after
            slow = 1 / abs(y[1]) if side else slow
    rows = np.array(rows)
    _, first = np.unique(rows[:, 0], return_index=True)
    # a clipped force bends inside a step of 1e-3 of the independent integration
    assert distance(run["ball.phi"], rows[first, 1]) < 1e-7


@pytest.mark.long
def test_gears_that_rattle_lose_speed_by_the_restitution():
    """The relative speed along the line of action of two free gears is turned round by -e."""
    e = 0.7
    rig = gb.Drivetrain("rattle")
    one, two = rig.add("one", gb.Inertia(J=2e-4, w0=5.0)), rig.add("two", gb.Inertia(J=1e-3))
    mesh = gb.GearMesh(
        teeth=(20, 40), external=True, r_base=(0.02, 0.04), k=1e8, backlash=gb.Backlash(half_gap=2e-5),
        contact_damping=gb.HuntCrossley(restitution=e),
    )  # fmt: skip
    rig.chain(one, rig.add("mesh", mesh), two)
    run = gb.simulate(rig, t_end=2e-3, **TIGHT)
    left = _leaving(run["mesh.contact"])[0]
    rate = run["mesh.deflection_rate"]
    assert rate[0] == pytest.approx(0.1)
    assert rate[left] / rate[0] == pytest.approx(-e, rel=1e-8)
    assert np.all(run["mesh.force"] * np.sign(run["mesh.deflection"]) >= 0)
    assert run.energy.supplied == {}
    momentum = run["one.w"] * 2e-4 / 0.02 - run["two.w"] * 1e-3 / 0.04
    assert np.ptp(momentum) < 1e-12 * np.abs(momentum).max() * 100


def test_a_contact_at_the_start_is_without_damping_until_the_teeth_have_parted():
    run = gb.simulate(_ball(0.5, phi0=0.15, w0=0.0), t_end=1.0, **TIGHT)
    first = next(i for i, c in enumerate(run["wall.contact"]) if c == 0)
    assert abs(run["ball.w"][first]) == pytest.approx(np.sqrt(K) * 0.05, rel=1e-9)
    assert run.energy.dissipated["wall"] > 0


def test_the_dwell_is_the_same_without_location_as_the_step_shrinks():
    ends = [gb.simulate(_ball(0.8), t_end=0.6, method="rk4", step=h, locate=False)["ball.w"][-1] for h in (1e-4, 1e-5)]
    true = gb.simulate(_ball(0.8), t_end=0.6, **TIGHT)["ball.w"][-1]
    assert abs(ends[1] - true) < 0.3 * abs(ends[0] - true) + 1e-6  # corners missed by up to a step: first order


def test_a_run_continues_with_the_speed_that_its_contact_holds():
    model = gb.build(_ball(0.6))
    whole = gb.simulate(model, t=[0.1, 0.4], **TIGHT)
    first = gb.simulate(model, t=[0.1], **TIGHT)
    assert first["wall.contact"][-1] == 1.0
    rest = gb.simulate(model, t=[0.4], initial=first, **TIGHT)
    assert rest["ball.w"][-1] == pytest.approx(whole["ball.w"][-1], rel=1e-9)


def test_a_user_can_hold_a_value_of_the_instant_at_which_a_condition_begins():
    class Peak(gb.Block):
        """Remembers the speed at which the angle last rose through 0.2."""

        flange = gb.Flange("watched shaft")
        seen = gb.State("speed at the last passage", "rad/s", start=-1.0)

        def physics(self, s):
            import sympy as sp

            beyond = sp.Heaviside(s.flange.phi - 0.2, 1)
            yield gb.Hold(s.seen, s.flange.w + s.time, beyond)
            yield gb.Acts(s.flange, -3 * beyond)
            yield gb.Shows("seen", s.seen)

    rig = gb.Drivetrain("held")
    body, spring, ground = (
        rig.add("body", gb.Inertia(J=1.0, w0=2.0)),
        rig.add("spring", gb.Shaft(k=9.0)),
        rig.add("g", gb.Fixed()),
    )
    rig.chain(body, spring, ground)
    rig.connect(rig.add("peak", Peak()).flange, body.b)
    run = gb.simulate(rig, t_end=3.0, **TIGHT)
    rises = [ev for ev in run.events if ev.after == 1.0]
    assert len(rises) == 2
    assert run["peak.seen"][0] == -1.0
    for event in rises:
        after = np.flatnonzero(run.t == event.t)[-1]
        assert run["peak.seen"][after] == pytest.approx(run["body.w"][after] + event.t, rel=1e-12)
    assert "seen_peak = " in str(rig.equations())


def test_a_condition_that_nothing_else_reads_sets_a_state_too():
    class Samples(gb.Block):
        """x -> 3.2 x (1 - x) as each second begins, and how often."""

        x = gb.State("sample", start=0.3)
        count = gb.State("samples")

        def physics(self, s):
            begun = gb.sin(2 * np.pi * (s.time - 0.25)) >= 0
            on = gb.piecewise((1, begun), (0, True))
            yield gb.Hold(s.x, 3.2 * s.x * (1 - s.x), on)
            yield gb.Hold(s.count, s.count + 1, on)
            yield gb.Shows("x", s.x)
            yield gb.Shows("count", s.count)

    rig = gb.Drivetrain("sampled")
    rig.add("samples", Samples())
    rig.chain(rig.add("body", gb.Inertia(J=1.0)), rig.add("spring", gb.Shaft(k=9.0)), rig.add("g", gb.Fixed()))
    run = gb.simulate(rig, t=np.arange(9.0))
    x = [0.3]
    for _ in range(8):
        x.append(3.2 * x[-1] * (1 - x[-1]))
    assert run["samples.count"] == pytest.approx(np.arange(9))
    assert run["samples.x"] == pytest.approx(x, rel=1e-14)


@pytest.mark.parametrize(("fields", "words"), [
    ({"contact_damping": gb.HuntCrossley(restitution=0.0)}, "contact_damping.restitution = 0.0 must be > 0"),
    ({"contact_damping": gb.HuntCrossley(restitution=1.5)}, "restitution = 1.5 must be <= 1"),
    ({"c": 3.0}, "takes the place of c"),
    ({"backlash": None}, "needs a contact that starts"),
    ({"backlash": gb.Backlash(half_gap=B, law="smooth", width=B)}, "needs a contact that starts"),
    ({"contact_damping": gb.Fourier(cos=(0.1,))}, "must be 'clipped', 'clipped_force', 'always' or gb.HuntCrossley"),
])  # fmt: skip
def test_an_impact_law_that_cannot_be_is_refused_with_the_reason(fields, words):
    fields = {"backlash": gb.Backlash(half_gap=B), "contact_damping": gb.HuntCrossley(restitution=0.5), **fields}
    with pytest.raises(gb.ModelError) as caught:
        gb.Drivetrain("x").add("wall", gb.SplineCoupling(teeth=3, radius=1.0, k=K, **fields))
    assert words in str(caught.value), str(caught.value)


@pytest.mark.long
def test_an_impact_law_is_a_damping_that_can_be_taken_away_and_survives_a_file(tmp_path):
    rig = _ball()
    assert "wall.damping" in rig.effects()
    bare = rig.without("*.damping")
    assert bare["wall"].contact_damping == "clipped"
    assert "wall.damping" not in bare.effects()
    rig.to_json(tmp_path / "rig.json")
    assert gb.Drivetrain.from_json(tmp_path / "rig.json")["wall"] == rig["wall"]
    lash = gb.Lash(k=K, half_gap=B, contact_damping=gb.HuntCrossley(restitution=0.5))
    shaft = gb.Drivetrain("lash")
    shaft.chain(shaft.add("ball", gb.Inertia(J=1.0, w0=-W)), shaft.add("lash", lash), shaft.add("ground", gb.Fixed()))
    run = gb.simulate(shaft, t_end=0.3, **TIGHT)
    assert run["ball.w"][_leaving(run["lash.contact"])[0]] == pytest.approx(W / 2, rel=1e-8)


@pytest.mark.long
def test_teeth_with_their_own_gaps_take_impacts_too():
    run = gb.simulate(_ball(0.5, gap=gb.Backlash(gaps=(0.1, 0.12, 0.14))), t_end=0.35, **TIGHT)
    # the condition on chi holds for every rising force law: the first contact tells the speed
    assert run["ball.w"][_leaving(run["wall.contact"])[0]] == pytest.approx(-W / 2, rel=1e-8)


@pytest.mark.parametrize("method", ["dp8", "rodas"])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_contact_that_begins_at_the_start_knows_its_speed(sign, method):
    run = gb.simulate(_ball(0.5, phi0=sign * B), t_end=0.25, initial={"ball.w": sign * W}, method=method, rtol=1e-10)
    left = _leaving(run["wall.contact"])[0]
    assert run["ball.w"][left] == pytest.approx(-0.5 * sign * W, rel=1e-8)


@pytest.mark.parametrize("phi0", [0.0, -0.02])
def test_a_contact_without_a_gap_takes_its_speed_at_every_change_of_side(phi0):
    run = gb.simulate(_ball(0.5, gb.Backlash(half_gap=0.0), phi0=phi0), t_end=0.8, **TIGHT)
    passes = [ev.t for ev in run.events if ev.component == "wall" and ev.t > 0.0]
    speeds = [abs(run["ball.w"][np.flatnonzero(run.t == t)[-1]]) for t in passes]
    assert len(speeds) >= 4
    first = 1 if phi0 else 0  # a contact that exists at the start has no speed to remember
    assert np.divide(speeds[first + 1 :], speeds[first:-1]) == pytest.approx(0.5, rel=1e-8)
    assert speeds[0] == pytest.approx(np.sqrt(W**2 + K * phi0**2) if phi0 else 0.5 * W, rel=1e-8)


@pytest.mark.long
def test_a_lash_that_stands_on_its_corner_and_leaves_it_holds_nothing():
    rig = gb.Drivetrain("lash")
    body, lash = (
        rig.add("body", gb.Inertia(J=1.0, w0=-1.0, phi0=0.1)),
        rig.add("lash", gb.Lash(k=100.0, half_gap=0.1, contact_damping=gb.HuntCrossley(restitution=0.5))),
    )
    rig.chain(rig.add("ground", gb.Fixed()), lash, body)
    run = gb.simulate(rig, t_end=0.6, rtol=1e-10)
    assert run["body.w"][run["body.phi"] > -0.1 + 1e-9][-1] == pytest.approx(0.5, rel=1e-8)
    assert run["lash.loss_power"][0] == 0.0


@pytest.mark.parametrize(
    ("sign", "pull"),
    [
        pytest.param(1.0, 300.0, marks=pytest.mark.long),
        (1.0, 800.0),
        (-1.0, 300.0),
        pytest.param(-1.0, 800.0, marks=pytest.mark.long),
    ],
)
@pytest.mark.few(1)
def test_a_contact_that_is_torn_open_never_pulls(pull, sign, reference, distance):
    """From the moment where damping would outweigh the spring the body is free, though it still lies in the contact."""
    e, start = 0.5, B / W  # the moment of contact
    rig, yank = _ball(e, w0=sign * W), start + 0.03
    rig.connect(
        rig.add("drive", gb.Torque(tau=gb.piecewise((0, gb.time < yank), (-sign * pull, True)))).flange,
        FlangeHandle(rig, "ball", "a"),
    )
    t = np.linspace(0, yank + 0.02, 101)
    run, chi = gb.simulate(rig, t=t, **TIGHT), restitution_damping(e) / W

    def force(y):
        return K * (y[0] - B) * (1 + chi * y[1])

    def rates(time, y, modes):
        touches, pushes, pulled = modes
        return y[1], -(force(y) if touches > 0 and pushes > 0 else 0.0) - (pull if pulled > 0 else 0.0)

    true = reference(rates, (0.0, W), t, lambda time, y: (y[0] - B, 1 + chi * y[1], time - yank))
    inside = true[:, 0] > B
    assert ((1 + chi * true[:, 1])[inside] < 0).any()
    assert (sign * run["wall.force"] >= 0).all()
    assert distance(sign * run["ball.w"], true[:, 1]) < 1e-8
    assert run.energy.residual < 1e-9
