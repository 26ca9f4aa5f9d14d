"""Lines of long mathematics: as few as there can be, broken outside rather than inside, none too wide that can be broken."""

import itertools

import pytest

from gearblocks.equations.latex import COLUMN, STYLE, aligned, fit_together, is_wide, width
from gearblocks.equations.line_breaking import TOO_WIDE, Style, cost, lines
from gearblocks.equations.names import Name
from gearblocks.equations.nodes import Call, Fence, Fraction, Num, Op, Row, Sym, Times, Words
from gearblocks.equations.text import STYLE as TEXT


def _sym(letter, owner=""):
    return Sym(Name(letter, "", owner))


def _sum(*terms):
    return Row(tuple(x for term in terms for x in (Op("+"), term))[1:])


def _wide(n, letter="x"):
    return _sym(letter * n)


def test_lines_are_as_few_as_there_can_be_and_no_wider_than_asked():
    whole = _sum(*(_wide(n) for n in (9, 3, 8, 2, 7, 6, 5, 9, 4)))
    for room in range(12, 70):
        broken = lines([whole], TEXT, room, room)
        groups = [len(x) for x in "".join(broken).replace(" + ", "| + ").split("|")]
        assert max(map(len, broken)) <= room
        fewest = next(n for n in itertools.count(1) if _fits(groups, n, room))
        assert len(broken) == fewest


def _fits(groups, n, room):
    used, count = 0, 1
    for group in groups:
        used, count = (used + group, count) if used + group <= room else (group, count + 1)
    return count <= n


def test_a_line_ends_before_an_outer_sign_rather_than_inside_brackets():
    inner = Times((_wide(6), Fence("(", ")", _sum(_wide(6, "y"), _wide(6, "z")))))
    assert lines([_sum(_wide(14, "a"), inner)], TEXT, 30, 30) == ["a" * 14, " + xxxxxx (yyyyyy + zzzzzz)"]
    assert lines([inner], TEXT, 20, 20) == ["xxxxxx ", "· (yyyyyy + zzzzzz)"]
    assert lines([inner], TEXT, 16, 16) == ["xxxxxx (yyyyyy", " + zzzzzz)"]


def test_a_function_stands_behind_a_short_fraction_and_never_over_the_last_line():
    names = [_sym(x, "gear sun_mesh i") for x in "kzf"]
    long = Call(names[2], (Fraction(Times((names[1], _sym("φ", "a long name"))), Times((Num("2"), _sym("π")))),), 1)
    whole = Fraction(Times((names[0], names[1], long)), Times((Num("2"), _sym("π"))))
    shown = aligned(_sym("κ", "gear sun_mesh i"), whole)
    assert r"\frac{k_{\mathrm{gear\,sun\_mesh}\,i}\,z_{\mathrm{gear\,sun\_mesh}\,i}}{2\,\pi}" in shown
    assert not shown.rstrip().endswith("/ (2\\,\\pi)")


@pytest.mark.parametrize("count", [2, 3, 6, 12])
@pytest.mark.parametrize("owner", ["", "motor", "a longer name"])
def test_a_right_side_stands_below_where_that_is_fewer_lines(count, owner):
    right = _sum(*(Times((_sym("a", "shaft"), _sym("b", "another shaft"))) for _ in range(count)))
    left = _sym("J", owner)
    head = width(left) + 2.6
    beside = len(lines([right], STYLE, COLUMN - head, COLUMN - head - 2))
    below = 1 + len(lines([Op("="), right], STYLE, COLUMN - 2, COLUMN - 2))
    assert aligned(left, right).count(r"\\*") + 1 == min(beside, below)
    assert aligned(left, right).startswith("&J") == (below < beside)


def test_what_cannot_be_broken_is_not_put_behind_a_wide_left_side():
    word = Call(Words("wave"), (Num("9" * 28),))
    short, long = _sym("x"), _sym("J", "a long foot")
    assert not is_wide(short, word)
    assert fit_together([(short, word), (short, short)])
    assert not fit_together([(short, word), (long, short)])
    style = Style(lambda node: node.digits, lambda node: float(len(node.digits)), " ", str)
    assert cost([Num("9" * 50)], style, COLUMN, COLUMN) > TOO_WIDE / 10 > cost([Num("9" * 30)], style, COLUMN, COLUMN)


@pytest.mark.parametrize("words", [" with ", "with ", " with the right sides of "])
def test_a_line_may_begin_with_words_behind_mathematics(words):
    row = Row((_wide(9), Op("="), _wide(20), Words(words), _wide(6, "f")))
    broken = lines([row], TEXT, 34, 34)
    assert len(broken) == 2 and max(map(len, broken)) <= 34
    assert broken[1].startswith("with")
