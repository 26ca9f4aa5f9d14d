"""What is set and what the importer asks for: tolerances, bounds, and the token that says what an FMU is made of."""

from __future__ import annotations

import re
import zipfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from fmpy.fmi1 import FMICallException
from lxml import etree

import fmu_export
import gearblocks as gb
from fmu_export import binary, exporter
from fmu_export.checks.instance import Instance, Unpacked
from fmu_export.tables import token_of
from gearblocks.codegen.output_list import OutputList
from gearblocks.errors import ParameterError
from gearblocks.solver.library import Model

Unpacker = Callable[[Path, Path], Unpacked]
WARNING = 1


@pytest.fixture
def pack(tmp_path: Path, unpacker: Unpacker) -> Callable[..., Unpacked]:
    """Exports a train and unpacks it."""

    def packed(train: Any, **options: Any) -> Unpacked:
        return unpacker(fmu_export.export(train, tmp_path / "m.fmu", **options), tmp_path / "m")

    return packed


def refs_of(unpacked: Unpacked, *names: str) -> list[int]:
    found = {v.name: v.valueReference for v in unpacked.description.modelVariables}
    return [found[name] for name in names]


# -- tolerances --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("set_first", [True, False])
@pytest.mark.parametrize("own", [1e-9, 1e-6])
def test_a_tolerance_that_was_set_wins_over_the_importers(unpacked: Unpacked, set_first: bool, own: float) -> None:
    """Also where it was set to what it was; a reset forgets it."""
    (rtol,) = refs_of(unpacked, "solver.rtol")
    with Instance(unpacked) as instance:
        if set_first:
            instance.set([rtol], [own])
        instance.fmu.setupExperiment(tolerance=1e-3)
        if not set_first:
            instance.set([rtol], [own])
        assert instance.get([rtol]) == [own]
        state = instance.fmu.getFMUstate()
        instance.fmu.reset()
        instance.fmu.setupExperiment(tolerance=1e-3)
        assert instance.get([rtol]) == [1e-3]
        instance.fmu.setFMUstate(state)
        instance.fmu.setupExperiment(tolerance=1e-4)
        assert instance.get([rtol]) == [own]
        instance.fmu.freeFMUstate(state)


@pytest.mark.parametrize(("asked", "taken"), [(0.0, 1e-6), (1.0, 0.1), (1e-20, 1e-14), (0.11, 0.1), (5e-324, 1e-14)])
def test_a_tolerance_out_of_range_is_a_warning_and_the_nearest_is_taken(
    unpacked: Unpacked, asked: float, taken: float
) -> None:
    """0 is no wish: the FMU's own stays."""
    with Instance(unpacked) as instance:
        assert instance.status_of(lambda: instance.fmu.setupExperiment(tolerance=asked)) in (0, WARNING)
        assert instance.log[-1][:2] == (WARNING, "logStatusWarning")
        assert f"{taken:g} is taken" in instance.log[-1][2]
        assert instance.get(refs_of(unpacked, "solver.rtol")) == [taken]
        instance.fmu.enterInitializationMode()
        instance.fmu.exitInitializationMode()
        instance.step(0.0, 1e-3)


@pytest.mark.parametrize("asked", [-1e-6, float("nan"), float("inf")])
def test_a_tolerance_that_is_none_is_refused(unpacked: Unpacked, asked: float) -> None:
    with Instance(unpacked) as instance:
        assert "must be a number >= 0" in instance.refuses(lambda: instance.fmu.setupExperiment(tolerance=asked))


# -- bounds ------------------------------------------------------------------------------------------------------------


def _meshing() -> gb.Drivetrain:
    """Declared bounds: stiffness > 0; half gap, damping >= 0. Two inertias on one shaft, one alone on the other."""
    shared = gb.Parameter("stiffness", 3.0e4, "N m/rad")
    rig = gb.Drivetrain("meshing")
    rig.chain(
        rig.add("drive", gb.Torque(tau=5.0)),
        rig.add("one", gb.Inertia(J=0.1)),
        rig.add("two", gb.Inertia(J=0.2)),
        rig.add("play", gb.Lash(k=2.0e4, c=1.0, half_gap=1e-4)),
        rig.add("alone", gb.Inertia(J=0.3)),
        rig.add("shaft", gb.Lash(k=shared, c=1.0, half_gap=1e-4)),
        rig.add("ground", gb.Fixed()),
    )
    rig.chain(rig["alone"], rig.add("spring", gb.Shaft(k=1.0e4)), rig.add("wall", gb.Fixed()))
    return rig


