"""FMUs as others make them, for tests of check(): built from foreign.c, which knows nothing of gearblocks."""

from __future__ import annotations

import zipfile
from dataclasses import dataclass, field
from pathlib import Path

import fmpy

from fmu_export.binary import native_platform
from gearblocks.solver.compiler import SHARED_SUFFIX, find_compiler

_SOURCE = Path(__file__).with_name("foreign.c")
_HEADERS = Path(fmpy.__file__).parent / "c-code"

OSCILLATOR = """
enum { N_REALS = 4 }; /* x, v, mu, u */
#define START {2.0, 0.0, 1.0, 0.0}
#define OWN_STEP 0.01
static void advance(double *t, double *y) {
    const double v = y[1];
    y[1] += OWN_STEP * (y[2] * (1.0 - y[0] * y[0]) * y[1] - y[0] + y[3]);
    y[0] += OWN_STEP * v;
    *t += OWN_STEP;
}
"""
BALL = """
enum { N_REALS = 4 }; /* height, speed, restitution, u */
#define START {1.0, 0.0, 0.7, 0.0}
#define OWN_STEP 0.001
static void advance(double *t, double *y) {
    y[1] -= OWN_STEP * 9.81;
    y[0] += OWN_STEP * y[1];
    if (y[0] < 0.0 && y[1] < 0.0) {
        y[0] = 0.0;
        y[1] = y[1] < -0.1 ? -y[2] * y[1] : 0.0;
    }
    *t += OWN_STEP;
}
"""

_DESCRIPTION = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="foreign" guid="{{foreign}}" numberOfEventIndicators="0">
  <CoSimulation modelIdentifier="foreign" canHandleVariableCommunicationStepSize="true" {flags}>
{sources}  </CoSimulation>
  <LogCategories><Category name="logStatusError"/></LogCategories>
  <DefaultExperiment startTime="{begin}" stopTime="{stop}" stepSize="0.01"/>
  <ModelVariables>
    <ScalarVariable name="x" valueReference="0" causality="output" variability="continuous" initial="exact">
      <Real start="{x}"/></ScalarVariable>
    <ScalarVariable name="v" valueReference="1" causality="output" variability="continuous" initial="exact">
      <Real start="0"/></ScalarVariable>
    <ScalarVariable name="mu" valueReference="2" causality="parameter" variability="fixed" initial="exact">
      <Real start="{mu}"/></ScalarVariable>
    <ScalarVariable name="u" valueReference="3" causality="input" variability="continuous">
      <Real start="0.0" min="-1"/></ScalarVariable>
    <ScalarVariable name="number" valueReference="0" causality="parameter" variability="fixed" initial="exact">
      <Integer start="3"/></ScalarVariable>
    <ScalarVariable name="truth" valueReference="0" causality="input" variability="discrete">
      <Boolean start="true"/></ScalarVariable>
    <ScalarVariable name="text" valueReference="0" causality="parameter" variability="fixed" initial="exact">
      <String start="some text"/></ScalarVariable>
  </ModelVariables>
  <ModelStructure><Outputs><Unknown index="1"/><Unknown index="2"/></Outputs></ModelStructure>
</fmiModelDescription>
"""


@dataclass(frozen=True)
class Foreign:
    """What differs between them. defines: macros of foreign.c; part: the model; listed: whether sources are listed."""

    defines: tuple[str, ...] = ("-DSTRICT",)
    part: str = OSCILLATOR
    flags: str = 'canGetAndSetFMUstate="true"'
    listed: bool = True
    begin: float = 0.0
    stop: float = 5.0
    start: tuple[float, float] = (2.0, 1.0)
    """Of x and mu in the description."""
    without_sources: bool = False
    more: dict[str, bytes] = field(default_factory=dict)

    def write(self, path: Path, folder: Path) -> Path:
        """The FMU at `path`, built in `folder`."""
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "part.inc").write_text(self.part, encoding="utf-8")
        (folder / "foreign.c").write_bytes(_SOURCE.read_bytes())
        library = folder / ("foreign" + SHARED_SUFFIX)
        flags = ("-fPIC", "-shared", "-O1", "-w", f"-I{_HEADERS}", *self.defines)
        find_compiler().run((*flags, "foreign.c", "-o", library.name), folder)
        sources = '    <SourceFiles><File name="all.c"/></SourceFiles>\n' if self.listed else ""
        description = _DESCRIPTION.format(
            flags=self.flags, sources=sources, begin=self.begin, stop=self.stop, x=self.start[0], mu=self.start[1]
        )
        files = {
            "modelDescription.xml": description.encode(),
            f"binaries/{native_platform()}/{library.name}": library.read_bytes(),
            "documentation/index.html": b"<html></html>",
        }
        if not self.without_sources:  # one file that includes the others, and one that is for another system
            files["sources/all.c"] = b'#include "foreign.c"\n'
            files["sources/foreign.c"] = _SOURCE.read_bytes()
            files["sources/part.inc"] = self.part.encode()
            files["sources/windows_only.c"] = b'#error "not here"\n'
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
            for name, data in {**files, **self.more}.items():
                archive.writestr(name, data)
        return path
