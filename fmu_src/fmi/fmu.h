/* The co-simulation layer, written once for all models and for all versions of FMI; it holds no physics.
 *
 *   fmu_lifecycle.c    instantiate, initialisation, reset, terminate, free
 *   fmu_variables.c    get and set by value reference, input derivatives
 *   fmu_clock.h        time in integer ticks
 *   fmu_step.c         doStep
 *   fmu_plain.h        its way through plain steps, for where a host calls it
 *   fmu_update.c       doStep with a host that sets inputs within it, or lets it end early
 *   fmu_arrays.c       groups of parameters as arrays, whose length a host may change
 *   fmu_derivative.c   directional derivatives
 *   fmu_adjoint.c      adjoint derivatives
 *   fmu_state.c        get, set, serialize and deserialize the FMU state
 *   fmu_log.c          log categories and messages
 *   fmu_parameters.c   the parameter set of a packaged FMU
 *   fmu_location.c     where the FMU's resources are
 *   fmi2_functions.h   the functions of FMI 2.0: they translate, and do nothing else
 *   fmi3_functions.h   those of FMI 3.0
 *
 * A model is a struct fmu_model: its table of variables, and what it does at its start and at a tick. The
 * functions of a version of FMI hand over their own name, which messages begin with. A call that is refused
 * changes nothing: the instance keeps its last good state. */
#ifndef IT2HYS_FMU_H
#define IT2HYS_FMU_H

#include <math.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "fmu_clock.h"
#include "hidden.h"

/* Of functions that a host calls at every step: they begin where a cache line does, so that they take as few of them
 * as can be. Where they would begin otherwise is chance, and a tenth of what this layer takes (measured). */
#if defined __GNUC__
#define EVERY_STEP __attribute__((aligned(64)))
#else
#define EVERY_STEP
#endif

/* Of conditions: a processor runs straight through what the compiler lays out in one line. */
#if defined __GNUC__
#define USUALLY(condition) __builtin_expect(!!(condition), 1)
#else
#define USUALLY(condition) (condition)
#endif

/* The numbers are those of FMI. */
enum fmu_status { FMU_OK, FMU_WARNING, FMU_DISCARD, FMU_ERROR };

/* --- variables --------------------------------------------------------------------------------- */

enum fmu_base { FMU_REAL, FMU_INTEGER, FMU_BOOLEAN, FMU_STRING };
enum fmu_causality { FMU_PARAMETER, FMU_INPUT, FMU_OUTPUT };

/* Room for the inputs, which are Real, and for the outputs of any model here: what a step copies has a size
 * that the compiler knows. */
enum { FMU_INPUTS = 4, FMU_REAL_OUTPUTS = 2, FMU_FLAGS = 2 };

struct fmu_outputs {
    double real[FMU_REAL_OUTPUTS];
    int flag[FMU_FLAGS]; /* Boolean */
};

/* A row of a variable table; its place in it is the value reference. */
struct fmu_variable {
    const char *name;
    enum fmu_base base;
    enum fmu_causality causality;
    unsigned kinds; /* of models that have it, or-ed */
    size_t offset;  /* in the parameters, the inputs or struct fmu_outputs */
    double minimum;
    double maximum;
    size_t count;    /* of an element's group: offset of the parameter that says how many are in use */
    int index;       /* of an element in its group, from 1; 0 outside any group */
    unsigned stride; /* rows to the same field of the group's next element */
};

/* --- models ------------------------------------------------------------------------------------ */

/* Among the findings of a tick: its outputs or its state are no finite numbers. */
#define FMU_NOT_FINITE 0x80000000u

/* Parameters are a struct that begins with the sample time, a double, and has zeros in its padding; states
 * consist of doubles; constants follow from the parameters. The layer knows no more of them than their size.
 * In directional derivatives, d_ is the derivative of what has the name without it. */
