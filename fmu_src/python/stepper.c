/* Steps connected FMUs over arrays: the loop of a master, without an interpreter in it. The FMUs are
 * anyone's slaves of FMI 2.0 or FMI 3.0, instantiated by the caller (python/it2hys/cosimulation/stepping.py), and
 * known here by their instances and the addresses of their functions.
 *
 * Every signal and every output has a course: its values step by step, those of an output after what it was before
 * the first step. Every step runs the slaves one after the other: a slave gets this step's output of a slave before it
 * and the last step's of one behind it. */
#include <stdarg.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "fmi2FunctionTypes.h"
#include "fmi3FunctionTypes.h"

#if defined _WIN32
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

/* What is in the innermost loop: a call of it would cost as much as it does. */
#if defined __GNUC__
#define INLINE inline __attribute__((always_inline))
#else
#define INLINE inline
#endif

/* How FMI functions hold numbers: a Real or Float64, an Integer or Int32, a Boolean of FMI 2.0 and one of FMI 3.0. */
enum held { DOUBLE, INT, FLAG, BOOL, HELD };

/* Where an input comes from, which gets factor * value + offset, or where an output goes. */
struct stepper_value {
    double factor, offset;
    double *values;    /* of the steps, found by `place` */
    int32_t course;    /* its number */
    int32_t this_step; /* of an output's course: 1 for what it is after the step, 0 before it */
};

/* Variables of one base that one call sets or gets; none where `count` is 0. */
struct stepper_transfer {
    union {
        fmi2SetRealTYPE *set_real;
        fmi2SetIntegerTYPE *set_integer; /* Booleans are ints, too */
        fmi2GetRealTYPE *get_real;
        fmi2GetIntegerTYPE *get_integer;
        fmi3SetFloat64TYPE *set_float64;
        fmi3SetInt32TYPE *set_int32;
        fmi3SetBooleanTYPE *set_boolean;
        fmi3GetFloat64TYPE *get_float64;
        fmi3GetInt32TYPE *get_int32;
        fmi3GetBooleanTYPE *get_boolean;
    } function;
    const uint32_t *references;
    struct stepper_value *values;
    void *room; /* for what is set or got; NULL: one double, as it is in its course */
    int64_t count;
};

/* What a slave does in a step: inputs set, a step, outputs got. Each call has a place of its own in the code, and
 * most often one target there: processors foresee that, which a loop over a list of calls costs them half of. */
struct stepper_turn {
    void *instance;
    union {
        fmi2DoStepTYPE *fmi2;
        fmi3DoStepTYPE *fmi3;
    } step;
    struct stepper_transfer set[HELD], get[HELD];
    int32_t version; /* of FMI: 2 or 3 */

    /* Before the first step. */
    union {
        fmi2ResetTYPE *fmi2;
        fmi3ResetTYPE *fmi3;
    } reset;
    fmi2SetupExperimentTYPE *setup; /* of FMI 2.0 */
    union {
        fmi2EnterInitializationModeTYPE *fmi2;
        fmi3EnterInitializationModeTYPE *fmi3;
    } enter;
    union {
        fmi2ExitInitializationModeTYPE *fmi2;
        fmi3ExitInitializationModeTYPE *fmi3;
    } leave;
    struct stepper_transfer start[HELD]; /* parameters, whose values are in their places */
};

/* Where the courses are: those of the signals one by one, and those of all outputs behind each other. `last` has the
 * values before the first step, and after a run those of its last one. */
struct stepper_courses {
    double *const *signals;
    double *outputs;
    double *last;
    int64_t length; /* of an output's */
    int32_t signal_count, output_count;
};

/* Statuses are the same numbers in both versions. This one is of a step that went well, after which a slave of FMI 3.0
 * asks that no other follows. */
enum { OK = fmi2OK, WARNING = fmi2Warning, ENDED = 6 };

enum kind { SET, STEP, GET, RESET, SETUP, START, ENTER, LEAVE };

/* Which call of which slave ended a run. */
struct stepper_fault {
    int32_t slave;
    int32_t kind; /* of the call */
    int32_t status;
};

EXPORT int64_t it2core_stepper_run(struct stepper_turn *turns, int32_t slaves,
                                   const struct stepper_courses *courses, int64_t first_step, int64_t steps,
                                   double step_size, struct stepper_fault *fault);

/* Makes slaves ready for values to be set before initialization mode. Returns whether all went well. */
EXPORT bool it2core_stepper_reset(const struct stepper_turn *turns, int32_t slaves,
                                  struct stepper_fault *fault);

