"""Two freewheels around a ratio that varies: w_2 <= w_3 <= w_7 = r(phi) w_2, which no motion does where r < 1 and w_2 > 0. As r
comes down to 1 both lock, and what turns would have to stop at once: refused by name. It had run on with w_7 < w_3, silently.

Independent: the inequality itself; a compliant shaft in the loop, which is wound up until all stands.
"""

from __future__ import annotations

import numpy as np
import pytest

import gearblocks as gb


def _loop(w9: float, w10: float, soft: float | None = None) -> gb.Drivetrain:
    rig = gb.Drivetrain("wedge")
    names, inertias = ("j2", "j3", "j4", "j7", "j9", "j10"), (1.44, 0.17, 0.386, 0.1, 0.116, 0.5)
    starts = {"j9": w9, "j10": w10}
    body = {n: rig.add(n, gb.Inertia(J=J, w0=starts.get(n))) for n, J in zip(names, inertias, strict=True)}
    first, second = (
        rig.add(n, gb.NonCircularGear(law=gb.RatioLaw.ellipse(e=e, order=2), external=True))
        for n, e in (("first", 0.0827), ("second", 0.197))
    )
    one, two = rig.add("one", gb.Freewheel()), rig.add("two", gb.Freewheel())
    rig.chain(body["j9"], rig.add("shaft9", gb.Shaft(k=249.0)), body["j2"], first, body["j4"], second, body["j7"])
    rig.chain(body["j10"], rig.add("shaft10", gb.Shaft(k=109.0, c=1.3)), body["j3"])
    rig.chain(body["j2"], one, body["j3"])
    if soft is None:
        rig.chain(body["j3"], two, body["j7"])
    else:
        rig.chain(
            body["j3"], two, rig.add("between", gb.Inertia(J=0.01)), rig.add("soft", gb.Shaft(k=soft)), body["j7"]
        )
    return rig


JAMS = [(3.34, 4.27), (1.644, -2.763), (-5.508, -5.802), (3.759, 4.953), (4.289, -5.597)]


@pytest.mark.parametrize(("w9", "w10"), JAMS)
@pytest.mark.parametrize("method", ["auto", "dp5"])
@pytest.mark.few(2)
def test_it_is_refused_by_name_with_a_way_out(w9: float, w10: float, method: str) -> None:
    with pytest.raises(gb.SimulationError, match=r"'(one|two)'.*jams.*compliant Shaft"):
        gb.simulate(_loop(w9, w10), t_end=2.0, method=method)


@pytest.mark.parametrize(("w9", "w10"), [(4.358, 0.498), (-2.403, -0.928)])
def test_what_never_jams_keeps_its_order_of_speeds(w9: float, w10: float) -> None:
    run = gb.simulate(_loop(w9, w10), t=np.linspace(0.0, 2.0, 2001), rtol=1e-8)
    w2, w3, w7 = (run[f"{n}.w"] for n in ("j2", "j3", "j7"))
    assert np.min(w3 - w2) > -1e-9 and np.min(w7 - w3) > -1e-9 and run.energy.residual < 1e-7
    assert np.max(w7 - w3) > 0.1 and len(run.events) > 20


@pytest.mark.long
def test_the_way_out_works() -> None:
    for w9, w10 in JAMS:
        run = gb.simulate(_loop(w9, w10, soft=2e4), t=np.linspace(0.0, 2.0, 2001))
        assert run.energy.residual < 1e-5
        assert np.min(run["j3.w"] - run["j2.w"]) > -1e-9 and np.min(run["two.w_rel"]) > -1e-9
