"""Saved states as bytes: the same run goes on from them, and any other bytes are refused."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import fmu_export
import gearblocks as gb
from fmu_export.checks.instance import Instance, Unpacked
from gearblocks.solver.library import Model

Unpacker = Callable[[Path, Path], Unpacked]


def _braked() -> gb.Drivetrain:
    """Friction that sticks and slides: an active set in the state."""
    rig = gb.Drivetrain("braked")
    body = rig.add("body", gb.Inertia(J=1.0, w0=1.0))
    rig.chain(
        rig.add("drive", gb.Torque(tau=3.0 * gb.sin(5.0 * gb.time))), body, rig.add("brake", gb.Brake(capacity=2.0))
    )
    return rig


def _stiff() -> gb.Drivetrain:
    rig = gb.Drivetrain("stiff")
    rig.chain(
        rig.add("body", gb.Inertia(J=1.0, w0=1.0)), rig.add("shaft", gb.Shaft(k=1e6, c=1e3)), rig.add("g", gb.Fixed())
    )
    return rig


def _held() -> gb.Drivetrain:
    """A controller that goes on and off and slides along its limit from 0.1 s on."""
    rig = gb.Drivetrain("held")
    body, tau = rig.add("body", gb.Inertia(J=1.0)), gb.piecewise((10, gb.sense("body.w") < 1), (-4, True))
    rig.connect(body.a, rig.add("drive", gb.Torque(tau=tau)).flange)
    rig.connect(body.b, rig.add("load", gb.Torque(tau=6.0 * gb.sin(5.0 * gb.time))).flange)
    return rig


KINDS = (
    "oscillator",
    pytest.param("started from a state", marks=pytest.mark.long),
    "braked",
    pytest.param("held", marks=pytest.mark.long),
    "stiff",
)


@pytest.fixture(scope="module", params=KINDS)
def fmu(
    request: pytest.FixtureRequest, model: Model, tmp_path_factory: pytest.TempPathFactory, unpacker: Unpacker
) -> Unpacked:
    made: dict[str, Callable[[], tuple[Any, dict[str, Any]]]] = {
        "oscillator": lambda: (model, {}),
        "started from a state": lambda: (model, {"initial": np.array([1e-3, 0.5] + 14 * [0.0])}),
        "braked": lambda: (_braked(), {}),
        "held": lambda: (_held(), {}),
        "stiff": lambda: (_stiff(), {"method": "rodas"}),
    }
    train, options = made[request.param]()
    folder = tmp_path_factory.mktemp("saved")
    return unpacker(fmu_export.export(train, folder / "m.fmu", **options), folder / "unpacked")


def _saved(instance: Instance) -> bytes:
    state = instance.fmu.getFMUstate()
    data = bytes(instance.fmu.serializeFMUstate(state))
    instance.fmu.freeFMUstate(state)
    return data


@pytest.mark.parametrize("phase", ["new", "running", "failed"])
@pytest.mark.few(1)
def test_one_flipped_bit_anywhere_is_noticed(fmu: Unpacked, phase: str) -> None:
    """In every byte one bit; the front, with what chooses among tables, bit by bit."""
    with Instance(fmu) as instance, Instance(fmu) as other:
        if phase != "new":
            instance.start()
            instance.step(0.0, 0.3)
        if phase == "failed":
            instance.fmu.terminate()
        data = _saved(instance)
        bits = [(at, bit) for at in range(min(len(data), 1200)) for bit in range(8)]
        bits += [(at, at % 8) for at in range(1200, len(data))]
        for at, bit in bits:
            damaged = data[:at] + bytes([data[at] ^ (1 << bit)]) + data[at + 1 :]
            line = other.refuses(lambda damaged=damaged: other.fmu.deSerializeFMUstate(damaged))
            wanted = "belongs to another model" if at < 64 else "is damaged"
            assert wanted in line, (at, bit)
        copy = other.fmu.deSerializeFMUstate(data)
        other.fmu.setFMUstate(copy)
        other.fmu.freeFMUstate(copy)


@pytest.mark.few(1)
def test_bytes_that_are_cut_lengthened_or_no_state_are_refused(fmu: Unpacked) -> None:
    with Instance(fmu) as instance:
        instance.start()
        instance.step(0.0, 0.01)
        data = _saved(instance)
        for other in (data[:-1], data[:64], data + b"\0", b"x", bytes(len(data)), data[8:] + data[:8]):
            assert instance.refuses(lambda other=other: instance.fmu.deSerializeFMUstate(other))
        instance.step(0.01, 0.01)


def test_a_state_goes_on_with_the_same_bits_wherever_its_bytes_lie(fmu: Unpacked) -> None:
    described = fmu.description.modelVariables
    refs = [v.valueReference for v in described if v.causality in ("output", "parameter")]
    starts = [v for v in described if v.name.endswith(".start")]
    with Instance(fmu) as instance, Instance(fmu) as other:
        instance.set([v.valueReference for v in starts], [2.0 * float(v.start) for v in starts])
        instance.start()
        instance.step(0.0, 0.31)
        data = _saved(instance)
        instance.step(0.31, 0.2)
        for _ in range(2):  # into a new instance, and into one that runs
            copy = other.fmu.deSerializeFMUstate(data)
            other.fmu.setFMUstate(copy)
            other.fmu.freeFMUstate(copy)
            other.step(0.31, 0.2)
            assert other.get(refs) == instance.get(refs)


def test_a_block_in_process_is_checked_like_one_of_an_fmu(model: Model) -> None:
    from gearblocks.solver.structures import Code, Options

    with model.library.open() as sim:
        sim.parameters[:] = model.values
        sim.changed()
        assert sim.start(Options(0, 1, 1e-6, 1e-5, np.inf, np.inf), 0.0) == Code.DONE
        sim.advance(0.01)
        block = sim.save()
        assert sim.restore(block) == Code.DONE
        for at in range(0, len(block), 7):
            assert sim.restore(block[:at] + bytes([block[at] ^ 1]) + block[at + 1 :]) == Code.ERR_STATE
        assert sim.restore(block) == Code.DONE
