"""A compiled model is opened, run, fed, saved and asked from Python."""

import math
from collections.abc import Callable

import numpy as np
import pytest

from gearblocks.solver.library import Library
from gearblocks.solver.structures import Code, Kind, Options


def test_a_run_through_samples_follows_the_cosine(begin: Callable[..., None], oscillator: Library) -> None:
    t = np.linspace(0.0, 10.0, 101)
    with oscillator.open() as sim:
        begin(sim)
        record = sim.record(rows=1000)
        assert sim.run(t, 10.0, record, 10.0) == Code.DONE
        rows, events = record.take()
        code, out, energy = sim.evaluate(rows, np.array([0], dtype=np.intc), energies=True)
        counters = sim.counters
    assert code == Code.DONE
    assert len(events) == 0
    assert np.array_equal(rows[:, 0], t)
    # rtol 1e-10 per step, some tens of steps
    assert np.abs(out[:, 0] - np.cos(2.0 * t)).max() < 1e-8
    assert np.abs(energy.sum(axis=1) - 2.0).max() < 1e-7
    assert counters.steps > 0
    assert counters.rhs_calls > counters.steps


def test_a_full_record_is_emptied_and_the_run_goes_on(begin: Callable[..., None], oscillator: Library) -> None:
    t = np.linspace(0.0, 1.0, 101)
    with oscillator.open() as sim:
        begin(sim)
        record = sim.record(rows=10)
        times = []
        while (code := sim.run(t, 1.0, record, 10.0)) == Code.FULL:
            times.append(record.take()[0][:, 0])
        times.append(record.take()[0][:, 0])
    assert code == Code.DONE
    assert np.array_equal(np.concatenate(times), t)


def test_communication_points_and_saved_states_repeat_bit_for_bit(
    begin: Callable[..., None], oscillator: Library
) -> None:
    with oscillator.open() as sim:
        begin(sim)
        sim.advance(0.7)
        block = sim.save()
        sim.advance(1.9)
        first = sim.state()
        assert sim.restore(block) == Code.DONE
        assert sim.time == 0.7
        sim.advance(1.9)
        assert np.array_equal(sim.state(), first)
        assert sim.outputs()[0] == first[0]
        assert sim.energies()[0] == 0.5 * first[1] ** 2
        assert sim.restore(block[:-8]) == Code.ERR_STATE


def test_an_input_is_a_value_a_table_or_a_function(begin: Callable[..., None], oscillator: Library) -> None:
    def end(prepare: str) -> float:
        with oscillator.open() as sim:
            if prepare == "value":
                sim.inputs[0] = 4.0
                sim.changed()
            elif prepare == "table":
                sim.set_table(0, Kind.LINEAR, np.array([0.0, 1.0]), np.array([4.0, 4.0]))
            else:
                sim.set_function(0, lambda t: 4.0)
            begin(sim)
            assert sim.advance(3.0) == Code.DONE
            return float(sim.outputs()[0])

    # u = w^2 holds the mass where it starts
    assert end("value") == pytest.approx(1.0, abs=1e-12)
    assert end("table") == end("value")
    assert end("function") == end("value")


def test_what_an_input_function_raises_stops_the_run_and_is_kept(options: Options, oscillator: Library) -> None:
    def broken(t: float) -> float:
        raise ZeroDivisionError(f"at {t}")

    with oscillator.open() as sim:
        sim.set_function(0, broken)
        code = sim.start(options, 0.0)
        if code == Code.DONE:
            code = sim.advance(1.0)
        assert code == Code.ERR_CALLBACK
        assert sim.report.index == 0
        assert isinstance(sim.error, ZeroDivisionError)


def test_the_right_hand_side_can_be_asked(begin: Callable[..., None], oscillator: Library) -> None:
    with oscillator.open() as sim:
        begin(sim, 3.0)
        y = np.zeros(8)
        y[:2] = 2.0, 5.0
        assert np.array_equal(sim.rhs(0.0, y)[:2], [5.0, -18.0])
        with pytest.raises(ValueError, match="length 8"):
            sim.rhs(0.0, np.zeros(2))


def test_two_simulations_of_one_library_do_not_share_anything(begin: Callable[..., None], oscillator: Library) -> None:
    with oscillator.open() as first, oscillator.open() as second:
        begin(first, 2.0)
        begin(second, 3.0)
        first.advance(1.0)
        second.advance(1.0)
        assert first.outputs()[0] == pytest.approx(math.cos(2.0), abs=1e-8)
        assert second.outputs()[0] == pytest.approx(math.cos(3.0), abs=1e-8)


def test_a_closed_simulation_can_be_closed_again(oscillator: Library) -> None:
    sim = oscillator.open()
    sim.close()
    sim.close()
    assert len(sim.parameters) == 0
