"""docs/modelica.md: its examples run, and every component of Modelica's packages has a row with a state."""

import re
from pathlib import Path

import pytest

PAGE = (Path(__file__).parents[2] / "docs" / "modelica.md").read_text(encoding="utf-8")
EXAMPLES = [
    (section.split("\n")[0].strip("# "), code)
    for section in re.split(r"\n(?=## )", PAGE)
    for code in re.findall(r"```python\n(.*?)```", section, flags=re.DOTALL)
]
ROWS = re.findall(
    r"^\| (.+?) \| (\w+) \| (.+) \|$", PAGE.split("\n## Components\n")[1].split("\n## ")[0], flags=re.MULTILINE
)

COMPONENTS = re.findall(
    r"\S+",
    """
    R.Inertia T.Mass R.Fixed T.Fixed R.Spring R.SpringDamper T.Spring T.SpringDamper R.Damper T.Damper R.ElastoBacklash
    R.ElastoBacklash2 T.ElastoGap R.BearingFriction T.SupportFriction R.Brake T.Brake R.Clutch R.OneWayClutch
    R.FreeWheel R.IdealGear T.IdealGear T.IdealLever R.Coupling R.IdealPlanetary R.LossyGear R.Gearbox R.IdealGearR2T
    R.IdealRollingWheel R.Disc T.Rod T.MassWithStopAndFriction T.RollingResistance T.Vehicle R.RelativeStates
    T.RelativeStates R.InitializeFlange T.InitializeFlange R.AngleToTorqueAdaptor R.TorqueToAngleAdaptor
    R.GeneralAngleToTorqueAdaptor R.GeneralTorqueToAngleAdaptor T.GeneralForceToPositionAdaptor
    T.GeneralPositionToForceAdaptor R.Torque R.ConstantTorque R.TorqueStep T.Force T.ConstantForce T.ForceStep R.Torque2
    T.Force2 R.LinearSpeedDependentTorque R.QuadraticSpeedDependentTorque T.LinearSpeedDependentForce
    T.QuadraticSpeedDependentForce R.InverseSpeedDependentTorque R.SignTorque T.InverseSpeedDependentForce T.SignForce
    R.EddyCurrentTorque T.EddyCurrentForce R.Speed R.ConstantSpeed T.Speed T.ConstantSpeed R.Position T.Position
    R.Accelerate T.Accelerate R.Move T.Move R.AngleSensor R.SpeedSensor R.AccSensor R.RelAngleSensor R.RelSpeedSensor
    R.RelAccSensor T.PositionSensor T.SpeedSensor T.AccSensor T.RelPositionSensor T.RelSpeedSensor T.RelAccSensor
    R.TorqueSensor R.PowerSensor R.MultiSensor T.ForceSensor T.PowerSensor T.MultiSensor Flange_a Flange_b Support
    InternalSupport PartialOneFlange PartialCompliant PartialFriction PartialElementaryConditionalHeatPort HeatCapacitor
    ThermalConductor Convection FixedTemperature Sine Step Ramp Pulse Trapezoid CombiTimeTable
""",
)


@pytest.mark.few(1)
@pytest.mark.parametrize(("section", "code"), EXAMPLES, ids=[section for section, _ in EXAMPLES])
def test_an_example_of_the_dictionary_runs(section: str, code: str) -> None:
    exec(compile(code, f"docs/modelica.md, {section}", "exec"), {})  # noqa: S102  the page's own code


def test_every_component_has_a_row_with_a_state() -> None:
    names = {name for row, _, _ in ROWS for name in re.findall(r"[\w.]+", row)}
    assert [name for name in COMPONENTS if name not in names] == []
    assert {state for _, state, _ in ROWS if state != "state"} == {"have", "composition", "not"}
    assert all(what.strip() for _, _, what in ROWS)


def test_a_composition_names_a_section_of_the_page() -> None:
    sections = re.findall(r"^## (.+)$", PAGE, flags=re.MULTILINE)
    for row, state, what in ROWS:
        if state == "composition":
            assert any(section in what for section in sections) or "`" in what, row
