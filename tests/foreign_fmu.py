"""An FMU that is nothing like ours: other types, other references, other manners.

It counts up by the integer input `n`, gives `x` plus the time while `on`, uses the host's memory
functions and the logger's printf arguments, returns fmi2Fatal for x below -1 and crashes below -2.
"""

import subprocess
import zipfile
from pathlib import Path

import fmpy
from compilers import HEADERS, compiler
from fmpy import fmi3

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


FOREIGN_3 = r"""
#include <stdlib.h>
#include <string.h>
#include "fmi3PlatformTypes.h"
typedef void logger(void *, int, const char *, const char *);
struct m { logger *log; double x, y, gain[2]; int n, count; long long mode; bool on, odd; };
static const struct m START = { .gain = { 1.0, 0.0 } };
void *fmi3InstantiateCoSimulation(const char *a, const char *b, const char *c, bool d, bool e, bool f,
                                  bool g, const unsigned h[], size_t i, void *j, logger *log, void *k) {
    struct m *m = malloc(sizeof *m);
    *m = START; m->log = log;
    return m;
}
void fmi3FreeInstance(void *c) { free(c); }
int fmi3Reset(void *c) { struct m *m = c; logger *log = m->log; *m = START; m->log = log; return 0; }
int fmi3SetFloat64(struct m *m, const unsigned vr[], size_t n, const double v[], size_t k) {
    for (size_t i = 0; i < n; i++)
        if (vr[i] == 1000) { m->x = *v++; k--; }
        else if (vr[i] == 20) { memcpy(m->gain, v, sizeof m->gain); v += 2; k -= 2; }
        else return 3;
    return k ? 3 : 0;
}
int fmi3SetInt32(struct m *m, const unsigned vr[], size_t n, const int v[], size_t k)
{ m->n = *v; return vr[0] == 7 && n == 1 && k == 1 ? 0 : 3; }
int fmi3SetInt64(struct m *m, const unsigned vr[], size_t n, const long long v[], size_t k)
{ m->mode = *v; return vr[0] == 30 && n == 1 && k == 1 ? 0 : 3; }
int fmi3SetBoolean(struct m *m, const unsigned vr[], size_t n, const bool v[], size_t k)
{ m->on = *v; return vr[0] == 6 && n == 1 && k == 1 ? 0 : 3; }
int fmi3GetFloat64(struct m *m, const unsigned vr[], size_t n, double v[], size_t k) {
    for (size_t i = 0; i < n; i++)
        if (vr[i] == 20) { memcpy(v, m->gain, sizeof m->gain); v += 2; k--; }
        else *v++ = vr[i] == 50 ? 0.1 : vr[i] == 1000 ? m->x : m->y;
    return k == n ? 0 : 3;
}
int fmi3GetInt32(struct m *m, const unsigned vr[], size_t n, int v[], size_t k)
{ *v = m->count; return k == n ? 0 : 3; }
int fmi3GetBoolean(struct m *m, const unsigned vr[], size_t n, bool v[], size_t k)
{ *v = m->odd; return k == n ? 0 : 3; }
int fmi3DoStep(struct m *m, double t, double h, bool p, bool *event, bool *end, bool *early,
               double *last) {
    *event = *early = false; *last = t + h;
    *end = m->x < -1;
    m->count += m->n; m->odd = m->count % 2 != 0;
    m->y = m->on ? m->gain[0] * m->x + m->gain[1] * t + (double)m->mode : 0.0;
    if (m->count > 1000) m->log(NULL, 1, "c", "that is a lot");
    return m->count > 1000;
}
"""
DESCRIPTION_3 = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="3.0" modelName="Foreign3" instantiationToken="g">
  <CoSimulation modelIdentifier="Foreign3"/>
  <TypeDefinitions>
    <EnumerationType name="Mode"><Item name="a" value="1"/><Item name="b" value="5"/></EnumerationType>
  </TypeDefinitions>
  <ModelVariables>
    <Float64 name="x" valueReference="1000" causality="input" start="0"/>
    <Int32 name="n" valueReference="7" causality="input" start="0"/>
    <Boolean name="on" valueReference="6" causality="input" start="false"/>
    <Float64 name="part.gain" valueReference="20" causality="parameter" variability="fixed" start="1 0">
      <Dimension start="2"/></Float64>
    <Enumeration name="mode" declaredType="Mode" valueReference="30" causality="parameter"
      variability="fixed" start="0"/>
    <Float64 name="y" valueReference="1001" causality="output"/>
    <Int32 name="count" valueReference="8" causality="output"/>
    <Boolean name="odd" valueReference="9" causality="output"/>
    <Binary name="blob" valueReference="40" causality="local" variability="discrete"/>
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


def build_foreign_3(folder: Path) -> Path:
    """Compile an FMU of FMI 3.0 with variables of many types into a folder; return its path."""
    missing = [name for name in dir(fmi3.FMU3Slave) if name.startswith("fmi3")]
    stubs = [f"int {name}(void) {{ return 0; }}\n" for name in missing if f" {name}(" not in FOREIGN_3]
    stubs = [s for s in stubs if f"*{s[4 : s.index('(')]}(" not in FOREIGN_3]
    source = folder / "Foreign3.c"
    source.write_text(FOREIGN_3 + "".join(stubs), encoding="utf-8")
    return _build("Foreign3", source, DESCRIPTION_3, folder, fmpy.platform_tuple)


def build_restless(folder: Path) -> Path:
    """Compile an FMU that discards steps (hosts/restless.c) into a folder; return its path."""
    return _build("Restless", Path(__file__).parent / "interop/hosts/restless.c", RESTLESS, folder)


def _build(
    name: str, source: Path, description: str, folder: Path, platform: str = fmpy.platform
) -> Path:
    binary = folder / f"{name}{fmpy.sharedLibraryExtension}"
    command = [*compiler(), "-w", "-shared", "-fPIC", f"-I{HEADERS}", str(source), "-lm"]
    subprocess.run([*command, "-o", str(binary)], check=True)
    path = folder / f"{name}.fmu"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("modelDescription.xml", description)
        archive.write(binary, f"binaries/{platform}/{binary.name}")
    return path
