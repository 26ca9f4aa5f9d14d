"""An FMU of non-circular gears: laws of every form and a phase from outside, the same bits as in-process."""

from pathlib import Path

import numpy as np
import pytest

import fmu_export
import gearblocks as gb

X = np.deg2rad(240)
NORM = gb.RatioLaw.segments(0.7 / X, 0.5, X)
ELLIPSE = gb.RatioLaw.ellipse(0.3)


@pytest.mark.long
@pytest.mark.parametrize(
    "gear",
    [
        pytest.param({"law": NORM, "phase": gb.Input("shift", start=0.4, unit="rad"), "filter": 20.0}, id="rigid"),
        pytest.param(
            {
                "law": ELLIPSE,
                "k": 400 + 50 * gb.cos(gb.driver_angle),
                "c": 0.01,
                "backlash": gb.Backlash(half_gap=1e-4),
            },
            id="compliant",
            marks=pytest.mark.long,
        ),
    ],
)
def test_an_fmu_of_a_non_circular_pair_passes_every_check(gear: dict[str, object], tmp_path: Path) -> None:
    rig = gb.Drivetrain("pair")
    rig.chain(
        rig.add("drive", gb.Torque(tau=0.2)), rig.add("one", gb.Inertia(J=1e-4, w0=20.0)),
        rig.add("mesh", gb.NonCircularGear(external=True, **gear)), rig.add("two", gb.Inertia(J=2e-4)),
        rig.add("load", gb.Torque(tau=0.2)),
    )  # fmt: skip
    fmu_export.export(rig, tmp_path / "pair.fmu")
    report = fmu_export.check(tmp_path / "pair.fmu")
    assert not [str(item) for item in report.items if not item.ok]
