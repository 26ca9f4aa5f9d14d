"""Stroboscopic points: their columns."""

import numpy as np
import pytest

import gearblocks as gb


def _swing():
    train = gb.Drivetrain("swing")
    speed = gb.Parameter("speed", 2.0, "rad/s")
    drive = train.add("drive", gb.Torque(tau=gb.sin(speed * gb.time)))
    body, shaft = train.add("body", gb.Inertia(J=1.0)), train.add("shaft", gb.Shaft(k=9.0, c=1.0))
    train.chain(drive, body, shaft, train.add("wall", gb.Fixed()))
    return gb.build(train)


@pytest.mark.parametrize(
    ("of", "names"),
    [
        (["body.w", "body.phi"], ("body.w", "body.phi")),
        (["shaft.twist", "body.w", "shaft.torque"], ("shaft.twist", "body.w", "shaft.torque")),
        (["shaft.twist*", "body.phi"], ("shaft.twist", "shaft.twist_rate", "body.phi")),
        ("body.w", ("body.w",)),
        (["body.phi", "body.*"], None),
    ],
)
def test_points_have_the_columns_that_were_asked_for_in_that_order(of, names):
    points = gb.poincare(_swing(), gb.stroboscopic("speed"), of=of, transient=5, keep=6, rtol=1e-8)
    if names is None:
        assert points.names[0] == "body.phi" and len(set(points.names)) == len(points.names)
    else:
        assert points.names == names
    run = points.run
    at = np.searchsorted(run.t, points.t)
    for name, column, extent in zip(points.names, points.values.T, points.extent, strict=True):
        assert np.array_equal(column, run[name][at]) and extent == np.abs(run[name]).max()