/* Sets parameters and goes through initialization mode: inputs and outputs are exchanged in it, and outputs got after
 * it. Courses are a single value here. Returns whether all went well. */
EXPORT bool it2core_stepper_start(struct stepper_turn *turns, int32_t slaves,
                                  const struct stepper_courses *courses, struct stepper_fault *fault);

/* Who listens to an instance: its component environment. */
struct stepper_listener {
    void (*hear)(int status, const char *text);
};

EXPORT void it2core_stepper_log(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status,
                                fmi2String category, fmi2String format, ...);

/* A logger takes a printf format and its arguments, which only compiled code can read. What is no
 * warning is dropped here, because some FMUs tell of every call. */
void it2core_stepper_log(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status,
                         fmi2String category, fmi2String format, ...)
{
    char text[2048];
    va_list arguments;

    (void)name, (void)category;
    if (status == fmi2OK || !environment || !format)
        return;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    ((const struct stepper_listener *)environment)->hear((int)status, text);
}

static double input_value(const struct stepper_value *input, int64_t step)
{
    const double value = input->factor * input->values[step];

    return input->offset == 0.0 ? value : value + input->offset; /* -0.0 stays what it is */
}

/* To the nearest integer, halves away from zero; what no int can hold becomes the nearest that one can. */
static int to_integer(double value)
{
    if (!(value > INT32_MIN)) /* NaN too */
        return INT32_MIN;
    if (value >= INT32_MAX)
        return INT32_MAX;
    return (int)(value < 0.0 ? value - 0.5 : value + 0.5);
}

/* Return where the inputs of a call are, gathered from their courses. */
static INLINE const void *gathered(const struct stepper_transfer *inputs, enum held held, int64_t step)
{
    if (held == DOUBLE && !inputs->room)
        return inputs->values->values + step;
    for (int64_t i = 0; i < inputs->count; i++) {
        const double value = input_value(&inputs->values[i], step);
        if (held == DOUBLE)
            ((double *)inputs->room)[i] = value;
        else if (held == BOOL)
            ((bool *)inputs->room)[i] = value != 0.0;
        else
            ((int *)inputs->room)[i] = held == INT ? to_integer(value) : value != 0.0;
    }
    return inputs->room;
}

/* Return where a call is to leave outputs. */
static INLINE void *receiver(const struct stepper_transfer *outputs, int64_t step)
{
    return outputs->room ? outputs->room : outputs->values->values + step;
}

/* Write what a call has left into the courses. */
static INLINE void scatter(const struct stepper_transfer *outputs, enum held held, int64_t step)
{
    for (int64_t i = 0; outputs->room && i < outputs->count; i++) {
        double *const value = outputs->values[i].values + step;
        if (held == DOUBLE)
            *value = ((const double *)outputs->room)[i];
        else
            *value = held == BOOL ? ((const bool *)outputs->room)[i] : ((const int *)outputs->room)[i];
    }
}

/* --- FMI 2.0 ------------------------------------------------------------------------------------- */

static INLINE fmi2Status fmi2_set_ints(void *instance, const struct stepper_transfer *set, enum held held,
                                       int64_t step)
{
    return set->function.set_integer(instance, set->references, (size_t)set->count, gathered(set, held, step));
}

static INLINE fmi2Status fmi2_set(void *instance, const struct stepper_transfer set[HELD], int64_t step)
{
    const struct stepper_transfer *const reals = &set[DOUBLE];
    fmi2Status status = fmi2OK;

    if (reals->count > 0)
        status = reals->function.set_real(instance, reals->references, (size_t)reals->count,
                                          gathered(reals, DOUBLE, step));
    if (set[INT].count > 0 && status <= fmi2Warning)
        status = fmi2_set_ints(instance, &set[INT], INT, step);
    if (set[FLAG].count > 0 && status <= fmi2Warning)
        status = fmi2_set_ints(instance, &set[FLAG], FLAG, step);
    return status;
}

static INLINE fmi2Status fmi2_get_ints(const struct stepper_turn *turn, enum held held, int64_t step)
{
    const struct stepper_transfer *const get = &turn->get[held];
    const fmi2Status status =
        get->function.get_integer(turn->instance, get->references, (size_t)get->count, receiver(get, step));

    scatter(get, held, step);
    return status;
}

