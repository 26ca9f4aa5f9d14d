"""Balances of elements: which one does not close where the total does not."""

import numpy as np
import pytest
import sympy as sp

import gearblocks as gb


class Jumpy(gb.Block):
    """A spring that claims more energy beyond an angle."""

    a = gb.Flange("end")
    k: float = gb.param("stiffness", "N m/rad")
    more: float = gb.param("energy out of nothing", "J")

    def physics(self, s):
        yield gb.Acts(s.a, -s.k * s.a.phi)
        yield gb.Energy(stored=s.k * s.a.phi**2 / 2 + sp.Piecewise((s.more, s.a.phi > 0.5), (0, True)))


def _rig(more):
    rig = gb.Drivetrain("jump")
    body, other = rig.add("body", gb.Inertia(J=1.0, w0=3.0)), rig.add("other", gb.Inertia(J=2.0))
    rig.connect(body.a, rig.add("jumpy", Jumpy(k=4.0, more=more)).a)
    rig.chain(body, rig.add("shaft", gb.Shaft(k=3.0, c=0.1)), other)
    return rig


@pytest.mark.parametrize("more", [3.0, -0.25, 1e-4])
def test_the_element_whose_energy_jumps_is_named(more):
    run = gb.simulate(_rig(more), t_end=0.5)
    assert run.energy.residual > 1e-5
    assert run.energy.culprit == "jumpy"
    assert run.energy.unbalanced["jumpy"] == pytest.approx(more, rel=1e-3)
    assert max(abs(x) for name, x in run.energy.unbalanced.items() if name != "jumpy") < 1e-6
    assert "'jumpy'" in str(run.energy) and "'jumpy'" in repr(run.energy)
    with pytest.raises(gb.SimulationError, match=r"'jumpy': the energy residual is .* above the 1e-05") as stop:
        gb.simulate(_rig(more), t_end=0.5, residual=1e-5)
    assert stop.value.trajectory.energy.culprit == "jumpy"
    assert gb.simulate(_rig(more), t=np.linspace(0, 0.5, 7)).energy.culprit == "jumpy"


def test_what_the_elements_miss_is_what_the_whole_misses():
    rig = gb.Drivetrain("drift")
    rig.chain(
        rig.add("body", gb.Inertia(J=1.0, phi0=1.0)), rig.add("shaft", gb.Shaft(k=1.0)), rig.add("wall", gb.Fixed())
    )
    run = gb.simulate(rig, t_end=1000.0, rtol=1e-4, method="dp5")
    assert run.energy.residual > 1e-3 and run.stats.steps < 2000
    assert sum(run.energy.unbalanced.values()) == pytest.approx(run.energy.imbalance, rel=1e-2)
    assert set(run.energy.unbalanced) == {"body", "shaft"}


def test_nothing_is_named_where_the_ledger_closes_or_promises_nothing():
    assert gb.simulate(_rig(0.0), t_end=0.5).energy.culprit == ""
    assert gb.simulate(_rig(3.0), t_end=0.5, method="rk4", step=0.01).energy.unbalanced == {}
    assert gb.simulate(_rig(3.0), t_end=0.5, locate=False).energy.unbalanced == {}


def test_a_ledger_with_names_is_stored_and_sent():
    import pickle

    ledger = gb.simulate(_rig(3.0), t_end=0.5).energy
    again = pickle.loads(pickle.dumps(ledger))
    assert again.unbalanced == ledger.unbalanced and again.culprit == "jumpy"
