"""The list of mutations fits the sources."""

from __future__ import annotations

import functools
import tomllib
from collections import Counter
from pathlib import Path
from runpy import run_path

import pytest

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
MUTATIONS = tomllib.loads((HERE / "mutations.toml").read_text(encoding="utf-8"))["mutation"]


SUBJECTS = ("constraints", "error control", "events", "FMU glue", "laws", "ledger", "outputs")


@functools.cache
def _text(file: str) -> str:
    return (ROOT / file).read_text(encoding="utf-8")


@pytest.mark.parametrize("subject", SUBJECTS)
def test_a_mutation_fits_the_source_once_and_names_tests_that_there_are(subject: str) -> None:
    for mutation in (found for found in MUTATIONS if found["subject"] == subject):
        name, file, text, tests = mutation["name"], str(mutation["file"]), str(mutation["text"]), mutation["tests"]
        assert _text(file).count(text) == 1, f"{name}: {file} has not once: {text}"
        assert text != mutation["becomes"], name
        assert isinstance(tests, list) and tests, name
        for test in tests:
            where, function = test.split("::")
            assert f"\ndef {function.split('[')[0]}(" in _text(where), f"{name}: {test}"


def test_the_readme_has_the_table_of_the_list() -> None:
    module = run_path(str(HERE / "mutations.py"))
    assert module["table"]() in (HERE / "README.md").read_text(encoding="utf-8"), (
        "python tests/hard/mutations.py --table"
    )


def test_every_subject_has_its_share() -> None:
    counts = Counter(mutation["subject"] for mutation in MUTATIONS)
    assert len(MUTATIONS) >= 120 and len({mutation["name"] for mutation in MUTATIONS}) == len(MUTATIONS)
    assert set(counts) == {*SUBJECTS}
    assert min(counts.values()) >= 15, counts
