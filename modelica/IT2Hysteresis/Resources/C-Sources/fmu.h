/* The FMI 2.0 co-simulation layer, written once for all models; it holds no physics.
 *
 *   fmu_lifecycle.c    instantiate, initialisation, reset, terminate, free
 *   fmu_variables.c    get and set by value reference, input derivatives
 *   fmu_clock.h        time in integer ticks, the controller's too
 *   fmu_step.c         doStep, directional derivatives
 *   fmu_state.c        get, set, serialize and deserialize the FMU state
 *   fmu_log.c          log categories and messages
 *   fmu_parameters.c   the parameter set of a packaged FMU
 *   fmu_location.c     where the FMU's resources are
 *   fmi2_exports.h     the functions of the standard, with the model's prefix
 *
 * A call that is refused changes nothing: the instance keeps its last good state. */
#ifndef IT2HYS_FMU_H
#define IT2HYS_FMU_H

#include <stdarg.h>
#include <stdbool.h>
#include <stdint.h>

#include "chain.h"
#include "fmi2FunctionTypes.h"
#include "fmu_clock.h"

/* --- variables --------------------------------------------------------------------------------- */

struct fmu_inputs {
    double voltage;
    double reference;
    double force;
    double temperature;
    double time; /* of the tick; not a variable */
};

struct fmu_outputs {
    double displacement;
    double measured;
    double voltage;
    int saturated;
    int outOfRange;
};

struct fmu_values {
    struct chain_parameters parameter;
    struct fmu_inputs input;
    struct fmu_outputs output;
};

enum fmu_base { FMU_REAL, FMU_INTEGER, FMU_BOOLEAN, FMU_STRING };
enum fmu_causality { FMU_PARAMETER, FMU_INPUT, FMU_OUTPUT };
enum fmu_kind { FMU_PLANT = 1, FMU_INVERSE = 2 };

/* A row of the variable table; its place is the value reference. */
struct fmu_variable {
    const char *name;
    enum fmu_base base;
    enum fmu_causality causality;
    unsigned models; /* of enum fmu_kind, or-ed */
    size_t offset;   /* in struct fmu_values */
    double minimum;
    double maximum;
    size_t count; /* of an element's group: offset of the parameter that says how many are in use */
    int index;    /* of an element in its group, from 1; 0 outside any group */
};

/* --- models ------------------------------------------------------------------------------------ */

enum fmu_finding {
    FMU_VOLTAGE_RANGE = 1,
    FMU_DISPLACEMENT_RANGE = 2,
    FMU_OUT_OF_REACH = 4,
    FMU_AMPLIFIER_LIMIT = 8,
    FMU_VOLTAGE_LIMIT = 16
};

/* What distinguishes one FMU from the other. `tick` returns findings (enum fmu_finding, or-ed) that
 * are worth a warning; tangents are directional derivatives. */
struct fmu_model {
    const char *identifier;
    enum fmu_kind kind;
    uint64_t table_hash; /* of the variables that modelDescription.xml lists */
    void (*start)(const struct chain *, const struct chain_state *, const struct chain_parameters *,
                  struct fmu_outputs *);
    void (*start_tangent)(const struct chain *, const struct chain_state *,
                          const struct chain_parameters *, const struct chain_parameters *d_parameters,
                          struct fmu_outputs *d_outputs);
    unsigned (*tick)(const struct chain *, struct chain_state *, const struct chain_parameters *,
                     const struct fmu_inputs *, struct fmu_outputs *);
    struct chain_state (*tick_tangent)(const struct chain *, const struct chain_state *,
                                       const struct fmu_inputs *, struct chain_state d_state,
                                       const struct fmu_inputs *d_inputs,
                                       struct fmu_outputs *d_outputs);
};

static inline struct chain_surroundings fmu_surroundings(const struct fmu_inputs *inputs)
{
    return (struct chain_surroundings){ inputs->force, inputs->temperature, inputs->time };
}

/* --- instances --------------------------------------------------------------------------------- */

/* Bits, so that a function can name all phases in which it may be called. */
enum fmu_phase {
    FMU_INSTANTIATED = 1,
    FMU_INITIALIZATION = 2,
    FMU_STEP_COMPLETE = 4,
    FMU_TERMINATED = 8,
    FMU_ANY_PHASE = 15
};

/* The ticks of a doStep and their inputs; no padding, because it is serialized. */
struct fmu_span {
    int64_t tick; /* the step began at this one, */
    double rest;  /* and so many sample times */
    int64_t first_tick;
    int64_t end_tick;
    struct fmu_inputs input;
    struct fmu_inputs slope;
};

/* The last doStep as it began: directional derivatives repeat it. */
struct fmu_step {
    struct fmu_span span;
    struct chain_state chain;
};

/* All that an FMU state holds: a plain value without pointers. */
struct fmu_snapshot {
    int phase;
    int last_status; /* of doStep */
    struct fmu_values values;
    struct fmu_inputs slope; /* du/dt */
    struct fmu_clock clock;
    struct chain_state chain;
    struct fmu_step last_step;
    unsigned warned; /* findings already logged */
};

struct fmu {
    const struct fmu_model *model;
    struct fmu_snapshot now;
    struct chain chain; /* follows from the parameters */
    bool outputs_stale; /* in initialization: a value was set since the outputs were computed */
    struct chain_parameters start; /* what reset returns to */
    unsigned categories;
    fmi2CallbackLogger logger;
    fmi2ComponentEnvironment environment;
    char *name;
};

