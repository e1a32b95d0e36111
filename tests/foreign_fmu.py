"""An FMU that is nothing like ours: other types, other references, other manners.

It counts up by the integer input `n`, gives `x` plus the time while `on`, uses the host's memory
functions and the logger's printf arguments, returns fmi2Fatal for x below -1 and crashes below -2.
"""

import subprocess
import zipfile
from pathlib import Path

import fmpy
from compilers import HEADERS, compiler

FOREIGN = r"""
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "fmi2FunctionTypes.h"
struct m { fmi2CallbackFunctions f; double x, y; int n, count; fmi2Boolean on, odd; };
const char *fmi2GetTypesPlatform(void) { return "default"; }
const char *fmi2GetVersion(void) { return "2.0"; }
fmi2Component fmi2Instantiate(fmi2String a, fmi2Type t, fmi2String g, fmi2String r,
                              const fmi2CallbackFunctions *f, fmi2Boolean v, fmi2Boolean l) {
    struct m *m = f->allocateMemory(1, sizeof *m);
    m->f = *f;
    return m;
}
void fmi2FreeInstance(fmi2Component c) { struct m *m = c; m->f.freeMemory(m); }
fmi2Status fmi2Reset(fmi2Component c) {
    struct m *m = c; fmi2CallbackFunctions f = m->f; memset(m, 0, sizeof *m); m->f = f; return fmi2OK;
}
fmi2Status fmi2SetReal(fmi2Component c, const unsigned vr[], size_t n, const double v[]) {
    for (size_t i = 0; i < n; i++) if (vr[i] == 1000) ((struct m *)c)->x = v[i]; else return fmi2Error;
    return fmi2OK;
}
fmi2Status fmi2SetInteger(fmi2Component c, const unsigned vr[], size_t n, const int v[]) {
    for (size_t i = 0; i < n; i++) if (vr[i] == 7) ((struct m *)c)->n = v[i]; else return fmi2Error;
    return fmi2OK;
}
fmi2Status fmi2SetBoolean(fmi2Component c, const unsigned vr[], size_t n, const fmi2Boolean v[]) {
    for (size_t i = 0; i < n; i++) if (vr[i] == 7) ((struct m *)c)->on = v[i]; else return fmi2Error;
    return fmi2OK;
}
fmi2Status fmi2GetReal(fmi2Component c, const unsigned vr[], size_t n, double v[]) {
    for (size_t i = 0; i < n; i++) v[i] = vr[i] == 1000 ? ((struct m *)c)->x : ((struct m *)c)->y;
    return fmi2OK;
}
fmi2Status fmi2GetInteger(fmi2Component c, const unsigned vr[], size_t n, int v[]) {
    for (size_t i = 0; i < n; i++) v[i] = ((struct m *)c)->count;
    return fmi2OK;
}
fmi2Status fmi2GetBoolean(fmi2Component c, const unsigned vr[], size_t n, fmi2Boolean v[]) {
    for (size_t i = 0; i < n; i++) v[i] = ((struct m *)c)->odd;
    return fmi2OK;
}
fmi2Status fmi2DoStep(fmi2Component c, double t, double h, fmi2Boolean p) {
    struct m *m = c;
    if (m->x < -2) abort();
    if (m->x < -1) {
        m->f.logger(m->f.componentEnvironment, "x", fmi2Fatal, "c", "x is %g, which is %s", m->x,
                    "fatal");
        return fmi2Fatal;
    }
    m->count += m->n; m->odd = m->count % 2 != 0; m->y = m->on ? m->x + t : 0.0;
    return fmi2OK;
}
fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean a, double b, double d, fmi2Boolean e,
                               double f)
{ return fmi2OK; }
#define NONE(name, ...) fmi2Status name(fmi2Component c __VA_ARGS__) { return fmi2OK; }
NONE(fmi2EnterInitializationMode) NONE(fmi2ExitInitializationMode) NONE(fmi2Terminate)
NONE(fmi2SetDebugLogging) NONE(fmi2GetString) NONE(fmi2SetString) NONE(fmi2GetFMUstate)
NONE(fmi2SetFMUstate) NONE(fmi2FreeFMUstate) NONE(fmi2SerializedFMUstateSize)
NONE(fmi2SerializeFMUstate) NONE(fmi2DeSerializeFMUstate) NONE(fmi2GetDirectionalDerivative)
NONE(fmi2SetRealInputDerivatives) NONE(fmi2GetRealOutputDerivatives) NONE(fmi2CancelStep)
NONE(fmi2GetStatus) NONE(fmi2GetRealStatus) NONE(fmi2GetIntegerStatus) NONE(fmi2GetBooleanStatus)
NONE(fmi2GetStringStatus)
"""
DESCRIPTION = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="Foreign" guid="g">
  <CoSimulation modelIdentifier="Foreign" CAPABILITIES/>
  <ModelVariables>
    <ScalarVariable name="x" valueReference="1000" causality="input"><Real start="0"/></ScalarVariable>
    <ScalarVariable name="n" valueReference="7" causality="input" variability="discrete">
      <Integer start="0"/></ScalarVariable>
    <ScalarVariable name="on" valueReference="7" causality="input" variability="discrete">
      <Boolean start="false"/></ScalarVariable>
    <ScalarVariable name="y" valueReference="1001" causality="output"><Real/></ScalarVariable>
    <ScalarVariable name="count" valueReference="8" causality="output" variability="discrete">
      <Integer/></ScalarVariable>
    <ScalarVariable name="odd" valueReference="9" causality="output" variability="discrete">
      <Boolean/></ScalarVariable>
  </ModelVariables>
  <ModelStructure/>
</fmiModelDescription>
"""


RESTLESS = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="Restless" guid="r">
  <CoSimulation modelIdentifier="Restless" canHandleVariableCommunicationStepSize="true"
      canGetAndSetFMUstate="true"/>
  <ModelVariables>
    <ScalarVariable name="input" valueReference="0" causality="input"><Real start="0"/></ScalarVariable>
    <ScalarVariable name="restored" valueReference="1" causality="output"><Real/></ScalarVariable>
  </ModelVariables>
  <ModelStructure>
    <Outputs><Unknown index="2" dependencies=""/></Outputs>
    <InitialUnknowns><Unknown index="2" dependencies=""/></InitialUnknowns>
  </ModelStructure>
</fmiModelDescription>
"""


def build_foreign(folder: Path, capabilities: str = "") -> Path:
    """Compile the FMU into a folder, with more attributes of its CoSimulation; return its path."""
    source = folder / "Foreign.c"
    source.write_text(FOREIGN, encoding="utf-8")
    return _build("Foreign", source, DESCRIPTION.replace("CAPABILITIES", capabilities), folder)


def build_restless(folder: Path) -> Path:
    """Compile an FMU that discards steps (hosts/restless.c) into a folder; return its path."""
    return _build("Restless", Path(__file__).parent / "interop/hosts/restless.c", RESTLESS, folder)


def _build(name: str, source: Path, description: str, folder: Path) -> Path:
    binary = folder / f"{name}{fmpy.sharedLibraryExtension}"
    command = [*compiler(), "-w", "-shared", "-fPIC", f"-I{HEADERS}", str(source), "-lm"]
    subprocess.run([*command, "-o", str(binary)], check=True)
    path = folder / f"{name}.fmu"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("modelDescription.xml", description)
        archive.write(binary, f"binaries/{fmpy.platform}/{binary.name}")
    return path