static INLINE fmi2Status fmi2_get(const struct stepper_turn *turn, int64_t step)
{
    const struct stepper_transfer *const reals = &turn->get[DOUBLE];
    fmi2Status status = fmi2OK;

    if (reals->count > 0) {
        status = reals->function.get_real(turn->instance, reals->references, (size_t)reals->count,
                                          receiver(reals, step));
        scatter(reals, DOUBLE, step);
    }
    if (turn->get[INT].count > 0 && status <= fmi2Warning)
        status = fmi2_get_ints(turn, INT, step);
    if (turn->get[FLAG].count > 0 && status <= fmi2Warning)
        status = fmi2_get_ints(turn, FLAG, step);
    return status;
}

/* --- FMI 3.0: variables are scalars, so that there are as many values as references ---------------- */

static fmi3Status fmi3_set(void *instance, const struct stepper_transfer set[HELD], int64_t step)
{
    const struct stepper_transfer *const doubles = &set[DOUBLE], *const ints = &set[INT],
                                         *const flags = &set[BOOL];
    const size_t n = (size_t)doubles->count, m = (size_t)ints->count, l = (size_t)flags->count;
    fmi3Status status = fmi3OK;

    if (n > 0)
        status =
            doubles->function.set_float64(instance, doubles->references, n, gathered(doubles, DOUBLE, step), n);
    if (m > 0 && status <= fmi3Warning)
        status = ints->function.set_int32(instance, ints->references, m, gathered(ints, INT, step), m);
    if (l > 0 && status <= fmi3Warning)
        status = flags->function.set_boolean(instance, flags->references, l, gathered(flags, BOOL, step), l);
    return status;
}

static int32_t fmi3_step(const struct stepper_turn *turn, double time, double step_size)
{
    fmi3Boolean event, terminate = fmi3False, early;
    fmi3Float64 reached;
    const fmi3Status status =
        turn->step.fmi3(turn->instance, time, step_size, fmi3True, &event, &terminate, &early, &reached);

    return status <= fmi3Warning && terminate ? ENDED : (int32_t)status;
}

static fmi3Status fmi3_get(const struct stepper_turn *turn, int64_t step)
{
    const struct stepper_transfer *const doubles = &turn->get[DOUBLE], *const ints = &turn->get[INT],
                                         *const flags = &turn->get[BOOL];
    const size_t n = (size_t)doubles->count, m = (size_t)ints->count, l = (size_t)flags->count;
    fmi3Status status = fmi3OK;

    if (n > 0) {
        status =
            doubles->function.get_float64(turn->instance, doubles->references, n, receiver(doubles, step), n);
        scatter(doubles, DOUBLE, step);
    }
    if (m > 0 && status <= fmi3Warning) {
        status = ints->function.get_int32(turn->instance, ints->references, m, receiver(ints, step), m);
        scatter(ints, INT, step);
    }
    if (l > 0 && status <= fmi3Warning) {
        status = flags->function.get_boolean(turn->instance, flags->references, l, receiver(flags, step), l);
        scatter(flags, BOOL, step);
    }
    return status;
}

/* --- either: the version is a constant where these are called, so that FMI 2.0 does not wait for FMI 3.0 -------- */

static INLINE int32_t set_inputs(const struct stepper_turn *turn, int32_t version, int64_t step)
{
    return version == 2 ? (int32_t)fmi2_set(turn->instance, turn->set, step)
                        : (int32_t)fmi3_set(turn->instance, turn->set, step);
}

static INLINE int32_t make_step(const struct stepper_turn *turn, int32_t version, double time, double step_size)
{
    return version == 2 ? (int32_t)turn->step.fmi2(turn->instance, time, step_size, fmi2True)
                        : fmi3_step(turn, time, step_size);
}

static INLINE int32_t get_outputs(const struct stepper_turn *turn, int32_t version, int64_t step)
{
    return version == 2 ? (int32_t)fmi2_get(turn, step) : (int32_t)fmi3_get(turn, step);
}

static double *find_course(const struct stepper_courses *courses, int32_t number)
{
    return number < courses->signal_count
               ? courses->signals[number]
               : courses->outputs + (number - courses->signal_count) * courses->length;
}

/* Tells a slave's calls where their values are. */
static void place(struct stepper_turn *turn, const struct stepper_courses *courses, bool stepping)
{
    for (struct stepper_transfer *set = turn->set, *get = turn->get; set < turn->set + HELD; set++, get++) {
        for (int64_t i = 0; i < set->count; i++)
            set->values[i].values =
                find_course(courses, set->values[i].course) + (stepping ? set->values[i].this_step : 0);
        for (int64_t i = 0; i < get->count; i++)
            get->values[i].values = find_course(courses, get->values[i].course) + (stepping ? 1 : 0);
    }
}

/* --- before the first step: return the status of a slave's calls, and in `kind` which of them it is of ------------ */