struct fmu_model {
    const char *identifier;
    const struct fmu_variable *table;
    unsigned rows;       /* of the table */
    unsigned kind;       /* the rows with this bit are this model's */
    uint64_t table_hash; /* of these, with which the GUID begins */
    double input_start[FMU_INPUTS];
    size_t parameters_size;
    size_t constants_size;
    size_t state_size;
    const char *diverging; /* what the message says of FMU_NOT_FINITE */
    bool interpolates;     /* takes input derivatives */

    /* Are the parameters usable? If not, the message names the first that is not. */
    bool (*check)(const struct fmu_model *, const void *parameters, char *message, size_t size);

    /* Returns how many bytes of the state are in use, from its beginning. */
    size_t (*prepare)(void *constants, const void *parameters);

    /* What is worth its while before many ticks only, and changes their results by no more than rounding: between
     * `prepare` and the first tick. Constants are zeros at first and stay from one run to the next, so that what
     * was made of the same parameters need not be made again. Returns whether `short_tick` and `ticks` have a short way
     * now. NULL: nothing. */
    bool (*settle)(void *constants);

    /* State and outputs before the first tick; false, and why, where they are not finite. */
    bool (*start)(const void *constants, void *state, const void *parameters, struct fmu_outputs *,
                  char *message, size_t size);

    /* Returns findings, bits of the model's own or FMU_NOT_FINITE, each of which is logged once. Where it is not
     * finite, outputs stay as they were. */
    unsigned (*tick)(const void *constants, void *state, const void *parameters, const double input[FMU_INPUTS],
                     double time, struct fmu_outputs *);

    /* The same as `tick` by a shorter way, and `tick` itself where that has to be left. Where `settle` has said that
     * there is a way. */
    unsigned (*short_tick)(const void *constants, void *state, const void *parameters,
                           const double input[FMU_INPUTS], double time, struct fmu_outputs *);

    /* Runs ticks under one input, at most `count`, up to the first that has findings, and returns how many: the same as
     * `tick` for each, by a shorter way. It may run fewer, or none. Where `settle` has said that there is a way. */
    int64_t (*ticks)(const void *constants, void *state, const double input[FMU_INPUTS], int64_t count,
                     struct fmu_outputs *);

    /* Writes what a finding means; NULL where there are none. */
    void (*explain)(unsigned finding, const void *state, const void *parameters, const double input[FMU_INPUTS],
                    double time, const struct fmu_outputs *, char *text, size_t size);

    /* NULL where the model has none. tick_tangent leaves `state` as it is. */
    void (*start_tangent)(const void *constants, const void *state, const void *parameters,
                          const void *d_parameters, struct fmu_outputs *d_output);
    void (*tick_tangent)(const void *constants, const void *state, const double input[FMU_INPUTS], double time,
                         void *d_state, const double d_input[FMU_INPUTS], struct fmu_outputs *d_output);
};

/* The parameter set compiled in, and the hash with which its GUID ends. */
struct fmu_set {
    uint64_t hash;
    const void *parameters;

    /* Finds the set of another hash in the resources; NULL where there are no others. */
    bool (*find)(const struct fmu_model *, uint64_t hash, const char *resources, void *parameters,
                 char *message, size_t size);
};

/* --- instances --------------------------------------------------------------------------------- */

/* Bits, so that a function can name all phases in which it may be called. */
enum fmu_phase {
    FMU_INSTANTIATED = 1,
    FMU_INITIALIZATION = 2,
    FMU_STEP_COMPLETE = 4,
    FMU_TERMINATED = 8,
    FMU_CONFIGURATION = 16, /* of hosts that resize */
    FMU_ANY_PHASE = 31,
    FMU_UPDATE = 32, /* within doStep, while the host sets inputs */
    FMU_INITIALIZED = FMU_STEP_COMPLETE | FMU_TERMINATED | FMU_UPDATE
};

/* The ticks of a doStep and their inputs. */
struct fmu_span {
    int64_t tick; /* the step began at this one, */
    double rest;  /* and so many sample times */
    int64_t first_tick;
    int64_t end_tick;
    double input[FMU_INPUTS];
    double slope[FMU_INPUTS];
};

