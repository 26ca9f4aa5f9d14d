"""Draws what accuracy costs at the spline coupling at 360 rpm into docs/pictures/, and says it.

python docs/draw_costs.py
"""

from __future__ import annotations

from pathlib import Path

import gearblocks as gb
from gearblocks.cli import scripts

if __name__ == "__main__":
    found = gb.work_precision(scripts.scene("spline_coupling:period_5"))
    found.plot(Path(__file__).parent / "pictures" / "cost.png")
    print(found.sentence)