def test_an_open_bound_is_kept_open_and_a_closed_one_closed(pack: Callable[..., Unpacked]) -> None:
    """Refused by name, and the instance goes on; the description's limits belong to the values."""
    unpacked = pack(_meshing())
    described = {v.name: v for v in unpacked.description.modelVariables}
    names = ("play.k", "stiffness", "alone.J", "spring.k")
    with Instance(unpacked) as instance:
        instance.start()
        instance.step(0.0, 1e-3)
        for name in names:
            (ref,) = refs_of(unpacked, name)
            assert f"'{name}' is set to 0 at t = 0.001 s; it must lie in (0, inf" in instance.refuses(
                lambda ref=ref: instance.set([ref], [0.0])
            )
            assert float(described[name].min) > 0.0
        for name in ("play.c", "play.half_gap", "one.J"):
            assert float(described[name].min) == 0.0
            instance.set(refs_of(unpacked, name), [0.0])
        instance.step(1e-3, 1e-3)


@pytest.mark.long
def test_an_inertia_that_alone_makes_a_shaft_heavy_is_open_and_one_beside_others_is_not(
    pack: Callable[..., Unpacked],
) -> None:
    """What counts is whether these equations have a motion, also behind gears and for masses."""
    rig = gb.Drivetrain("geared")
    rig.chain(
        rig.add("drive", gb.Torque(tau=1.0)),
        rig.add("fast", gb.Inertia(J=0.1)),
        rig.add("gear", gb.IdealGear(ratio=3)),
        rig.add("slow", gb.Inertia(J=0.1)),
        rig.add("shaft", gb.Shaft(k=100.0)),
        rig.add("end", gb.Inertia(J=0.1)),
    )
    unpacked = pack(rig)
    with Instance(unpacked) as instance:
        instance.start()
        instance.step(0.0, 0.1)
        instance.set(refs_of(unpacked, "fast.J"), [0.0])
        instance.step(0.1, 0.1)
        instance.set(refs_of(unpacked, "fast.J", "slow.J"), [0.1, 0.0])
        instance.step(0.2, 0.1)
        (end,) = refs_of(unpacked, "end.J")
        assert "it must lie in (0, inf" in instance.refuses(lambda: instance.set([end], [0.0]))
        instance.step(0.3, 0.1)


@pytest.mark.parametrize(
    ("path", "value", "words"),
    [("play.k", 0.0, "> 0"), ("stiffness", 0.0, "> 0"), ("alone.J", -1.0, ">= 0"), ("spring.k", 0.0, "> 0 (or give")],
)
def test_values_on_an_open_bound_are_refused_in_process_and_by_the_export(
    path: str, value: float, words: str, tmp_path: Path
) -> None:
    rig = _meshing()
    for call in (
        lambda: gb.simulate(rig, t_end=0.1, parameters={path: value}),
        lambda: fmu_export.export(rig, tmp_path / "m.fmu", parameters={path: value}),
    ):
        with pytest.raises(ParameterError, match=re.escape(f"must be {words}")):
            call()


# -- failures by name --------------------------------------------------------------------------------------------------


@pytest.mark.long
def test_a_failure_names_the_energy_that_is_no_number(pack: Callable[..., Unpacked]) -> None:
    """w' = -1e300 is finite, the power lost is not."""
    rig = gb.Drivetrain("hot")
    body = rig.add("body", gb.Inertia(J=1.0, w0=1.0))
    rig.chain(body, rig.add("damper", gb.Damper(c=1e200)), rig.add("ground", gb.Fixed()))
    rig.chain(body, rig.add("brake", gb.Brake(capacity=1.0)))
    unpacked = pack(rig, initial={"body.w": 1e100})
    with Instance(unpacked) as instance:
        line = instance.refuses(lambda: (instance.start(), instance.step(0.0, 1e-3)))
        assert "the derivative of 'damper.loss' is inf" in line