/* All that an FMU state holds is this, and behind it the parameters, the state, and the state that the last
 * step began with: a plain value without pointers or padding. */
struct fmu_snapshot {
    int phase;
    int last_status; /* of doStep */
    uint64_t warned; /* findings already logged */
    struct fmu_clock clock;
    double input[FMU_INPUTS];
    double slope[FMU_INPUTS]; /* du/dt */
    struct fmu_outputs output;
    struct fmu_span last_step; /* directional derivatives repeat it: fmu_last_step */
    uint64_t one_tick; /* the last step was the tick before this one under constant inputs: of last_step, */
}; /* only the inputs are its */

/* The host that an instance talks to. */
struct fmu_host {
    void (*log)(const struct fmu_host *, const char *instance, enum fmu_status, const char *category,
                const char *text);
    void (*logger)(void); /* the host's own function; its type is known to `log` */
    void *environment;

    /* Called at the ticks within a step, s, where the host may then set inputs; NULL where it does not want to.
     * True, and when, where the step is to end early. */
    bool (*update)(const struct fmu_host *, double time, double *end);
    void (*updater)(void); /* the host's own function for it */
    bool ends_early;       /* takes it that a step ends before its end */
    bool resizes;          /* sets the numbers of elements, in their phase, up to the table's bounds */
    unsigned reads;        /* phases before initialization in which it gets values */
};

/* Inputs and outputs by value reference, as far as their places in the snapshot are found at once; those of other
 * references take the long way. */
enum { FMU_PORTS = 256 };
enum { FMU_REAL_PORT = FMU_INPUTS, FMU_FLAG_PORT = FMU_REAL_PORT + FMU_REAL_OUTPUTS, FMU_NO_PORT = 255 };

/* A plain step goes from one tick to the next under constant inputs, and follows such a step that ended well. Most
 * steps are plain, and all that has to be asked of them is this. */
struct fmu_plain {
    double step; /* their length; NAN where the next step is none, or not known to be one */
    double off;  /* how far the master's time may be from the clock's */
    double end;  /* the latest that one may end */
};

struct fmu {
    const struct fmu_model *model;
    struct fmu_plain plain;
    unsigned (*tick)(const void *constants, void *state, const void *parameters, const double input[FMU_INPUTS],
                     double time, struct fmu_outputs *); /* the model's, by the shortest way */
    void *parameters;                                    /* these two are behind *now, in one block with it */
    void *state;
    void *last_state; /* behind these, or in the other room: fmu_gather */
    void *before;     /* that room; beyond what is in use of a state, both are the same */
    void *constants;
    void *d_state; /* room for derivatives */
    void *d_parameters;
    void *start;        /* the parameters that reset returns to */
    size_t used;        /* bytes of the state */
    bool outputs_stale; /* in initialization: a value was set since the outputs were computed */
    bool ramps;         /* an input has a slope */
    bool short_way;     /* `ticks` is worth its call */
    unsigned categories;
    unsigned char port[FMU_PORTS]; /* an input's place, FMU_REAL_PORT + a Real output's, ... */
    struct fmu_host host;
    const char *name;
    struct fmu_snapshot now[]; /* one, where nothing has to be read to find it; the rest of the block follows */
};

HIDDEN_BEGIN

static inline double fmu_sample_time(const struct fmu *fmu)
{
    return *(const double *)fmu->parameters;
}

/* Before every change, other than a step's own, of what a plain step takes for granted: phase, clock, status, slopes,
 * and what the last step was. */
static inline void fmu_leave_plain(struct fmu *fmu)
{
    fmu->plain.step = NAN;
}

/* After every change of the slopes. */
static inline void fmu_note_ramps(struct fmu *fmu)
{
    fmu_leave_plain(fmu);
    fmu->ramps = false;
    for (int i = 0; i < FMU_INPUTS; i++)
        fmu->ramps |= fmu->now->slope[i] != 0.0;
}

/* Of the snapshot with what is behind it. */
static inline size_t fmu_snapshot_size(const struct fmu_model *model)
{
    return sizeof(struct fmu_snapshot) + model->parameters_size + 2 * model->state_size;
}

