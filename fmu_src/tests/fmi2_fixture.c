#include "fmi2_fixture.h"

#include <stdarg.h>
#include <stdlib.h>

#include "fmu_start.h"

struct captured logged;

void forget_log(void)
{
    logged.count = 0;
    logged.text[0] = logged.category[0] = logged.instance[0] = '\0';
}

bool log_says(const char *text)
{
    const bool found = strstr(logged.text, text) != NULL;

    if (!found)
        fprintf(stderr, "'%s' is not in: %s\n", text, logged.text);
    return found;
}

/* Formats, as a host does: a stray percent sign would show or crash. */
static void capture(fmi2ComponentEnvironment environment, fmi2String instance, fmi2Status status,
                    fmi2String category, fmi2String message, ...)
{
    struct captured *log = environment;
    va_list arguments;

    log->count++;
    log->status = status;
    snprintf(log->instance, sizeof log->instance, "%s", instance);
    snprintf(log->category, sizeof log->category, "%s", category);
    va_start(arguments, message);
    vsnprintf(log->text, sizeof log->text, message, arguments);
    va_end(arguments);
}

const fmi2CallbackFunctions CALLBACKS = { capture, NULL, NULL, NULL, &logged };

const char *guid_of(const struct fmi2_api *api)
{
    static char guid[2][64];
    static int turn;
    char *text = guid[turn ^= 1];

    snprintf(text, sizeof guid[0], "{%016llx%016llx}", (unsigned long long)api->table_hash,
             (unsigned long long)FMU_START_HASH);
    return text;
}

const struct chain_parameters *start_parameters(void)
{
    return &FMU_START;
}

fmi2Component make(const struct fmi2_api *api)
{
    fmi2Component c =
        api->Instantiate("test", fmi2CoSimulation, guid_of(api), NULL, &CALLBACKS, fmi2False, fmi2False);

    if (!c) {
        fprintf(stderr, "no instance of %s: %s\n", api->identifier, logged.text);
        exit(1);
    }
    return c;
}

fmi2Component make_initializing(const struct fmi2_api *api, double start_time)
{
    fmi2Component c = make(api);

    CHECK(api->SetupExperiment(c, fmi2False, 0.0, start_time, fmi2False, 0.0) == fmi2OK);
    CHECK(api->EnterInitializationMode(c) == fmi2OK);
    return c;
}

fmi2Component make_running(const struct fmi2_api *api, double start_time)
{
    fmi2Component c = make_initializing(api, start_time);

    CHECK(api->ExitInitializationMode(c) == fmi2OK);
    return c;
}

fmi2Component make_in_phase(const struct fmi2_api *api, enum fmu_phase phase)
{
    if (phase == FMU_INSTANTIATED)
        return make(api);
    if (phase == FMU_INITIALIZATION)
        return make_initializing(api, 0.0);
    fmi2Component c = make_running(api, 0.0);
    if (phase == FMU_TERMINATED)
        CHECK(api->Terminate(c) == fmi2OK);
    return c;
}

fmi2ValueReference reference_of(const struct fmi2_api *api, const char *name)
{
    const struct fmu_model *model = api->kind == FMU_PLANT ? &plant_model : &inverse_model;

    for (fmi2ValueReference r = 0; r < 1000; r++) {
        const struct fmu_variable *variable = fmu_find(model, r);
        if (variable && strcmp(variable->name, name) == 0)
            return r;
    }
    fprintf(stderr, "%s has no variable %s\n", api->identifier, name);
    exit(1);
}

fmi2Status set_real(const struct fmi2_api *api, fmi2Component c, const char *name, double value)
{
    const fmi2ValueReference r = reference_of(api, name);
    return api->SetReal(c, &r, 1, &value);
}

fmi2Status set_integer(const struct fmi2_api *api, fmi2Component c, const char *name, int value)
{
    const fmi2ValueReference r = reference_of(api, name);
    return api->SetInteger(c, &r, 1, &value);
}

fmi2Status set_slope(const struct fmi2_api *api, fmi2Component c, const char *name, double value)
{
    const fmi2ValueReference r = reference_of(api, name);
    const fmi2Integer first_order = 1;
    return api->SetRealInputDerivatives(c, &r, 1, &first_order, &value);
}

double get_real(const struct fmi2_api *api, fmi2Component c, const char *name)
{
    const fmi2ValueReference r = reference_of(api, name);
    double value = NAN;
    CHECK(api->GetReal(c, &r, 1, &value) == fmi2OK);
    return value;
}

int get_integer(const struct fmi2_api *api, fmi2Component c, const char *name)
{
    const fmi2ValueReference r = reference_of(api, name);
    int value = -1;
    CHECK(api->GetInteger(c, &r, 1, &value) == fmi2OK);
    return value;
}

int get_boolean(const struct fmi2_api *api, fmi2Component c, const char *name)
{
    const fmi2ValueReference r = reference_of(api, name);
    int value = -1;
    CHECK(api->GetBoolean(c, &r, 1, &value) == fmi2OK);
    return value;
}

const char *input_of(const struct fmi2_api *api)
{
    return api->kind == FMU_PLANT ? "voltage" : "reference";
}

const char *output_of(const struct fmi2_api *api)
{
    return api->kind == FMU_PLANT ? "displacement" : "voltage";
}

double signal(const struct fmi2_api *api, double time)
{
    const double wave = sin(2.0 * 3.14159265358979323846 * 20.0 * time - 1.0);

    return api->kind == FMU_PLANT ? 52.5 + 45.0 * wave : 7.7e-6 + 7.0e-6 * wave;
}

void read_state(const struct fmi2_api *api, fmi2Component c, struct state_bytes *bytes)
{
    fmi2FMUstate state = NULL;

    CHECK(api->GetFMUstate(c, &state) == fmi2OK);
    CHECK(api->SerializedFMUstateSize(c, state, &bytes->size) == fmi2OK);
    CHECK(bytes->size <= STATE_CAPACITY);
    CHECK(api->SerializeFMUstate(c, state, bytes->byte, bytes->size) == fmi2OK);
    CHECK(api->FreeFMUstate(c, &state) == fmi2OK && state == NULL);
}

bool same_state(const struct state_bytes *a, const struct state_bytes *b)
{
    return a->size == b->size && memcmp(a->byte, b->byte, a->size) == 0;
}