def test_a_failure_names_the_state_or_the_start_value(unpacked: Unpacked) -> None:
    with Instance(unpacked) as instance:
        instance.start()
        instance.set(refs_of(unpacked, "tau"), [1e308])
        line = instance.refuses(lambda: instance.step(0.0, 1.0))
        assert "'wheel.w'" in line
        assert "?" not in line


@pytest.mark.long
def test_a_massless_speed_without_an_equation_is_named(pack: Callable[..., Unpacked]) -> None:
    """A shaft without inertia whose two springs have gone: nothing gives its speed."""
    rig = gb.Drivetrain("light")
    rig.chain(
        rig.add("body", gb.Inertia(J=1.0, w0=1.0)), rig.add("one", gb.Shaft(k=100.0, c=1.0)),
        rig.add("knot", gb.Inertia(J=0.0)), rig.add("two", gb.Shaft(k=100.0, c=1.0)), rig.add("g", gb.Fixed()),
    )  # fmt: skip
    unpacked = pack(rig, method="rodas")
    with Instance(unpacked) as instance:
        instance.start()
        instance.step(0.0, 0.1)
        refs = refs_of(unpacked, "one.c", "two.c")
        line = instance.refuses(lambda: (instance.set(refs, [0.0, 0.0]), instance.step(0.1, 0.1)))
        assert "of 'one." in line
        assert "?" not in line


# -- the token ---------------------------------------------------------------------------------------------------------


def _token(path: Path) -> str:
    with zipfile.ZipFile(path) as archive:
        return str(etree.fromstring(archive.read("modelDescription.xml")).get("guid"))


def test_the_token_is_another_for_any_other_file_but_the_binary(packed: Path) -> None:
    """Every byte of every file counts, and every name; the token itself stands in some of them."""
    with zipfile.ZipFile(packed) as archive:
        files = {name: archive.read(name) for name in archive.namelist() if not name.startswith("binaries/")}
    token = _token(packed)
    assert {name for name in files if token.encode() in files[name]} == {
        "modelDescription.xml", "sources/fmu_table.c", "resources/gearblocks.json",
    }  # fmt: skip
    plain = {name: data.replace(token.encode(), b"0" * 64) for name, data in files.items()}
    assert token_of(plain) == token
    others = {token_of({**plain, name: data[:-1] + bytes([data[-1] ^ 1])}) for name, data in plain.items()}
    others |= {token_of({n + "x" * (n == name): d for n, d in plain.items()}) for name in plain}
    assert len(others) == 2 * len(plain)
    assert token not in others


def test_what_is_described_and_what_runs_inside_change_the_token(
    model: Model, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def exported(name: str, **options: Any) -> str:
        return _token(fmu_export.export(model, tmp_path / f"{name}.fmu", platforms=(), **options))

    tokens = [exported("plain"), exported("longer", t_end=7.0), exported("steps", communication_step=1e-3)]
    tokens += [exported("patient", patience=3.0), exported("limited", max_step=1e-2)]
    core = binary.core_files()
    for name in ("gb_step.c", "gb_math.h"):
        with monkeypatch.context() as changed:
            changed.setattr(binary, "core_files", lambda name=name: {**core, name: core[name] + b"\n/* other */\n"})
            tokens.append(exported(name))
    with monkeypatch.context() as changed:
        changed.setattr(exporter, "_tool", lambda: "gearblocks of another year")
        tokens.append(exported("tool"))
    first, *others = model.program.outputs
    words = replace(model.program, outputs=OutputList.of([first._replace(words="other"), *others]))
    tokens.append(
        _token(fmu_export.export(Model(words, model.library, model.values), tmp_path / "w.fmu", platforms=()))
    )
    assert len(set(tokens)) == len(tokens)
    assert exported("again") == tokens[0]


def test_a_binary_of_other_sources_is_refused(model: Model, packed: Path, unpacked: Unpacked, tmp_path: Path) -> None:
    other = fmu_export.export(model, tmp_path / "other.fmu", t_end=0.2, platforms=())
    with pytest.raises((FMICallException, Exception), match="instantiate"), Instance(unpacked, token=_token(other)):
        pass
    assert _token(packed) == unpacked.description.guid
