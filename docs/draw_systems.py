"""Draws the pictures of the three published systems into docs/pictures/.

python docs/draw_systems.py
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

import gearblocks as gb
from gearblocks.cli import scripts

PICTURES = Path(__file__).parent / "pictures"

if __name__ == "__main__":
    spline, planetary, cvt = (
        scripts.load(scripts.shipped()[name])
        for name in ("spline_coupling", "noncircular_planetary", "noncircular_cvt")
    )
    spline.picture_kv(PICTURES / "spline_kv.png")
    spline.picture_engagement(PICTURES / "spline_teeth.png")
    cvt.picture(PICTURES / "cvt_timing.png")
    alpha = math.radians(20)
    teeth = [
        planetary.PAIR.flanks(planetary.MODULE, planetary.TEETH, pressure_angle=alpha, gear=gear) for gear in (1, 2)
    ]
    gb.draw_pitch_curves(
        planetary.PAIR,
        PICTURES / "planetary_rolling.png",
        angles=(0.0, math.pi / 3, math.pi),
        flanks=(teeth[0], teeth[1]),
    )
    gb.draw_pitch_curves(cvt.LAW.pair(0.2), PICTURES / "cvt_rolling.png")
    for figure, path, low, high in ((8, "xi", 0.04, 0.30), (9, "mu", 0.01, 0.48), (10, "ka", 0.5, 2.0)):
        found = planetary.diagram(path, np.linspace(low, high, 201), keep=60, transient=200)
        found.plot(PICTURES / f"planetary_figure_{figure}.png")
