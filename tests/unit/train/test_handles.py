"""Handles: flanges and fields of a part as attributes, also by its path; hasattr understands what a part has not."""

from __future__ import annotations

import copy
import pickle

import pytest

import gearblocks as gb
from gearblocks.errors import UnknownAttributeError
from gearblocks.train.handles import FlangeHandle, Handle


def _rig() -> gb.Drivetrain:
    inner = gb.Drivetrain("stage")
    body = inner.add("body", gb.Inertia(J=1.0))
    inner.expose("input", body.a)
    rig = gb.Drivetrain("rig")
    rig.add("mesh", gb.GearMesh(teeth=(20, 30), external=True, r_base=(0.02, 0.03), k=1e8))
    rig.add("stage", inner)
    rig.add("disc", gb.Inertia(J=0.1))
    return rig


def test_a_part_by_its_path_is_what_add_returned() -> None:
    rig = _rig()
    disc = rig.add("more", gb.Inertia(J=0.2))
    assert rig["more"] == disc
    assert hash(rig["more"]) == hash(disc)
    assert rig["more"] != rig["disc"]
    rig.connect(rig["mesh"].pinion, rig["disc"].a, rig["stage"].input)
    rig.chain(rig["disc"], rig["more"])
    assert rig.flanges("more.a")[0].value == "joined to disc.b"


def test_flanges_and_fields_are_attributes() -> None:
    mesh = _rig()["mesh"]
    assert isinstance(mesh.pinion, FlangeHandle)
    assert mesh.flanges == ("pinion", "wheel", "carrier")
    assert mesh.k == 1e8
    assert mesh.teeth == (20, 30)
    assert mesh.effects() == {"compliance": 1e8}
    assert {"pinion", "k", "teeth", "flanges", "part"} <= set(dir(mesh))
    assert isinstance(mesh.part, gb.GearMesh)


def test_a_part_of_a_train_inside_is_reached_by_its_path_but_not_connected_past_it() -> None:
    rig = _rig()
    assert rig["stage.body"].J == 1.0
    assert isinstance(rig["stage"].part, gb.Drivetrain)
    assert isinstance(rig["stage"].input, FlangeHandle)
    with pytest.raises(gb.ModelError, match="is no flange of 'rig'"):
        rig.connect(rig["stage.body"].b, rig["disc"].a)


def test_what_a_part_has_not_is_named_and_hasattr_works() -> None:
    mesh = _rig()["mesh"]
    assert hasattr(mesh, "wheel") and hasattr(mesh, "k")
    assert not hasattr(mesh, "pinon")
    assert not hasattr(mesh, "_repr_html_")
    assert getattr(mesh, "whel", None) is None
    for error in (UnknownAttributeError, gb.ModelError, AttributeError):
        with pytest.raises(
            error, match=r"'mesh' \(GearMesh\) has no flange 'pinon' and no such field; flanges: pinion, whe"
        ):
            _ = mesh.pinon
    with pytest.raises(gb.ModelError, match="did you mean 'stiffness'"):
        _ = mesh.stifness


def test_a_handle_stands_for_its_part_where_a_part_is_wanted() -> None:
    rig, other = _rig(), gb.Drivetrain("other")
    other.add("mesh", rig["mesh"])
    other.add("stage", rig["stage"])
    assert other["mesh"] == rig["mesh"]
    assert other["stage.body"] == rig["stage.body"]
    changed = rig.set({"mesh": rig["mesh"].changed(k=2e8), "disc": rig["stage.body"]})
    assert (changed["mesh"].k, changed["disc"].J) == (2e8, 1.0)
    assert isinstance(changed["disc"], Handle)


def test_a_train_tells_which_parts_it_has() -> None:
    rig = _rig()
    assert [*rig] == ["mesh", "stage", "disc"]
    assert "mesh" in rig
    assert "stage.body" in rig
    assert not [x for x in ("msh", "mesh.k", "stage.lost", "", 3) if x in rig]


def test_a_path_of_nothing_is_named() -> None:
    with pytest.raises(gb.ModelError, match="'rig' has no part 'msh' - did you mean 'mesh'"):
        _ = _rig()["msh"]
    with pytest.raises(gb.ModelError, match="mesh is a block and has no parts"):
        _ = _rig()["mesh.k"]


def test_values_are_not_set_through_a_handle() -> None:
    rig = _rig()
    for name, value in (("k", 3e8), ("backlash", None), ("teeth", (1, 2))):
        with pytest.raises(
            UnknownAttributeError, match=rf"'mesh' \(GearMesh\) is frozen, {name} = .*rig.set.*mesh.{name}"
        ):
            setattr(rig["mesh"], name, value)
    with pytest.raises(UnknownAttributeError, match=r"rig.set\(\{'body.J': 3\}\)"):
        rig["stage.body"].J = 3
    with pytest.raises(UnknownAttributeError, match="did you mean 'J'"):
        rig["disc"].j = 3
    with pytest.raises(UnknownAttributeError, match=r"rig\.set"):
        rig["stage"].body = gb.Inertia(J=2.0)
    with pytest.raises(UnknownAttributeError, match=r"rig\.set"):
        del rig["disc"].J
    assert (rig["mesh"].k, rig["disc"].J, rig["stage.body"].J) == (1e8, 0.1, 1.0)
    assert rig.set({"body.J": 3})["stage.body"].J == 3


def test_a_train_and_a_run_say_where_what_they_have_not_is() -> None:
    rig = _rig()
    assert not hasattr(rig, "mash") and getattr(rig, "mash", 3) == 3
    assert copy.copy(rig).name == rig.name and not hasattr(rig, "__array__")
    for name, words in (("simulate", r"gb\.simulate\(rig"), ("mesh", r"rig\['mesh'\]"), ("w", r"rig\.outputs\(\)")):
        with pytest.raises(UnknownAttributeError, match=rf"a Drivetrain has no attribute '{name}'; .*{words}"):
            getattr(rig, name)
    body = gb.Drivetrain("body")
    body.add("disc", gb.Inertia(J=0.1, w0=1.0))
    run = gb.simulate(body, t_end=0.1)
    assert pickle.loads(pickle.dumps(run))["disc.w"][-1] == 1.0 and copy.deepcopy(run).t[-1] == 0.1
    for name, words in (("w", r"run\['disc\.w'\]"), ("rmss", r"run\.names lists"), ("modes", r"gb\.modes\(run")):
        with pytest.raises(UnknownAttributeError, match=rf"a Trajectory has no attribute '{name}'.*; .*{words}"):
            getattr(run, name)


def test_a_handle_shows_its_values_as_they_were_given() -> None:
    rig = gb.Drivetrain("rig")
    shaft = rig.add("shaft", gb.Shaft(k="20 kN m/rad", c=4e-5))
    assert repr(shaft) == repr(rig["shaft"]) == "<shaft: Shaft(k = 20 kN m/rad, c = 4e-5 N m s/rad)>"


def test_a_train_counts_its_parts_and_is_true_without_any() -> None:
    rig = _rig()
    assert len(rig) == len(list(rig)) == 3
    empty = gb.Drivetrain("empty")
    assert len(empty) == 0 and bool(empty)
