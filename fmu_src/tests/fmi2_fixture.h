/* What the tests of the FMI layer share: instances with a captured log, access by name. */
#ifndef IT2HYS_FMI2_FIXTURE_H
#define IT2HYS_FMI2_FIXTURE_H

#include <string.h>

#include "check.h"
#include "fmi2_api.h"

#define TS 1e-4 /* sampleTime of the set compiled in */

/* The captured log; the last message and how many there were. */
struct captured {
    int count;
    fmi2Status status;
    char instance[128];
    char category[64];
    char text[4096];
};
extern struct captured logged;

void forget_log(void);

/* Is `text` in the last message? Prints the message where it is not. */
bool log_says(const char *text);

extern const fmi2CallbackFunctions CALLBACKS;

const char *guid_of(const struct fmi2_api *api); /* of the FMU with the set compiled in */
const struct chain_parameters *start_parameters(void);

/* Instances in each phase; all is well or the test fails. */
fmi2Component make(const struct fmi2_api *api);
fmi2Component make_initializing(const struct fmi2_api *api, double start_time);
fmi2Component make_running(const struct fmi2_api *api, double start_time);
fmi2Component make_in_phase(const struct fmi2_api *api, enum fmu_phase phase);

/* By name. */
fmi2ValueReference reference_of(const struct fmi2_api *api, const char *name);
fmi2Status set_real(const struct fmi2_api *api, fmi2Component c, const char *name, double value);
fmi2Status set_integer(const struct fmi2_api *api, fmi2Component c, const char *name, int value);
fmi2Status set_slope(const struct fmi2_api *api, fmi2Component c, const char *name, double value);
double get_real(const struct fmi2_api *api, fmi2Component c, const char *name);
int get_integer(const struct fmi2_api *api, fmi2Component c, const char *name);
int get_boolean(const struct fmi2_api *api, fmi2Component c, const char *name);

const char *input_of(const struct fmi2_api *api);  /* voltage or reference */
const char *output_of(const struct fmi2_api *api); /* displacement or voltage */

/* The paper's kind of signal within the model's range, as value and slope at a time. */
double signal(const struct fmi2_api *api, double time);

/* An instance's state, serialized: equal bytes, equal instances. */
enum { STATE_CAPACITY = 8192 };
struct state_bytes {
    size_t size;
    fmi2Byte byte[STATE_CAPACITY];
};
void read_state(const struct fmi2_api *api, fmi2Component c, struct state_bytes *bytes);
bool same_state(const struct state_bytes *a, const struct state_bytes *b);

#endif
