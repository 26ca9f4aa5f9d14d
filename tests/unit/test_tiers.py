"""The tiers of the tests: of many cases of one test some are quick, at other places in every part of them."""

from dataclasses import dataclass, field

import pytest

from tests.conftest import beyond_the_few, diagonal


@dataclass
class Item:
    """A test, as far as its marks and its name go."""

    nodeid: str
    marks: dict = field(default_factory=dict)

    def get_closest_marker(self, name):
        return self.marks.get(name)


def test_of_a_product_of_parameters_every_value_of_both_is_taken():
    cases = [(a, b) for a in range(3) for b in range(4)]
    taken = [cases[i] for i in sorted(diagonal(12, 6))]
    assert len(taken) == 6
    assert {a for a, _ in taken} == {0, 1, 2}
    assert len({b for _, b in taken}) > 1
    assert diagonal(4, 2) == {0, 3}
    assert diagonal(2, 5) == {0, 1}


def test_cases_beyond_the_few_are_those_that_are_not_long_already():
    few, long = {"few": pytest.mark.few(2).mark}, {"long": pytest.mark.long.mark}
    items = [Item(f"file::test[{i}]", few | (long if i % 2 else {})) for i in range(8)]
    items += [Item(f"file::other[{i}]") for i in range(3)]
    assert [item.nodeid for item in beyond_the_few(items)] == ["file::test[2]", "file::test[4]"]