static int32_t reset(const struct stepper_turn *turn, int32_t *kind)
{
    int32_t status = turn->version == 2 ? (int32_t)turn->reset.fmi2(turn->instance)
                                        : (int32_t)turn->reset.fmi3(turn->instance);

    *kind = RESET;
    if (status <= WARNING && turn->version == 2) {
        *kind = SETUP;
        status = (int32_t)turn->setup(turn->instance, fmi2False, 0.0, 0.0, fmi2False, 0.0);
    }
    return status;
}

static int32_t enter(const struct stepper_turn *turn, int32_t *kind)
{
    int32_t status = turn->version == 2 ? (int32_t)fmi2_set(turn->instance, turn->start, 0)
                                        : (int32_t)fmi3_set(turn->instance, turn->start, 0);

    *kind = START;
    if (status <= WARNING) {
        *kind = ENTER;
        status = turn->version == 2
                     ? (int32_t)turn->enter.fmi2(turn->instance)
                     : (int32_t)turn->enter.fmi3(turn->instance, fmi3False, 0.0, 0.0, fmi3False, 0.0);
    }
    return status;
}

static int32_t exchange(const struct stepper_turn *turn, int32_t *kind)
{
    int32_t status = set_inputs(turn, turn->version, 0);

    *kind = SET;
    if (status <= WARNING) {
        *kind = GET;
        status = get_outputs(turn, turn->version, 0);
    }
    return status;
}

static int32_t leave(const struct stepper_turn *turn, int32_t *kind)
{
    int32_t status = turn->version == 2 ? (int32_t)turn->leave.fmi2(turn->instance)
                                        : (int32_t)turn->leave.fmi3(turn->instance);

    *kind = LEAVE;
    if (status <= WARNING) {
        *kind = GET;
        status = get_outputs(turn, turn->version, 0);
    }
    return status;
}

static bool all(const struct stepper_turn *turns, int32_t slaves,
                int32_t (*calls)(const struct stepper_turn *, int32_t *), struct stepper_fault *fault)
{
    for (int32_t i = 0; i < slaves; i++) {
        int32_t kind;
        const int32_t status = calls(&turns[i], &kind);
        if (status > WARNING) {
            *fault = (struct stepper_fault){ i, kind, status };
            return false;
        }
    }
    return true;
}

bool it2core_stepper_reset(const struct stepper_turn *turns, int32_t slaves, struct stepper_fault *fault)
{
    return all(turns, slaves, reset, fault);
}

bool it2core_stepper_start(struct stepper_turn *turns, int32_t slaves, const struct stepper_courses *courses,
                           struct stepper_fault *fault)
{
    for (int32_t i = 0; i < slaves; i++)
        place(&turns[i], courses, false);
    return all(turns, slaves, enter, fault) && all(turns, slaves, exchange, fault) &&
           all(turns, slaves, leave, fault);
}

/* --- steps ----------------------------------------------------------------------------------------- */

/* Return the status of a slave's turn in a step, and in `kind` which of its calls it is of. */
static INLINE int32_t take_turn(const struct stepper_turn *turn, int32_t version, int64_t step, double time,
                                double step_size, int32_t *kind)
{
    int32_t status = set_inputs(turn, version, step);

    *kind = SET;
    if (status <= WARNING) {
        *kind = STEP;
        status = make_step(turn, version, time, step_size);
    }
    if (status <= WARNING) {
        *kind = GET;
        status = get_outputs(turn, version, step);
    }
    return status;
}

/* Return the number of complete steps, which is less than asked for where a slave refused one. `mixed` is a constant
 * where this is called. */
static INLINE int64_t run(const struct stepper_turn *turns, int32_t slaves, int64_t first_step, int64_t steps,
                          double step_size, bool mixed, struct stepper_fault *fault)
{
    for (int64_t k = 0; k < steps; k++) {
        const double time = (double)(first_step + k) * step_size;
        for (int32_t i = 0; i < slaves; i++) {
            int32_t kind;
            const int32_t status =
                take_turn(&turns[i], mixed ? turns[i].version : 2, k, time, step_size, &kind);
            if (status > WARNING) {
                *fault = (struct stepper_fault){ i, kind, status };
                return k;
            }
        }
    }
    return steps;
}

/* --- a short way: what plants and inverses take, a Real set and got as it is, and perhaps a Boolean got ---------- */

/* All that a step needs, side by side: what else a turn might do is asked once and not in every step, which would
 * take a tenth of a run. */