/* Before ticks; every instance does it, so that all of them give the same bits. */
static inline void fmu_settle(struct fmu *fmu)
{
    fmu->short_way = fmu->model->settle && fmu->model->settle(fmu->constants);
    fmu->tick = fmu->short_way ? fmu->model->short_tick : fmu->model->tick;
}

static inline const struct fmu_variable *fmu_find(const struct fmu_model *model, unsigned reference)
{
    const struct fmu_variable *row = model->table + reference;

    return reference < model->rows && row->kinds & model->kind ? row : NULL;
}

const struct fmu_variable *fmu_find_parameter(const struct fmu_model *model, const char *name, size_t length);

/* Are all parameters in use within the table's bounds? If not, the message names the first that is not. */
bool fmu_within_bounds(const struct fmu_model *model, const void *parameters, char *message, size_t size);

/* Can these be values of this FMU's variables, parameters being unchecked yet? If not, the message says why. */
bool fmu_values_possible(const struct fmu *fmu, const struct fmu_snapshot *snapshot, const void *parameters,
                         char *message, size_t size);

/* --- logging ----------------------------------------------------------------------------------- */

enum fmu_category {
    FMU_LOG_EVENTS = 1,
    FMU_LOG_WARNING = 2,
    FMU_LOG_DISCARD = 4,
    FMU_LOG_ERROR = 8,
    FMU_LOG_ALL = 15
};

/* Logs a message in the category that belongs to `status` and returns `status`. */
enum fmu_status fmu_say(const struct fmu *fmu, enum fmu_status status, const char *format, ...);

/* The same before there is an instance. */
enum fmu_status fmu_say_early(const struct fmu_host *host, const char *name, const char *text);

/* Is the instance there and in one of `phases`? If not, says so and returns false. */
bool fmu_refuse(const struct fmu *fmu, const char *function);
static inline bool fmu_may(const struct fmu *fmu, const char *function, unsigned phases)
{
    return (fmu && (unsigned)fmu->now->phase & phases) || fmu_refuse(fmu, function);
}

/* An optional function that this model has not. */
enum fmu_status fmu_lacks(const struct fmu *fmu, const char *function);

enum fmu_status fmu_set_debug_logging(struct fmu *fmu, const char *function, bool on, size_t count,
                                      const char *const categories[]);

/* --- parameter set ----------------------------------------------------------------------------- */

/* `find` of struct fmu_set, from resources/parameters.ssv. */
bool fmu_load_parameters(const struct fmu_model *model, uint64_t hash, const char *resources, void *parameters,
                         char *message, size_t size);

/* Opens FILE in the resources at a URI; where the URI is missing, beside this binary. */
void *fmu_open_resource(const char *uri, const char *file, char *path, size_t size);

/* --- life -------------------------------------------------------------------------------------- */

/* An instance that begins with these parameters; NULL where there is no memory for it. */
struct fmu *fmu_create(const struct fmu_model *model, const char *name, const void *parameters,
                       const struct fmu_host *host, bool logging);

/* The same with the set that the token {table hash, parameter hash} means: the one compiled in, or another
 * one that is found. Where it cannot be, NULL, and the host's log says why. */
struct fmu *fmu_instantiate(const struct fmu_model *model, const struct fmu_set *compiled_in,
                            const char *function, const char *name, const char *token, const char *resources,
                            const struct fmu_host *host, bool logging);
void fmu_free(struct fmu *fmu);
enum fmu_status fmu_setup(struct fmu *fmu, const char *function, bool tolerance_defined, double tolerance,
                          double start_time, bool stop_time_defined, double stop_time);
enum fmu_status fmu_enter_initialization(struct fmu *fmu, const char *function);
enum fmu_status fmu_exit_initialization(struct fmu *fmu, const char *function);
enum fmu_status fmu_terminate(struct fmu *fmu, const char *function);
enum fmu_status fmu_reset(struct fmu *fmu, const char *function);

/* Computes the outputs before the first tick where they are stale, if the parameters make a usable
 * model. */
