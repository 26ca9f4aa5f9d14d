"""The cases that break ordinary scripts: each is survived, or refused by name."""

from __future__ import annotations

import re

import pytest

from gearblocks.cli.main import main
from gearblocks.hard import suite

# slow: 1e7 steps (H31), 500 periods by a reference solver in Python (H42), 1e5 bodies built (S58); around a second: the rest
LONG = ("H31", "H42", "S58", "H26", "S46", "S51", "S52")


@pytest.mark.few(4)
@pytest.mark.parametrize(
    "case",
    [
        pytest.param(
            case,
            id=case.id,
            marks=[pytest.mark.long] * (case.id in LONG),
        )
        for case in suite.cases()
    ],
)
def test_what_a_hard_case_asks_for_holds(case: suite.Case) -> None:
    outcome = suite.judge(case)
    assert outcome.passed, f"{case.id}, {case.title}: {outcome.measured}"


def test_every_case_has_a_judge_and_every_judge_a_case() -> None:
    assert [case.id for case in suite.cases()] == list(suite.JUDGES)
    assert len(suite.JUDGES) == 49


def test_the_shell_prints_a_row_per_case_and_says_how_many_passed(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["hard", "h21", "H41"]) == 0
    text = capsys.readouterr().out
    assert re.search(r"^case +steps +CPU s +of it runs +RK45", text, re.M)
    assert re.search(r"^H21 +pass .*pass 1\.5 +pass 13\.5 +fail 0\.45", text, re.M)
    assert re.search(r"^     measured: ", text, re.M) and max(map(len, text.splitlines())) <= 80
    assert re.search(r"^H41 ", text, re.M) and "2 of 2 passed" in text


def test_the_shell_refuses_a_case_that_there_is_not(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["hard", "H05"]) == 2
    assert "there is no hard case 'H05'" in capsys.readouterr().err


def test_a_failed_case_is_the_answer_no(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    from gearblocks.hard import judging

    monkeypatch.setitem(dict_of_judges(), "H21", lambda meter: [judging.below("energy drifts by", 1.0, 1e-3)])
    assert main(["hard", "H21"]) == 1
    assert "FAIL" in capsys.readouterr().out


def dict_of_judges() -> dict[str, suite.Judge]:
    """The table of judges, as one that a test may change."""
    assert isinstance(suite.JUDGES, dict)
    return suite.JUDGES


def test_a_suite_that_is_stopped_keeps_its_rows(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def stopped(_meter: object) -> list[object]:
        raise KeyboardInterrupt

    monkeypatch.setitem(dict_of_judges(), "H41", stopped)
    assert main(["hard", "H25", "H41", "H33"]) == 1
    shown = capsys.readouterr()
    assert re.search(r"^H25 .*pass", shown.out, re.M) and "1 of 1 passed" in shown.out
    assert "H33" not in shown.out and "stopped" in shown.err
