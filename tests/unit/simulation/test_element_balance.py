"""Balances of elements: which one does not close where the total does not."""

import warnings

import numpy as np
import pytest
import sympy as sp

import gearblocks as gb
from gearblocks.errors import GearblocksWarning


class Jumpy(gb.Block):
    """A spring that claims more energy beyond an angle."""

    a = gb.Flange("end")
    k: float = gb.param("stiffness", "N m/rad")
    more: float = gb.param("energy out of nothing", "J")

    def physics(self, s):
        yield gb.Acts(s.a, -s.k * s.a.phi)
        yield gb.Energy(stored=s.k * s.a.phi**2 / 2 + sp.Piecewise((s.more, s.a.phi > 0.5), (0, True)))


def _jumpy(**arguments):
    """A run with a jump by 40 % of the turnover."""
    with pytest.warns(GearblocksWarning, match=r"run of 'jump': its energy is balanced to 0\.4 of the turnover only"):
        return gb.simulate(_rig(3.0), t_end=0.5, **arguments)


def _rig(more):
    rig = gb.Drivetrain("jump")
    body, other = rig.add("body", gb.Inertia(J=1.0, w0=3.0)), rig.add("other", gb.Inertia(J=2.0))
    rig.connect(body.a, rig.add("jumpy", Jumpy(k=4.0, more=more)).a)
    rig.chain(body, rig.add("shaft", gb.Shaft(k=3.0, c=0.1)), other)
    return rig


def _told(run, words):
    """What `run` gives; a ledger that is wrong by more than a hundredth is told, others are not."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", GearblocksWarning)
        result = run()
    told = [str(w.message) for w in caught if issubclass(w.category, GearblocksWarning)]
    assert len(told) == (result.energy.residual > 1e-2) and all(words in line for line in told)
    return result


@pytest.mark.parametrize("more", [3.0, -0.25, 1e-4])
def test_the_element_whose_energy_jumps_is_named(more):
    run = _told(lambda: gb.simulate(_rig(more), t_end=0.5), "most of it is missing in 'jumpy'")
    assert (run.energy.residual > 1e-2) == (more != 1e-4)
    assert run.energy.residual > 1e-5
    assert run.energy.culprit == "jumpy"
    assert run.energy.unbalanced["jumpy"] == pytest.approx(more, rel=1e-3)
    assert max(abs(x) for name, x in run.energy.unbalanced.items() if name != "jumpy") < 1e-6
    assert "'jumpy'" in str(run.energy) and "'jumpy'" in repr(run.energy)
    with pytest.raises(gb.SimulationError, match=r"'jumpy': the energy residual is .* above the 1e-05") as stop:
        gb.simulate(_rig(more), t_end=0.5, residual=1e-5)
    assert stop.value.trajectory.energy.culprit == "jumpy"
    sampled = _told(lambda: gb.simulate(_rig(more), t=np.linspace(0, 0.5, 7)), "most of it is missing in 'jumpy'")
    assert sampled.energy.culprit == "jumpy"


@pytest.mark.parametrize("more", [3.0, -0.25, 1e-4])
def test_what_the_elements_miss_is_what_the_whole_misses(more):
    run = _told(lambda: gb.simulate(_rig(more), t_end=0.5), "'jumpy'")
    assert sum(run.energy.unbalanced.values()) == pytest.approx(run.energy.imbalance, rel=1e-2)


def test_nothing_is_named_where_the_ledger_closes_or_promises_nothing():
    assert gb.simulate(_rig(0.0), t_end=0.5).energy.culprit == ""
    assert _jumpy(method="rk4", step=0.01).energy.unbalanced == {}
    assert _jumpy(locate=False).energy.unbalanced == {}


def test_a_ledger_with_names_is_stored_and_sent():
    import pickle

    ledger = _jumpy().energy
    again = pickle.loads(pickle.dumps(ledger))
    assert again.unbalanced == ledger.unbalanced and again.culprit == "jumpy"


@pytest.mark.parametrize("arguments", [{}, {"max_step": 1e-4}, {"method": "dp5"}])
def test_a_second_look_for_the_element_is_not_counted(arguments):
    """The motion is the same whatever energy is claimed: so is what the solver counts."""
    sound, wrong = (
        _told(lambda more=more: gb.simulate(_rig(more), t_end=0.5, **arguments), "") for more in (0.0, -0.25)
    )
    assert sound.energy.unbalanced == {} and wrong.energy.culprit == "jumpy"
    counted = [(s.steps, s.rejected, s.rhs_calls, s.events) for s in (sound.stats, wrong.stats)]
    assert counted[0] == counted[1]