enum fmu_status fmu_compute_start_outputs(struct fmu *fmu, const char *function);
static inline enum fmu_status fmu_start_outputs(struct fmu *fmu, const char *function)
{
    return fmu->outputs_stale ? fmu_compute_start_outputs(fmu, function) : FMU_OK;
}

/* --- values and steps -------------------------------------------------------------------------- */

/* Says so where there should be values and is no array of them or of their references. */
bool fmu_null_arrays(const struct fmu *fmu, const char *function, const void *references, const void *values,
                     size_t count);

/* Of one base type. */
enum fmu_status fmu_get(struct fmu *fmu, const char *function, enum fmu_base base, const unsigned references[],
                        size_t count, void *values);
enum fmu_status fmu_set(struct fmu *fmu, const char *function, enum fmu_base base, const unsigned references[],
                        size_t count, const void *values);

/* Is it one variable that is meant, in a run, where nothing else can be in the way? What an FMI layer costs a tick
 * is in such checks and calls, so what a host gets and sets at every step is here in short, where it is needed. */
static inline bool fmu_one(const struct fmu *fmu, const unsigned references[], size_t count, const void *values)
{
    return fmu && count == 1 && references && values && fmu->now->phase == FMU_STEP_COMPLETE;
}

/* Its place, counted from `first`; one beyond all places where there is none. */
static inline unsigned fmu_port(const struct fmu *fmu, unsigned reference, unsigned first)
{
    return (reference < FMU_PORTS ? fmu->port[reference] : FMU_NO_PORT) - first;
}

static inline enum fmu_status fmu_get_real(struct fmu *fmu, const char *function, const unsigned references[],
                                           size_t count, double values[])
{
    if (USUALLY(fmu_one(fmu, references, count, values))) {
        const unsigned port = fmu_port(fmu, references[0], FMU_REAL_PORT);
        if (USUALLY(port < FMU_REAL_OUTPUTS)) {
            *values = fmu->now->output.real[port];
            return FMU_OK;
        }
    }
    return fmu_get(fmu, function, FMU_REAL, references, count, values);
}

static inline enum fmu_status fmu_get_boolean(struct fmu *fmu, const char *function,
                                              const unsigned references[], size_t count, int values[])
{
    if (USUALLY(fmu_one(fmu, references, count, values))) {
        const unsigned port = fmu_port(fmu, references[0], FMU_FLAG_PORT);
        if (USUALLY(port < FMU_FLAGS)) {
            *values = fmu->now->output.flag[port];
            return FMU_OK;
        }
    }
    return fmu_get(fmu, function, FMU_BOOLEAN, references, count, values);
}

static inline enum fmu_status fmu_set_real(struct fmu *fmu, const char *function, const unsigned references[],
                                           size_t count, const double values[])
{
    if (USUALLY(fmu_one(fmu, references, count, values) && isfinite(*values))) {
        const unsigned port = fmu_port(fmu, references[0], 0);
        if (USUALLY(port < FMU_INPUTS)) {
            fmu->now->input[port] = *values;
            return FMU_OK;
        }
    }
    return fmu_set(fmu, function, FMU_REAL, references, count, values);
}

enum fmu_status fmu_set_input_derivatives(struct fmu *fmu, const char *function, const unsigned references[],
                                          size_t count, const int order[], const double values[]);

enum fmu_status fmu_do_step(struct fmu *fmu, const char *function, double time, double step);

enum fmu_status fmu_directional_derivative(struct fmu *fmu, const char *function, const unsigned unknowns[],
                                           size_t unknown_count, const unsigned knowns[], size_t known_count,
                                           const double seeds[], double values[]);

/* How a step ended. */
struct fmu_ending {
    double time;
    bool early;
    bool diverged; /* another step would not succeed */
};

/* fmu_do_step for a host that sets inputs within a step or takes its early end: where an output says for the
 * first time since the step began that the model is outside its limits, or where the model diverges. */
enum fmu_status fmu_do_updated_step(struct fmu *fmu, const char *function, double time, double step,
                                    struct fmu_ending *ending);

