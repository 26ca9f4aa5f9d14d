"""Shapes of symbols: widths of words that hold in the widest usual font, and their moves."""

import string
from pathlib import Path

import matplotlib
from matplotlib.ft2font import FT2Font

from gearblocks.drawing.shapes import Circle, Stroke, Words, line, mirrored, moved, text_width, turned


def test_words_are_never_wider_than_their_room() -> None:
    font = FT2Font(str(Path(matplotlib.get_data_path()) / "fonts" / "ttf" / "DejaVuSans.ttf"))
    font.set_size(100.0, 72.0)
    letters = [c for c in string.printable if c.isprintable()] + list("äüßéωφτ…°µ²")
    narrow = {c for c in letters if font.load_char(ord(c)).linearHoriAdvance / 65536 > text_width(c, 100.0)}
    assert narrow == set()


def test_a_quarter_turn_brings_the_left_end_to_the_top_and_keeps_words_upright() -> None:
    assert turned((line((-3, 0), (5, 1)),)) == (Stroke(((0, -3), (-1, 5))),)
    assert turned((Words(-3, 0, "a"),)) == (Words(0, -3, "a"),)


def test_a_mirror_image_and_a_move() -> None:
    assert mirrored((Circle(2, 1, 4),)) == (Circle(-2, 1, 4),)
    assert moved((Circle(2, 1, 4),), 1, 2) == (Circle(3, 3, 4),)
