"""Compliant elements that close loops: deflections that follow from others, against full coordinates."""

import numpy as np
import pytest

import gearblocks as gb

NEAR = 1e-8  # hundreds of steps at rtol 1e-12


@pytest.mark.long
def test_three_inertias_in_a_triangle_of_springs(reference, distance):
    J, k, c, b = (1.0, 2.0, 3.0), (100.0, 150.0, 220.0), 0.4, 0.05
    rig = gb.Drivetrain("triangle")
    a, m, z = (rig.add(n, gb.Inertia(J=j)) for n, j in zip("amz", J, strict=True))
    one, two = rig.add("one", gb.Shaft(k=k[0])), rig.add("two", gb.Shaft(k=k[1], c=c))
    lash = rig.add("lash", gb.Lash(k=k[2], half_gap=b))
    drive = rig.add("drive", gb.Torque(tau=3 * gb.cos(5 * gb.time)))
    rig.chain(drive, a, one, m, two, z)
    rig.connect(lash.a, z.a)
    rig.connect(lash.b, a.a)
    t = np.linspace(0, 5, 201)
    run = gb.simulate(rig, t=t, initial={"m.phi": 0.3, "z.w": -1.0}, rtol=1e-12)

    def rates(t, y, modes):
        p, w = y[:3], y[3:]
        t1, t2 = k[0] * (p[1] - p[0]), k[1] * (p[2] - p[1]) + c * (w[2] - w[1])
        x = p[0] - p[2]
        t3 = k[2] * (x - b if modes[0] > 0 else x + b if modes[1] < 0 else 0.0)
        return [*w, (3 * np.cos(5 * t) + t1 - t3) / J[0], (t2 - t1) / J[1], (t3 - t2) / J[2]]

    true = reference(rates, (0, 0.3, 0, 0, 0, -1.0), t, lambda t, y: (y[0] - y[2] - b, y[0] - y[2] + b), max_step=0.02)
    assert set(np.unique(run["lash.contact"])) == {-1.0, 0.0, 1.0}
    for i, name in enumerate("amz"):
        assert distance(run[f"{name}.phi"], true[:, i]) < NEAR
        assert distance(run[f"{name}.w"], true[:, 3 + i]) < NEAR
    assert run.energy.residual < 1e-11


@pytest.mark.long
def test_two_meshes_share_the_load_between_the_same_shafts(reference, distance):
    """A split path: motor to wheel by a mesh, and by a lay shaft with two meshes whose ratios agree (or nearly do)."""
    J, k = (1e-3, 2e-3, 8e-3), (1e7, 2e7, 1.5e7)
    r = ((0.02, 0.04), (0.02, 0.03), (0.03, 0.04))
    rig = gb.Drivetrain("split")
    motor, lay, wheel = (rig.add(n, gb.Inertia(J=j)) for n, j in zip(("motor", "lay", "wheel"), J, strict=True))
    meshes = [
        rig.add("direct", gb.GearMesh(teeth=(20, 40), r_base=r[0], external=True, k=k[0], c=50.0)),
        rig.add("to_lay", gb.GearMesh(teeth=(20, 30), r_base=r[1], external=True, k=k[1])),
        rig.add(
            "from_lay",
            gb.GearMesh(teeth=(30, 40), r_base=r[2], external=False, k=k[2], backlash=gb.Backlash(half_gap=1e-5)),
        ),
    ]
    rig.connect(motor.a, meshes[0].pinion, meshes[1].pinion)
    rig.connect(lay.a, meshes[1].wheel, meshes[2].pinion)
    rig.connect(wheel.a, meshes[0].wheel, meshes[2].wheel)
    drive = rig.add("drive", gb.Torque(tau=40.0))
    rig.connect(drive.flange, motor.b)
    load = rig.add("load", gb.Torque(tau=80.0))
    rig.connect(load.flange, wheel.b)
    t = np.linspace(0, 0.01, 201)
    run = gb.simulate(rig, t=t, rtol=1e-12)

    def rates(t, y, modes):
        p, w = y[:3], y[3:]
        n0 = k[0] * (0.02 * p[0] + 0.04 * p[2]) + 50.0 * (0.02 * w[0] + 0.04 * w[2])
        n1 = k[1] * (0.02 * p[0] + 0.03 * p[1])
        x = 0.03 * p[1] - 0.04 * p[2]
        n2 = k[2] * (x - 1e-5 if modes[0] > 0 else x + 1e-5 if modes[1] < 0 else 0.0)
        torques = (40 - 0.02 * (n0 + n1), -0.03 * n1 - 0.03 * n2, 80 - 0.04 * n0 + 0.04 * n2)
        return [*w, *(tau / j for tau, j in zip(torques, J, strict=True))]

    def surfaces(t, y):
        x = (0.03 * y[1] - 0.04 * y[2]) / 1e-5
        return x - 1, x + 1

    true = reference(rates, np.zeros(6), t, surfaces, max_step=5e-5)
    for i, name in enumerate(("motor", "lay", "wheel")):
        assert distance(run[f"{name}.w"], true[:, 3 + i]) < NEAR
    assert run.energy.residual < 1e-11