/* The ticks of the last step, with their inputs. */
struct fmu_span fmu_last_step(const struct fmu_snapshot *now);

/* The inputs of a tick within a step. */
void fmu_inputs_at(const struct fmu_span *span, int64_t tick, double sample_time, double input[FMU_INPUTS]);

/* Of each known, the derivatives of the unknowns weighted by their seeds. */
enum fmu_status fmu_adjoint_derivative(struct fmu *fmu, const char *function, const unsigned unknowns[],
                                       size_t unknown_count, const unsigned knowns[], size_t known_count,
                                       const double seeds[], double values[]);

/* --- arrays ------------------------------------------------------------------------------------ */

/* Says so where there should be values and is no array of them or of their references. */
bool fmu_null_arrays(const struct fmu *fmu, const char *function, const void *references, const void *values,
                     size_t count);

/* Where a host knows arrays, the reference of a group's first element means all in use, and the one behind the
 * table's last means the time. */
enum fmu_status fmu_enter_configuration(struct fmu *fmu, const char *function);
enum fmu_status fmu_exit_configuration(struct fmu *fmu, const char *function);
enum fmu_status fmu_get_arrays(struct fmu *fmu, const char *function, const unsigned references[], size_t count,
                               double values[], size_t value_count);
enum fmu_status fmu_set_arrays(struct fmu *fmu, const char *function, const unsigned references[], size_t count,
                               const double values[], size_t value_count);

/* Is it one scalar that is meant, as most often? */
static inline bool fmu_one_scalar(const struct fmu *fmu, const unsigned references[], size_t count,
                                  size_t value_count)
{
    if (!fmu || count != 1 || value_count != 1 || !references)
        return false;
    const struct fmu_variable *v = fmu_find(fmu->model, references[0]);
    return v && v->index == 0;
}

/* A derivative of fmu.h by arrays: of `seeds` and `values` each has as many as its variables together. */
typedef enum fmu_status fmu_derivative(struct fmu *, const char *function, const unsigned unknowns[],
                                       size_t unknown_count, const unsigned knowns[], size_t known_count,
                                       const double seeds[], double values[]);
enum fmu_status fmu_derivative_of_arrays(struct fmu *fmu, const char *function, fmu_derivative *derivative,
                                         const unsigned unknowns[], size_t unknown_count,
                                         const unsigned knowns[], size_t known_count, const double seeds[],
                                         size_t seed_count, double values[], size_t value_count);

/* --- FMU states -------------------------------------------------------------------------------- */

/* Of the block that an FMU state is: the snapshot, the parameters, the model's state and that of the last step. */
static inline const void *fmu_state_in(const struct fmu_model *model, const void *block)
{
    return (const char *)block + sizeof(struct fmu_snapshot) + model->parameters_size;
}

/* Puts the state of the last step behind that of now, so that *now with what is behind it is all of the block. Steps
 * change the rooms of last_state and `before`, which saves a copy at each. */
static inline void fmu_gather(struct fmu *fmu)
{
    const size_t size = fmu->model->state_size;
    void *place = (char *)fmu->state + size;

    if (fmu->last_state == place)
        return;
    fmu->before = fmu->last_state;
    fmu->last_state = memcpy(place, fmu->before, size);
}

enum fmu_status fmu_get_state(struct fmu *fmu, const char *function, void **state);
enum fmu_status fmu_set_state(struct fmu *fmu, const char *function, const void *state);
enum fmu_status fmu_free_state(struct fmu *fmu, const char *function, void **state);
enum fmu_status fmu_state_size(struct fmu *fmu, const char *function, const void *state, size_t *size);
enum fmu_status fmu_serialize(struct fmu *fmu, const char *function, const void *state, char bytes[],
                              size_t size);
enum fmu_status fmu_deserialize(struct fmu *fmu, const char *function, const char bytes[], size_t size,
                                void **state);

/* FNV-1a, 64 bit. */
uint64_t fmu_hash(const void *bytes, size_t size);

HIDDEN_END

#endif
