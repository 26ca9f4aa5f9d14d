"""Energy balance of a law: supplied = d stored/dt + loss + sum tau_f w_f over the flanges.

What neither a stored energy nor a loss explains of the power of all torques is exchange with sources, unless it
vanishes for all values of all modes. Knows nothing of kinetic energy, nor of trains.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import sympy as sp

from gearblocks.laws.derivative import derivative
from gearblocks.laws.law import Law
from gearblocks.laws.symbols import time_symbol
from gearblocks.laws.vanishing import vanishes


def add_energy_balance(law: Law, flanges: Mapping[str, Any]) -> None:
    """supplied = d stored/dt + loss + power given to the flanges: what neither stored nor lost energy explains."""
    parametric: Any = sp.Integer(0)
    rest = sum((tau.xreplace(law.forces) * flanges[n].w for n, tau in law.torques.items()), sp.Integer(0))
    rest += law.loss if law.loss is not None else 0
    if law.stored is not None:
        parametric = derivative(law.stored, time_symbol())
        for form, u in zip(law.forms, law.coordinates, strict=True):
            rate = sum(c * flanges[n].w for n, c in form.coefficients.items())
            rest += derivative(law.stored, u) * rate
        rest += sum(derivative(law.stored, f.phi) * f.w for f in flanges.values())
        for name, rate in law.rates.items():
            rest += derivative(law.stored, law.pool.symbol("state", name, name)) * rate
    supplied = parametric + (0 if vanishes(rest, law) else rest)
    law.supplied = None if supplied == 0 else supplied