@pytest.mark.long
def test_springs_in_parallel_add_their_stiffness(distance):
    rig = gb.Drivetrain("parallel")
    a, b = rig.add("a", gb.Inertia(J=2.0, phi0=0.1)), rig.add("b", gb.Inertia(J=2.0))
    for n, k in enumerate((30.0, 50.0, 20.0)):
        spring = rig.add(f"spring{n}", gb.Shaft(k=k))
        rig.connect(spring.a, (a.a, b.a)[n == 1])  # one of them the other way round
        rig.connect(spring.b, (b.a, a.a)[n == 1])
    t = np.linspace(0, 5, 101)
    run = gb.simulate(rig, t=t, rtol=1e-12)
    assert distance(run["a.phi"], 0.05 * (1 + np.cos(10 * t))) < 1e-9
    assert run["spring1.twist"][50] == -run["spring0.twist"][50]


def test_a_loop_through_the_ground_starts_where_the_angles_are(distance):
    """Two springs to two grounds held at different angles: the second twist follows from the first and both angles."""
    rig = gb.Drivetrain("between")
    body = rig.add("body", gb.Inertia(J=1.0, phi0=0.2))
    left, right = rig.add("left", gb.Fixed(phi0=-0.1)), rig.add("right", gb.Fixed(phi0=0.7))
    one, two = rig.add("one", gb.Shaft(k=60.0)), rig.add("two", gb.Shaft(k=40.0))
    rig.chain(left, one, body, two, right)
    t = np.linspace(0, 3, 101)
    run = gb.simulate(rig, t=t, rtol=1e-12)
    rest = (60 * -0.1 + 40 * 0.7) / 100
    assert distance(run["body.phi"], rest + (0.2 - rest) * np.cos(10 * t)) < 1e-9
    assert np.allclose(run["two.twist"], 0.7 - run["body.phi"], atol=1e-14)


class Lever(gb.Block):
    """A spring along p phi_a + q phi_b + r phi_c."""

    a, b, c = gb.Flange("one"), gb.Flange("two"), gb.Flange("three")
    p: float = gb.param("factor of a", "1")
    q: float = gb.param("factor of b", "1")
    r: float | None = gb.param("factor of c, else -1", "1", default=None)
    k: float = gb.param("stiffness", "N m/rad")

    def physics(self, s):
        u = s.p * s.a.phi + s.q * s.b.phi + (-1 if self.r is None else s.r) * s.c.phi
        yield gb.Force(u, s.k * u)
        yield gb.Energy(stored=s.k * u**2 / 2)


def _on_a_lever(shafts=(), **factors):
    """Inertias of 1, 2 and 3 on a lever, shafts of these stiffnesses between neighbours."""
    rig = gb.Drivetrain("lever")
    lever = rig.add("lever", Lever(k=10.0, **factors))
    bodies = [rig.add(f"j{i}", gb.Inertia(J=1.0 + i)) for i in range(3)]
    for body, flange in zip(bodies, (lever.a, lever.b, lever.c), strict=True):
        rig.connect(body.a, flange)
    for i, k in enumerate(shafts):
        rig.chain(bodies[i], rig.add(f"shaft{i}", gb.Shaft(k=k)), bodies[i + 1])
    return rig


@pytest.mark.long
def test_cosines_that_close_the_circle_leave_a_train_free_to_turn():
    # three times 120 degrees: in floats the factors add up to -2e-16
    model = gb.build(_on_a_lever((5.0, 7.0), p=1.0, q=np.cos(2 * np.pi / 3), r=np.cos(4 * np.pi / 3)))
    assert sum(q.words == "relative angle" for q in model.program.states) == 2
    assert gb.modes(model).free == 1
    run = gb.simulate(model, t_end=3.0, rtol=1e-10, initial={"j0.w": 1.0})
    momentum = sum(J * run[f"j{i}.w"] for i, J in enumerate((1.0, 2.0, 3.0)))
    turned = sum(J * run[f"j{i}.phi"] for i, J in enumerate((1.0, 2.0, 3.0)))
    assert np.abs(momentum - 1.0).max() < 1e-12
    assert np.abs(turned - run.t).max() < 1e-9


@pytest.mark.parametrize(("p", "q"), [(0.5, 0.5), (0.0, 1.0), (1.0, 0.0), (0.0, 0.0)])
@pytest.mark.few(1)
def test_a_factor_of_a_deflection_may_be_nothing(p, q):
    w = gb.simulate(_on_a_lever(p=p, q=q), t=[0.7], rtol=1e-10, initial={"j2.w": 1.0})
    rate = 10.0 * (p**2 / 1 + q**2 / 2 + 1 / 3)  # the only mode swings along the deflection
    swing = (1 - np.cos(np.sqrt(rate) * 0.7)) * 10.0 / rate
    assert w["j0.w"][0] == pytest.approx(p * swing, abs=1e-9)
    assert w["j1.w"][0] == pytest.approx(q / 2 * swing, abs=1e-9)
    assert w["j2.w"][0] == pytest.approx(1 - swing / 3, abs=1e-9)


def test_a_deflection_measured_in_a_flange_that_has_no_part_in_it_is_refused():
    with pytest.raises(gb.ModelError, match=r"'lever': the factor of flange 'b', q/p, has no value with p = 0"):
        gb.build(_on_a_lever(p=0.0, q=1.0, r=2.0))
