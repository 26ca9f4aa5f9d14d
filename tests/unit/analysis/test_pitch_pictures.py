"""Pictures of rolling pitch curves: what is drawn touches in the pitch point, and bad requests are refused."""

import math

import numpy as np
import pytest

import gearblocks as gb


def test_curves_touch_at_the_pitch_point_at_every_angle_and_teeth_lie_around_them(tmp_path):
    pair = gb.RatioLaw.ellipse(0.4632).pair(0.25)
    teeth = pair.flanks(4e-3, 59, pressure_angle=math.radians(20))
    angles = (0.0, 1.0, 4.0)
    figure = gb.draw_pitch_curves(pair, tmp_path / "pair.png", angles=angles, flanks=(teeth, None))
    assert (tmp_path / "pair.png").stat().st_size > 10_000
    (listed,) = figure.legends
    assert [text.get_text() for text in listed.get_texts()] == ["gear 1", "gear 2", "pitch point"]
    for axis, phi in zip(figure.axes, angles, strict=True):
        curves = [line for line in axis.lines if len(line.get_xdata()) == 721]
        touch = 1e3 * pair.radii(phi)[0], 0.0
        assert len(curves) == 2
        for line in curves:
            away = np.hypot(line.get_xdata() - touch[0], line.get_ydata())
            assert away.min() < 1.0  # mm: half a step between 721 points
        assert sum(len(line.get_xdata()) == teeth.x.shape[1] for line in axis.lines) == 2 * 59


@pytest.mark.parametrize(
    ("given", "words"),
    [({"pair": "law"}, "pair = 'law' must be a pair"), ({"angles": ()}, r"angles = \(\) must be 1 to 12"),
     ({"angles": (math.nan,)}, "must be 1 to 12 angles")],
)  # fmt: skip
def test_what_cannot_be_drawn_is_refused(given, words):
    arguments = {"pair": gb.RatioLaw.ellipse(0.2).pair(0.2), **given}
    with pytest.raises(gb.ParameterError, match=words):
        gb.draw_pitch_curves(**arguments)