HIDDEN_BEGIN

/* The generated table (fmu_table.h). */
const struct fmu_variable *fmu_find(const struct fmu_model *model, fmi2ValueReference reference);
const struct fmu_variable *fmu_find_parameter(const char *name, size_t length);
void fmu_inputs_start(struct fmu_inputs *inputs);

/* Are all parameters in use within the table's bounds? If not, the message names the first that is not. */
bool fmu_within_bounds(const struct chain_parameters *parameters, char *message, size_t size);

/* Can these be values of this FMU's variables, parameters being unchecked yet? If not, the message says why. */
bool fmu_values_possible(const struct fmu *fmu, const struct fmu_values *values, char *message, size_t size);

/* --- logging ----------------------------------------------------------------------------------- */

enum fmu_category {
    FMU_LOG_EVENTS = 1,
    FMU_LOG_WARNING = 2,
    FMU_LOG_DISCARD = 4,
    FMU_LOG_ERROR = 8,
    FMU_LOG_ALL = 15
};

/* Logs a message in the category that belongs to `status` and returns `status`. */
fmi2Status fmu_say(const struct fmu *fmu, fmi2Status status, const char *format, ...);

/* Is the instance there and in one of `phases`? If not, says so and returns false. */
bool fmu_refuse(const struct fmu *fmu, const char *function);
static inline bool fmu_may(const struct fmu *fmu, const char *function, unsigned phases)
{
    return (fmu && (unsigned)fmu->now.phase & phases) || fmu_refuse(fmu, function);
}

fmi2Status fmu_set_debug_logging(struct fmu *fmu, bool on, size_t count, const fmi2String categories[]);

/* --- parameter set ----------------------------------------------------------------------------- */

/* Sets `parameters` to the set that belongs to the GUID: the one compiled in, or the one in the
 * FMU's resources. On failure false and a message. */
bool fmu_load_parameters(const struct fmu_model *model, const char *guid, const char *resources,
                         struct chain_parameters *parameters, char *message, size_t size);

/* Opens FILE in the resources at a URI; where the URI is missing, beside this binary. */
void *fmu_open_resource(const char *uri, const char *file, char *path, size_t size);

/* --- the standard's functions, without prefix --------------------------------------------------- */

struct fmu *fmu_instantiate(const struct fmu_model *model, fmi2String name, fmi2Type type,
                            fmi2String guid, fmi2String resources,
                            const fmi2CallbackFunctions *functions, bool logging);
void fmu_free(struct fmu *fmu);
fmi2Status fmu_setup(struct fmu *fmu, bool tolerance_defined, double tolerance, double start_time,
                     bool stop_time_defined, double stop_time);
fmi2Status fmu_enter_initialization(struct fmu *fmu);
fmi2Status fmu_exit_initialization(struct fmu *fmu);
fmi2Status fmu_terminate(struct fmu *fmu);
fmi2Status fmu_reset(struct fmu *fmu);

/* Computes the outputs before the first tick where they are stale, if the parameters make a usable
 * model. */
fmi2Status fmu_compute_start_outputs(struct fmu *fmu, const char *function);
static inline fmi2Status fmu_start_outputs(struct fmu *fmu, const char *function)
{
    return fmu->outputs_stale ? fmu_compute_start_outputs(fmu, function) : fmi2OK;
}

/* What is not finite is never handed out. */
bool fmu_outputs_finite(const struct fmu_outputs *output);

fmi2Status fmu_get_real(struct fmu *fmu, const fmi2ValueReference references[], size_t count,
                        double values[]);
fmi2Status fmu_get(struct fmu *fmu, const char *function, enum fmu_base base,
                   const fmi2ValueReference references[], size_t count, void *values);
fmi2Status fmu_set_real(struct fmu *fmu, const fmi2ValueReference references[], size_t count,
                        const double values[]);
fmi2Status fmu_set(struct fmu *fmu, const char *function, enum fmu_base base,
                   const fmi2ValueReference references[], size_t count, const void *values);
fmi2Status fmu_set_input_derivatives(struct fmu *fmu, const fmi2ValueReference references[],
                                     size_t count, const fmi2Integer order[], const double values[]);
fmi2Status fmu_get_output_derivatives(struct fmu *fmu);

fmi2Status fmu_do_step(struct fmu *fmu, double time, double step);
fmi2Status fmu_directional_derivative(struct fmu *fmu, const fmi2ValueReference unknowns[],
                                      size_t unknown_count, const fmi2ValueReference knowns[],
                                      size_t known_count, const double seeds[], double values[]);
fmi2Status fmu_get_status(struct fmu *fmu, const char *function, fmi2StatusKind kind, void *value);
fmi2Status fmu_cancel_step(struct fmu *fmu);

fmi2Status fmu_get_state(struct fmu *fmu, fmi2FMUstate *state);
fmi2Status fmu_set_state(struct fmu *fmu, fmi2FMUstate state);
fmi2Status fmu_free_state(struct fmu *fmu, fmi2FMUstate *state);
fmi2Status fmu_state_size(struct fmu *fmu, fmi2FMUstate state, size_t *size);
fmi2Status fmu_serialize(struct fmu *fmu, fmi2FMUstate state, fmi2Byte bytes[], size_t size);
fmi2Status fmu_deserialize(struct fmu *fmu, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state);

/* FNV-1a, 64 bit. */
uint64_t fmu_hash(const void *bytes, size_t size);

HIDDEN_END

#endif
