/* A byte string as edits of a parameter file, under a GUID that fits what became of it: whatever the
 * file says, there is no instance, or one that either initializes or says why not. */
#define _POSIX_C_SOURCE 200809L /* fmemopen */
#include <math.h>

#include "fmi2_api.h"
#include "fuzz.h"

enum { CAPACITY = 4096 };

static const char ORIGINAL[] =
    "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
    "<ssv:Parameter name=\"sampleTime\"><ssv:Real value=\"2.5e-4\" unit=\"s\"/></ssv:Parameter>\n"
    "<ssv:Parameter name=\"initialDisplacement\"><ssv:Real value=\"1e-06\"/></ssv:Parameter>\n"
    "<ssv:Parameter name=\"voltageMin\"><ssv:Real value=\"-10.5\"/></ssv:Parameter>\n"
    "<ssv:Parameter name=\"voltageMax\"><ssv:Real value=\"110.0\"/></ssv:Parameter>\n"
    "<ssv:Parameter name=\"displacementMin\"><ssv:Real value=\"0.0\"/></ssv:Parameter>\n"
    "<ssv:Parameter name=\"displacementMax\"><ssv:Real value=\"1.5e-05\"/></ssv:Parameter>\n"
    "<ssv:Parameter name=\"ruleCount\"><ssv:Integer value=\"1\"/></ssv:Parameter>\n"
    "<ssv:Parameter name=\"rule[1].sigmaLower\"><ssv:Real value=\"1e-06\"/></ssv:Parameter>\n"
    "<ssv:Parameter name=\"rule[1].sigmaUpper\"><ssv:Real value=\"2e-06\"/></ssv:Parameter>\n"
    "<ssv:Parameter name=\"rule[1].centre\"><ssv:Real value=\"3e-06\"/></ssv:Parameter>\n"
    "<ssv:Parameter name=\"rule[1].q1\"><ssv:Real value=\"0.5\"/></ssv:Parameter>\n"
    "<ssv:Parameter name=\"rule[1].q2\"><ssv:Real value=\"1e-08\"/></ssv:Parameter>\n"
    "<ssv:Parameter name=\"rule[1].q3\"><ssv:Real value=\"0.0\"/></ssv:Parameter>\n";

static const char *const PIECES[] = { "nan",
                                      "-inf",
                                      "1e999",
                                      "1e300",
                                      "-1",
                                      "16",
                                      "17",
                                      "0x1p3",
                                      "\"",
                                      "value",
                                      "<ssv:Parameter name=\"",
                                      "true",
                                      "",
                                      "2",
                                      "</ssv:Parameter>",
                                      "1e-320" };

static char text[CAPACITY]; /* of the file */

static void ignore(fmi2ComponentEnvironment environment, fmi2String instance, fmi2Status status,
                   fmi2String category, fmi2String message, ...)
{
    (void)environment, (void)instance, (void)category;
    FUZZ_PROMISE(status <= fmi2Error && strlen(message) > 0);
}

static void replace(size_t at, size_t removed, const char *piece)
{
    const size_t size = strlen(text), added = strlen(piece);

    if (at + removed > size || size - removed + added >= CAPACITY)
        return;
    memmove(text + at + added, text + at + removed, size - at - removed + 1);
    memcpy(text + at, piece, added);
}

/* The n-th value from the start: what stands between its quotes. */
static void replace_value(unsigned n, const char *piece)
{
    char *value = text;

    for (unsigned i = 0; i <= n && value; i++)
        value = strstr(value + 1, "value=\"");
    if (value)
        replace((size_t)(value + 7 - text), strcspn(value + 7, "\""), piece);
}

static void edit(struct fuzz_bytes *in)
{
    const unsigned kind = fuzz_byte(in);
    const char *piece = PIECES[fuzz_byte(in) % (sizeof PIECES / sizeof PIECES[0])];
    char number[32];
    double value;

    if (kind < 96) {
        replace_value(fuzz_byte(in) % 13, piece);
    } else if (kind < 160) {
        fuzz_take(in, &value, sizeof value);
        snprintf(number, sizeof number, "%.17g", value);
        replace_value(fuzz_byte(in) % 13, number);
    } else if (kind < 208) {
        replace(fuzz_short(in) % CAPACITY, fuzz_byte(in) % 32, piece);
    } else if (strlen(text) > 0)
        text[fuzz_short(in) % strlen(text)] = (char)(1 + fuzz_byte(in) % 255);
}

/* Instead of fmu_location.c: the file is in memory. */
void *fmu_open_resource(const char *uri, const char *file, char *path, size_t size)
{
    snprintf(path, size, "%s/%s", uri, file);
    return fmemopen(text, strlen(text), "rb");
}

static void try_to_run(const struct fmi2_api *m)
{
    static const fmi2CallbackFunctions host = { ignore, NULL, NULL, NULL, NULL };
    const fmi2ValueReference out = m->kind == FMU_PLANT ? 4 : 6, sample_time = 8;
    double value, step;
    char guid[64];

    snprintf(guid, sizeof guid, "{%016llx%016llx}", (unsigned long long)m->table_hash,
             (unsigned long long)fmu_hash(text, strlen(text)));
    fmi2Component c = m->Instantiate("x", fmi2CoSimulation, guid, ".", &host, fmi2False, fmi2False);
    if (!c)
        return;
    FUZZ_PROMISE(m->EnterInitializationMode(c) == fmi2OK);
    FUZZ_PROMISE(m->GetReal(c, &sample_time, 1, &step) == fmi2OK && isfinite(step));
    if (m->ExitInitializationMode(c) == fmi2OK) {
        FUZZ_PROMISE(m->GetReal(c, &out, 1, &value) == fmi2OK && isfinite(value));
        FUZZ_PROMISE(m->DoStep(c, 0.0, step, fmi2True) <= fmi2Discard);
        FUZZ_PROMISE(m->GetReal(c, &out, 1, &value) == fmi2OK && isfinite(value));
    }
    m->FreeInstance(c);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct fuzz_bytes in = { data, data + size };

    memcpy(text, ORIGINAL, sizeof ORIGINAL);
    while (in.next < in.end)
        edit(&in);
    try_to_run(&PLANT);
    try_to_run(&INVERSE);
    return 0;
}