struct simple_turn {
    void *instance;
    fmi2SetRealTYPE *set_real;
    fmi2DoStepTYPE *step;
    fmi2GetRealTYPE *get_real;
    fmi2GetBooleanTYPE *get_flag; /* NULL: none is got */
    const fmi2ValueReference *input_reference, *output_reference, *flag_reference;
    double *input, *output, *flag; /* of the steps */
};

/* Most slaves that run like that; more take the long way. */
enum { SIMPLE_SLAVES = 8 };

static bool is_one_real(const struct stepper_transfer transfers[HELD])
{
    return transfers[DOUBLE].count == 1 && !transfers[DOUBLE].room && transfers[INT].count == 0;
}

/* Returns whether a turn, whose values have their places, is one of these. */
static bool simplify(const struct stepper_turn *turn, struct simple_turn *simple)
{
    const struct stepper_transfer *const set = turn->set, *const get = turn->get;

    if (turn->version != 2 || !is_one_real(set) || !is_one_real(get) || set[FLAG].count > 0 ||
        get[FLAG].count > 1)
        return false;
    *simple = (struct simple_turn){
        .instance = turn->instance,
        .set_real = set[DOUBLE].function.set_real,
        .step = turn->step.fmi2,
        .get_real = get[DOUBLE].function.get_real,
        .input_reference = set[DOUBLE].references,
        .output_reference = get[DOUBLE].references,
        .input = set[DOUBLE].values->values,
        .output = get[DOUBLE].values->values,
    };
    if (get[FLAG].count == 1) {
        simple->get_flag = get[FLAG].function.get_integer;
        simple->flag_reference = get[FLAG].references;
        simple->flag = get[FLAG].values->values;
    }
    return true;
}

static INLINE fmi2Status take_simple_turn(const struct simple_turn *turn, int64_t step, double time,
                                          double step_size, int32_t *kind)
{
    fmi2Boolean flag = fmi2False;
    fmi2Status status;

    *kind = SET;
    status = turn->set_real(turn->instance, turn->input_reference, 1, turn->input + step);
    if (status > fmi2Warning)
        return status;
    *kind = STEP;
    status = turn->step(turn->instance, time, step_size, fmi2True);
    if (status > fmi2Warning)
        return status;
    *kind = GET;
    status = turn->get_real(turn->instance, turn->output_reference, 1, turn->output + step);
    if (turn->get_flag && status <= fmi2Warning) {
        status = turn->get_flag(turn->instance, turn->flag_reference, 1, &flag);
        turn->flag[step] = flag;
    }
    return status;
}

static int64_t run_simple(const struct simple_turn *turns, int32_t slaves, int64_t first_step, int64_t steps,
                          double step_size, struct stepper_fault *fault)
{
    for (int64_t k = 0; k < steps; k++) {
        const double time = (double)(first_step + k) * step_size;
        for (int32_t i = 0; i < slaves; i++) {
            int32_t kind;
            const fmi2Status status = take_simple_turn(&turns[i], k, time, step_size, &kind);
            if (status > fmi2Warning) {
                *fault = (struct stepper_fault){ i, kind, (int32_t)status };
                return k;
            }
        }
    }
    return steps;
}

/* The way that fits the slaves. */
static int64_t run_any(struct stepper_turn *turns, int32_t slaves, const struct stepper_courses *courses,
                       int64_t first_step, int64_t steps, double step_size, struct stepper_fault *fault)
{
    struct simple_turn simple[SIMPLE_SLAVES];
    bool mixed = false, all_simple = slaves <= SIMPLE_SLAVES;

    for (int32_t i = 0; i < slaves; i++) {
        place(&turns[i], courses, true);
        mixed |= turns[i].version != 2;
        all_simple = all_simple && simplify(&turns[i], &simple[i]);
    }
    if (all_simple)
        return run_simple(simple, slaves, first_step, steps, step_size, fault);
    if (mixed)
        return run(turns, slaves, first_step, steps, step_size, true, fault);
    return run(turns, slaves, first_step, steps, step_size, false, fault);
}

int64_t it2core_stepper_run(struct stepper_turn *turns, int32_t slaves, const struct stepper_courses *courses,
                            int64_t first_step, int64_t steps, double step_size, struct stepper_fault *fault)
{
    double *const last = courses->last, *const outputs = courses->outputs;
    const int64_t length = courses->length;

    for (int32_t i = 0; i < courses->output_count; i++)
        outputs[i * length] = last[i];
    const int64_t done = run_any(turns, slaves, courses, first_step, steps, step_size, fault);
    for (int32_t i = 0; i < courses->output_count; i++)
        last[i] = outputs[i * length + done];
    return done;
}
