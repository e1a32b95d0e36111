/* it2hys.h: generated from fmu_src by python -m it2hys.fmu.amalgamation. */
#ifndef IT2HYS_H
#define IT2HYS_H

#include <float.h>
#include <math.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>


/* --- actuator.h --- */

/* What the plant and the inverse share: the table of their variables, and the chain as parameters make it. */

/* --- chain.h --- */

/* The plant as a chain of invertible stages, walked forwards by the plant and backwards by the inverse.
 *
 *     voltage -> [delay] -> [slew] -> [saturation] -> [lag] -> [play] -> IT2 core
 *             -> [load] -> [creep] -> [resonance] -> [drift] -> [nonlinearity] -> displacement
 *             -> [hum] -> measured
 *
 * Stages in brackets are effects (stage.h); stages.h lists them. Those that are off are passed by: the chain
 * without effects is the IT2 core bit for bit. Constants are set once by chain_prepare; the state is a small
 * value that can be copied. Nothing is allocated and nothing is global.
 *
 * A displacement is what the sensor reads, in the core too. What scales with the stroke (creep,
 * nonlinearity) acts on what of it lies above displacementZero.
 *
 * Some stages lose information, and the inverse keeps to the displacements and the voltages that the
 * parameters hold for: beyond them the core is extrapolated. Where that cuts off what a reference asks for,
 * the inverse gives the nearest. Without effects it goes on from what the plant reaches. With effects, what
 * remembers for long is kept on what the plant reaches: the amplifier's voltage, the play operators and
 * creep. The inverses of core, lag and resonance remember one or two ticks, and of those what was aimed at:
 * the plant comes back to it by its own contraction. (To take the plant back in one tick from what it
 * reached would make a limit cycle of lag, core and slew limit.) So nothing winds up. Until the plant is
 * back, it is followed in `reached`, and the inverse says so. */

/* --- it2_table.h --- */

/* (10) as a table, for runs of many ticks with the same rules. It is affine in the voltage,
 *     y_k = A(y_{k-1}) x_k + B(y_{k-1}),    A = sum q2 w / sum w,  B = sum (q1 y_{k-1} + q3) w / sum w,  w = f + F,
 * and A and B are smooth functions of one variable: polynomials on short intervals, interpolated at Chebyshev
 * nodes, hold them to rounding. A step is then one look-up and a few multiplications and additions, however
 * many rules there are: no exponential and no division. (30) is x = (y - B) / A of the same table.
 *
 * An interval's width is a power of two and its middle a multiple of it. So nothing is lost on the way to the
 * interval, and it takes three additions: with 1.5 * 2^52 widths added, less the first row's number, y is rounded
 * to a multiple of the width, and the row stands in the low bits of the sum. */

/* --- it2.h --- */

/* The simplified interval type-2 Takagi-Sugeno fuzzy model: the core of the chain.
 *
 * One file per group of equations of the paper:
 *   it2_membership.h   (8), (9), (11), (12)   the memberships and their sum
 *   it2_model.c        (7), (10)              one step forward
 *   it2_inverse.c      (30)                   one step backward
 *   it2_gradient.c     (13) to (18)           partial derivatives
 *   it2_range.c        what (10) becomes beyond the ends of its range
 *   it2_table.c        (10) and (30) prepared for many ticks with the same rules
 *   it2_free_run.c     (10) over a record, with forward sensitivities
 *   it2_check.c        what makes a parameter set usable
 *
 * Units are the caller's; the FMUs use V and m. */

/* --- hidden.h --- */

/* HIDDEN_BEGIN ... HIDDEN_END around declarations: functions that other binaries do not see, whatever the
 * compiler's flags. Only the functions of FMI are exported then, from sources/ too. */

#if defined __GNUC__ && !defined _WIN32
#define HIDDEN_BEGIN _Pragma("GCC visibility push(hidden)")
#define HIDDEN_END _Pragma("GCC visibility pop")
#else /* on Windows nothing is visible that is not exported */
#define HIDDEN_BEGIN
#define HIDDEN_END
#endif

/* --- real.h --- */

/* The number type of the core: double, or float where IT2HYS_SINGLE is defined, for processors whose
 * floating-point unit is single. All sources of a program are compiled with the same choice.
 *
 * Nothing is computed in double then. So literals that meet a `real` are whole numbers, which C converts to
 * either type without a loss, or stand in REAL(); functions of <math.h> are called by the names below, and
 * what is printed is cast. <tgmath.h> would choose the functions too, but not the literals, and compilers for
 * small processors often lack it. */

#if defined IT2HYS_SINGLE

typedef float real;
#define REAL(literal) literal##f
#define REAL_FUNCTION(name) name##f /* those that have no name below */
#define REAL_EPSILON FLT_EPSILON
#define REAL_MAX FLT_MAX
#define REAL_INFINITY HUGE_VALF
#define real_cos cosf
#define real_exp expf
#define real_expm1 expm1f
#define real_fabs fabsf
#define real_floor floorf
#define real_fmax fmaxf
#define real_fmin fminf
#define real_sin sinf
#define real_sqrt sqrtf

/* A program that mixes the two is not linked. */
#define chain_prepare chain_prepare_single
#define it2_prepare it2_prepare_single

#else

typedef double real;
#define REAL(literal) literal
#define REAL_FUNCTION(name) name
#define REAL_EPSILON DBL_EPSILON
#define REAL_MAX DBL_MAX
#define REAL_INFINITY HUGE_VAL
#define real_cos cos
#define real_exp exp
#define real_expm1 expm1
#define real_fabs fabs
#define real_floor floor
#define real_fmax fmax
#define real_fmin fmin
#define real_sin sin
#define real_sqrt sqrt

#endif

enum { IT2_MAX_RULES = 16, IT2_RULE_PARAMETERS = 6 };

/* One rule, in the order of the paper's Table 1: antecedent (s1, s2, c), consequent (q1, q2, q3). */
struct it2_rule {
    real sigmaLower;
    real sigmaUpper;
    real centre;
    real q1;
    real q2;
    real q3;
};

/* A range of displacement. */
struct it2_range {
    real minimum;
    real maximum;
};

/* For a core that is (10) everywhere: while it is fitted, nobody knows its range yet. */
static const struct it2_range IT2_EVERYWHERE = { -REAL_INFINITY, REAL_INFINITY };

/* An end of the range, and the equilibrium there: F(y, x) = y. */
struct it2_end {
    real y;
    real x;
    real dx; /* dF/dx */
    real dy; /* dF/dy */
};

struct it2_table;

/* The rules, and -1 / (2 s_l1^2), -1 / (2 s_l2^2) in the scale of exponential.h. Set by it2_prepare. */
struct it2 {
    int rules;
    struct it2_range plain; /* of y_{k-1}: within the range, and no membership comes close to underflow */
    struct it2_end lower, upper;
    const struct it2_table *table; /* for y_{k-1} in `plain`; NULL: the rules themselves */
    struct it2_rule rule[IT2_MAX_RULES];
    real exponent[IT2_MAX_RULES][2];
};

struct it2_state {
    real y; /* y_{k-1} */
};

/* Partial derivatives of a step with respect to its two arguments and to the end of the range. */
struct it2_partials {
    real dx;  /* dy_k / dx_k */
    real dy;  /* dy_k / dy_{k-1}: the contraction of a free run */
    real end; /* by the end that y_{k-1} lies beyond; 0 within the range */
};

/* The end that y_{k-1} lies beyond; NULL within the range. */
static inline const struct it2_end *it2_beyond(const struct it2 *stage, real y_previous)
{
    return y_previous < stage->lower.y ? &stage->lower : y_previous > stage->upper.y ? &stage->upper : NULL;
}

HIDDEN_BEGIN

void it2_prepare(struct it2 *stage, const struct it2_rule *rules, int count, struct it2_range range);

/* From now on, until it2_prepare, steps and inverses within the range look (10) and (30) up (it2_table.h): faster,
 * and the same but for rounding, less than 1e-15 of the range or of its farther end. Derivatives stay those of the
 * rules. `table`, the caller's, holds zeros or what this function has made: for the same rules and range it is
 * taken as it is. False where there can be none, because the range is infinite or the rules are too narrow for
 * it: then everything stays with the rules. */
bool it2_tabulate(struct it2 *stage, struct it2_table *table);

/* The core as a stage that the chain always has; it2_step and it2_inverse are in it2_table.h. */
void it2_reset(struct it2_state *state, real y);
real it2_derivative(const struct it2 *stage, const struct it2_state *state, real x);

/* F without a state, and what is derived from it: (10) for y_{k-1} within the range, and what goes on from
 * it beyond (it2_range.c). By the rules; it2_evaluate and it2_solve of it2_table.h take the table where there is
 * one. */
real it2_evaluate_rules(const struct it2 *stage, real y_previous, real x);
real it2_solve_rules(const struct it2 *stage, real y_previous, real y);
struct it2_partials it2_partials(const struct it2 *stage, real y_previous, real x);

/* Eqs. (13) to (18): gradient[6 l + i] = dy_k / d(parameter i of rule l), in the order of it2_rule.
 * Returns y_k and, where `partials` is given, the partial derivatives too. */
real it2_gradient(const struct it2 *stage, real y_previous, real x, real *gradient,
                  struct it2_partials *partials);

/* y[k] = F(y[k-1], x[k]), k = 0..n-1, y[-1] = y_initial. Where `sensitivity` (n rows of 6 L + 1,
 * row-major) is given: the derivatives of y[k] with respect to all parameters and y_initial.
 * Returns the number of samples computed: less than n if a value is not finite. */
size_t it2_free_run(const struct it2_rule *rules, int count, struct it2_range range, const real *x, size_t n,
                    real y_initial, real *y, real *sensitivity);

/* Is the parameter set usable over the range of displacement? On a grid of y that has both ends: the sum of
 * q_l2 memberships is positive (invertible) and |dy_k/dy_{k-1}| < 1 on the equilibrium curve (an equilibrium
 * is stable). With it at the ends, a free run cannot diverge: beyond them y_k moves by that share of what
 * y_{k-1} does, and from within them one step goes no farther than the voltage takes it.
 * Otherwise false, and `message` names the culprit and the mend. */
bool it2_check(const struct it2_rule *rules, int count, struct it2_range range, char *message, size_t size);

/* The largest |dy_k/dy_{k-1}| on the equilibrium curve and the displacement where it occurs. */
real it2_contraction(const struct it2 *stage, struct it2_range range, real *where);

HIDDEN_END

/* As many rows as fit into a processor's nearest memory beside other things, 33 KB; none in single precision. */
#if defined IT2HYS_SINGLE
enum { IT2_TABLE_ROWS = 1 };
#else
enum { IT2_TABLE_ROWS = 260 };
#endif
enum { IT2_TABLE_TERMS = 8 };

struct it2_table {
    int rules; /* what it was made of: rules and range */
    struct it2_rule rule[IT2_MAX_RULES];
    struct it2_range range;
    int rows;                                      /* 0 where there would be too many */
    real rounding;                                 /* what is added to y */
    real term[IT2_TABLE_ROWS][IT2_TABLE_TERMS][2]; /* of A and of B, by powers of the distance to the middle */
};

/* Within the range, where nothing can underflow either: neither exponentials nor their sum need be checked. */
static inline bool it2_is_plain(const struct it2 *stage, real y_previous)
{
    return y_previous >= stage->plain.minimum && y_previous <= stage->plain.maximum;
}

#if !defined IT2HYS_SINGLE

/* Where y is in its row, and the powers of that. */
struct it2_place {
    const real (*term)[2];
    real r, r2, r4;
};

static inline uint32_t it2_table_row(real rounded)
{
    union {
        real value;
        uint64_t bits;
    } sum = { rounded };

    return (uint32_t)sum.bits;
}

static inline struct it2_place it2_place(const struct it2_table *table, real y)
{
    const real rounded = y + table->rounding;
    const real r = y - (rounded - table->rounding);
    const real r2 = r * r;

    return (struct it2_place){ table->term[it2_table_row(rounded)], r, r2, r2 * r2 };
}

/* A pair of terms, without the power of r that they have in common. */
static inline real it2_pair(const struct it2_place *at, int i, int power)
{
    return at->term[power][i] + at->term[power + 1][i] * at->r;
}

/* A x + B: products beside each other, not one long chain, because a step waits for the slowest. */
static inline real it2_look_up_step(const struct it2_table *table, real y_previous, real x)
{
    const struct it2_place at = it2_place(table, y_previous);
    const real x2 = x * at.r2, x4 = x * at.r4, r6 = at.r2 * at.r4, x6 = x2 * at.r4;

    return ((it2_pair(&at, 0, 0) * x + it2_pair(&at, 1, 0)) +
            (it2_pair(&at, 0, 2) * x2 + it2_pair(&at, 1, 2) * at.r2)) +
           ((it2_pair(&at, 0, 4) * x4 + it2_pair(&at, 1, 4) * at.r4) +
            (it2_pair(&at, 0, 6) * x6 + it2_pair(&at, 1, 6) * r6));
}

/* A or B. */
static inline real it2_polynomial(const struct it2_place *at, int i)
{
    return (it2_pair(at, i, 0) + it2_pair(at, i, 2) * at->r2) +
           (it2_pair(at, i, 4) + it2_pair(at, i, 6) * at->r2) * at->r4;
}

/* (y - B) / A */
static inline real it2_look_up_inverse(const struct it2_table *table, real y_previous, real y)
{
    const struct it2_place at = it2_place(table, y_previous);

    return (y - it2_polynomial(&at, 1)) / it2_polynomial(&at, 0);
}

#else /* exact code only: a table to float's precision would be another one */

static inline real it2_look_up_step(const struct it2_table *table, real y_previous, real x)
{
    (void)table, (void)y_previous;
    return x;
}

static inline real it2_look_up_inverse(const struct it2_table *table, real y_previous, real y)
{
    (void)table, (void)y_previous;
    return y;
}

#endif

/* --- steps, in the places where they are taken ---------------------------------------------------- */

static inline real it2_evaluate(const struct it2 *stage, real y_previous, real x)
{
    return stage->table && it2_is_plain(stage, y_previous) ? it2_look_up_step(stage->table, y_previous, x)
                                                           : it2_evaluate_rules(stage, y_previous, x);
}

static inline real it2_solve(const struct it2 *stage, real y_previous, real y)
{
    return stage->table && it2_is_plain(stage, y_previous) ? it2_look_up_inverse(stage->table, y_previous, y)
                                                           : it2_solve_rules(stage, y_previous, y);
}

/* The core as a stage that the chain always has. Both advance the state. */
static inline real it2_step(const struct it2 *stage, struct it2_state *state, real x)
{
    state->y = it2_evaluate(stage, state->y, x);
    return state->y;
}

static inline real it2_inverse(const struct it2 *stage, struct it2_state *state, real y)
{
    const real x = it2_solve(stage, state->y, y);

    state->y = y;
    return x;
}

/* --- stages.h --- */

/* The one list of stages, in the order of the chain: those before the core, behind it, and on the way to the
 * recorder. Each stands under the memory that it has:
 *
 *   NONE      no state
 *   AIMED     a tick or two; the inverse keeps what it aimed at, and beside it what the plant reached
 *   SHORT     a tick; the inverse keeps what the plant reached
 *   LONG      many numbers, of which the same is true
 *   LONGEST   even more of them */

/* --- creep.h --- */

/* Creep: y_k = x_k + sum_i c_i s_i,k with s_i,k = s_i,k-1 + g_i (x_k - s_i,k-1), g_i = 1 - exp(-Ts / tau_i).
 *
 * s_i at tick k includes x_k, so that a stage much faster than Ts is a plain gain. y is affine in x
 * with the slope 1 + sum_i c_i g_i. The inverse is stable where 1 + the sum of the negative gains is
 * positive. All of this is counted from the sensor's zero. */

/* --- stage.h --- */

/* What all stages of the chain share. A stage is a scalar causal map with a state of its own; those of this
 * folder beside the core are effects, off by default, one file each. The list of them is in stages.h.
 *
 * A stage's file defines
 *     <stage>_parameters           a type with the names of the variable table
 *     struct <stage>               constants, which follow from the parameters
 *     struct <stage>_state         of type real, where it has one
 *     <stage>_stage                what runs in a tick
 *     <stage>_analysis             what only hosts need: words for a bad parameter, and exact derivatives
 * and the chain does the rest. Constants and states come as pointers to these structs; a stage without a
 * state leaves its pointer alone. */

#define TWO_PI REAL(6.283185307179586)

struct chain_parameters;

/* What acts on a stage beside its input. */
struct stage_surroundings {
    real force;
    real temperature;
    real time;    /* of the tick */
    real voltage; /* that drives the core; behind the core, next states may depend on it */
};

/* The same where another voltage drives the core. */
static inline struct stage_surroundings driven_by(const struct stage_surroundings *around, real voltage)
{
    return (struct stage_surroundings){ around->force, around->temperature, around->time, voltage };
}

struct stage {
    bool limits; /* it loses what is beyond: its inverse gives the nearest */
    bool (*is_on)(const struct chain_parameters *);

    /* It is on, and gives what it gets, whatever that is; NULL: it never does. */
    bool (*is_idle)(const struct chain_parameters *);
    void (*prepare)(void *constants, const struct chain_parameters *);

    /* At rest at the output y; returns the input. NULL: that is y, and so are all numbers of the state. Before
     * the core, with a memory that is not LONG, the constants say all: there may be no parameters. */
    real (*rest)(const void *constants, void *state, real y, const struct chain_parameters *);

    /* Input to output; advances the state. */
    real (*step)(const void *constants, void *state, real x, const struct stage_surroundings *);

    /* Output to input. A state of the memory AIMED or SHORT (stages.h) is advanced to what `step` would have
     * left, a long one stays. NULL: the stage has no part in the inverse. */
    real (*inverse)(const void *constants, void *state, real y, const struct stage_surroundings *);

    /* How many bytes of the state are in use, from its beginning. NULL: all. */
    size_t (*used)(const void *constants);

    /* How much later its output comes, in s, where the inverse does not make up for that; NULL: at once. */
    real (*latency)(const void *constants);
};

/* Derivatives along a direction; d_ is the derivative of what has the name without it. NULL: the output's is
 * the input's, there is no state, and no parameter or surrounding counts. */
struct stage_analysis {
    /* Are the parameters usable? If not, the message names the culprit. */
    bool (*check)(const struct chain_parameters *, char *message, size_t size);

    /* Of `prepare`; d_constants holds zeros. NULL: that is linear, without a constant or a sampleTime. */
    void (*prepare_tangent)(void *d_constants, const void *constants, const struct chain_parameters *,
                            const struct chain_parameters *d);

    /* Of `rest`, which has returned x and left the state; NULL where that is. */
    real (*rest_tangent)(const void *constants, const void *d_constants, const void *state, void *d_state,
                         real x, real d_y, const struct chain_parameters *, const struct chain_parameters *d);

    /* Of `step` by state, input and surroundings, along `count` directions at once: number i of the state has
     * its derivatives from d_state[i * count] on, d_around one for each; `row` goes from those of the input to
     * those of the output. */
    void (*tangent)(const void *constants, const void *state, real x, const struct stage_surroundings *around,
                    const struct stage_surroundings *d_around, int count, real *restrict d_state,
                    real *restrict row);

    /* Of `step` by the constants alone: returns that of the output, and adds to d_state[i * stride]. */
    real (*by_parameters)(const void *constants, const void *d_constants, const void *state, real x,
                          const struct stage_surroundings *, real *d_state, int stride);

    /* Of `inverse`, which has returned x, by state, output and surroundings. For a stage that limits it is
     * `tangent`. */
    real (*inverse_tangent)(const void *constants, const void *state, real x, void *d_state, real d_y,
                            const struct stage_surroundings *around, const struct stage_surroundings *d_around);
};

/* Directions that a tangent takes at a time, where it has to keep their inputs. */
enum { STAGE_CHUNK = 32 };

/* Writes why a parameter set cannot be used; returns false. */
static inline bool refuse(char *message, size_t size, const char *format, ...)
{
    va_list arguments;

    va_start(arguments, format);
    vsnprintf(message, size, format, arguments);
    va_end(arguments);
    return false;
}

/* A NaN stays one. */
static inline real clamp(real value, real low, real high)
{
    return value < low ? low : value > high ? high : value;
}

enum { CREEP_MAX = 16 };

struct creep_element {
    real gain;         /* c_i: creep in the end, per displacement */
    real timeConstant; /* tau_i, s */
};

typedef struct creep_element creep_parameters[CREEP_MAX];

struct creep {
    int first; /* of derivatives: those before are 0 */
    int count;
    real zero;            /* the sensor's */
    real gain[CREEP_MAX]; /* c_i */
    real rate[CREEP_MAX]; /* g_i */
    real slope;           /* dy_k / dx_k */
    real per_slope;       /* 1 / that, without derivatives: an inverse waits for a division */
};

struct creep_state {
    real s[CREEP_MAX]; /* s_i,k-1 */
};

HIDDEN_BEGIN
extern const struct stage creep_stage;
extern const struct stage_analysis creep_analysis;
HIDDEN_END

/* --- delay.h --- */

/* Delay of the voltage: y_k = u at the time t_k - delay.time, straight between ticks.
 *
 * A whole number of ticks is exact. The inverse cannot look ahead, so it has no part of this stage:
 * it drives the chain behind the delay, and the plant follows the reference that much later. Where
 * the reference is known ahead, a master hands it over delay.time early (with the force and the
 * temperature of that later time), and the plant follows it on time. */

#define DELAY_MAX_TICKS 64

typedef struct delay_parameters {
    real time;
} delay_parameters;

struct delay {
    int ticks;     /* whole ones */
    real fraction; /* of a tick beyond them */
    real time;
};

/* A ring of as many voltages as the delay needs: u_{k-1} is at number `newest`, u_{k-2} at the next, ... */
struct delay_state {
    real newest;
    real u[DELAY_MAX_TICKS];
};

HIDDEN_BEGIN
extern const struct stage delay_stage;
extern const struct stage_analysis delay_analysis;
HIDDEN_END

/* --- drift.h --- */

/* Drift: y_k = x_k + drift.temperatureCoefficient (T_k - 293.15 K) + drift.rate t_k.
 *
 * t_k is the tick's own time. No state. Whoever knows the rate only after the fact leaves it out of
 * the inverse's set. */

#define DRIFT_REFERENCE_TEMPERATURE REAL(293.15) /* K */

typedef struct drift_parameters {
    real temperatureCoefficient; /* m/K */
    real rate;                   /* m/s */
} drift_parameters;

struct drift {
    real temperatureCoefficient;
    real rate;
};

HIDDEN_BEGIN
extern const struct stage drift_stage;
extern const struct stage_analysis drift_analysis;
HIDDEN_END

/* --- hum.h --- */

/* A line on the reading that is not in the voltage: hum.amplitude sin(2 pi hum.frequency t_k + hum.phase).
 *
 * t_k is the tick's own time. Plant only, on `measured` only. No state. */

typedef struct hum_parameters {
    real amplitude; /* m; 0: none */
    real frequency; /* Hz */
    real phase;     /* rad */
} hum_parameters;

struct hum {
    real amplitude;
    real frequency;
    real phase;
};

HIDDEN_BEGIN
extern const struct stage hum_stage;
extern const struct stage_analysis hum_analysis;
HIDDEN_END

/* --- lag.h --- */

/* First-order lag of the amplifier, exact pole and no zero: y_k = y_{k-1} + g (x_k - y_{k-1}) with
 * g = 1 - exp(-Ts / lag.timeConstant). Linear. */

typedef struct lag_parameters {
    real timeConstant; /* s; 0: none */
} lag_parameters;

struct lag {
    real gain;     /* g */
    real per_gain; /* 1 / g, without derivatives: an inverse waits for a division */
};

struct lag_state {
    real y; /* y_{k-1} */
};

HIDDEN_BEGIN
extern const struct stage lag_stage;
extern const struct stage_analysis lag_analysis;
HIDDEN_END

/* --- load.h --- */

/* Elastic load: y_k = x_k - load.compliance F_k, the force F compressive positive. Linear in x and F;
 * no state. */

typedef struct load_parameters {
    real compliance; /* m/N; 0: rigid */
} load_parameters;

struct load {
    real compliance;
};

HIDDEN_BEGIN
extern const struct stage load_stage;
extern const struct stage_analysis load_analysis;
HIDDEN_END

/* --- nonlinearity.h --- */

/* Static curve, the stack's or the sensor's: z maps minimum..maximum, counted from the sensor's zero, to
 * -1..1, and
 *     y = x + (1 - z^2) (quadratic + cubic z + quartic z^2 + quintic z^3 + sextic z^4),
 * x at both ends, and beyond them on with the slope that it has there. It rises with x, so that the inverse is
 * Newton's method between the ends. No state. */

typedef struct nonlinearity_parameters {
    real quadratic; /* m, as the others */
    real cubic;
    real quartic;
    real quintic;
    real sextic;
    real minimum; /* ends of the curve, from the sensor's zero */
    real maximum;
} nonlinearity_parameters;

struct nonlinearity {
    struct nonlinearity_parameters coefficient;
    real centre;
    real half_range;
    /* so that nothing is divided in a tick; without derivatives */
    real per_half_range;
    struct nonlinearity_parameters scaled; /* in half ranges */
    bool cubic;                            /* at most: the other terms are all 0 */
    int steps; /* of Newton's method that are enough anywhere; 0 where the curve bends too much to know */
};

HIDDEN_BEGIN
extern const struct stage nonlinearity_stage;
extern const struct stage_analysis nonlinearity_analysis;
HIDDEN_END

/* --- play.h --- */

/* Rate-independent memory in front of the core, Prandtl-Ishlinskii: h_k = x_k + sum_j w_j p_j,k with
 * the play operators p_j,k = min(max(p_j,k-1, x_k - r_j), x_k + r_j).
 *
 * Thresholds r_j rise and 1 + w_1 + ... + w_j > 0 for every j: then h rises with x, piecewise linearly,
 * and operators engage in the order of their thresholds (|p_i - p_j| <= |r_i - r_j| holds on from
 * rest). So the inverse walks over at most n + 1 segments.
 *
 * How the operators came to rest at the start: demagnetised at initialDemagnetisation, where all their outputs
 * are that voltage, then driven from there by initialExcursion, then to where the stage rests. Both 0: on the
 * initial loading curve of a new stage. */

enum { PLAY_MAX = 32 };

struct play_element {
    real threshold; /* r_j, V */
    real weight;    /* w_j */
};

typedef struct play_element play_parameters[PLAY_MAX];

struct play {
    int first; /* of derivatives: those before are 0 */
    int count;
    struct play_element element[PLAY_MAX];
};

struct play_state {
    real p[PLAY_MAX]; /* p_j,k-1 */
};

HIDDEN_BEGIN
extern const struct stage play_stage;
extern const struct stage_analysis play_analysis;
HIDDEN_END

/* --- resonance.h --- */

/* Mechanical resonance, exact poles and at most one zero:
 * y_k = a1 y_{k-1} + a2 y_{k-2} + (1 - a1 - a2) (x_k - z x_{k-1}) / (1 - z).
 *
 * resonance.frequency is the undamped one. z is resonance.samplingZero, which a sampled resonance has where
 * its input runs straight between samples: -0.27, beside 0.79 of a tick of delay. Where it is held, half a
 * tick of delay does. Above -1 the inverse is stable; with z = 0 it has no memory. Linear.
 *
 * The output is y resonance.samplingDelay ago, straight between ticks; the inverse does not make up for that.
 * The chain's delay cannot stand for it: that delays what drives the core, which is not linear. */

typedef struct resonance_parameters {
    real frequency; /* Hz; 0: none */
    real damping;   /* of critical */
    real samplingZero;
    real samplingDelay; /* s, up to RESONANCE_MAX_TICKS */
} resonance_parameters;

/* Ticks of delay that the state can give. */
#define RESONANCE_MAX_TICKS 2

struct resonance {
    real a1;
    real a2;
    real b0;      /* (1 - a1 - a2) / (1 - z) */
    real b1;      /* -z b0 */
    real per_b0;  /* 1 / b0, without derivatives: an inverse waits for a division */
    real ticks;   /* of delay */
    real latency; /* the same in s */
};

struct resonance_state {
    real y1; /* y_{k-1} */
    real y2; /* y_{k-2} */
    real x1; /* x_{k-1} */
};

HIDDEN_BEGIN
extern const struct stage resonance_stage;
extern const struct stage_analysis resonance_analysis;
HIDDEN_END

/* --- saturation.h --- */

/* Saturation of the amplifier: y_k = x_k within saturation.minimum..saturation.maximum.
 *
 * It loses information: the inverse gives the nearest voltage within the limits. No state. */

typedef struct saturation_parameters {
    real minimum; /* V; both 0: no limits */
    real maximum;
} saturation_parameters;

struct saturation {
    real minimum;
    real maximum;
};

HIDDEN_BEGIN
extern const struct stage saturation_stage;
extern const struct stage_analysis saturation_analysis;
HIDDEN_END

/* --- slew.h --- */

/* Slew limit of the amplifier: |y_k - y_{k-1}| <= slew.rate Ts.
 *
 * It loses information: the inverse gives the nearest voltage that it lets through unchanged. */

typedef struct slew_parameters {
    real rate; /* V/s; 0: no limit */
} slew_parameters;

struct slew {
    real step; /* largest change from tick to tick */
};

struct slew_state {
    real y; /* y_{k-1} */
};

HIDDEN_BEGIN
extern const struct stage slew_stage;
extern const struct stage_analysis slew_analysis;
HIDDEN_END

/* clang-format off */
#define CHAIN_STAGES(NONE, AIMED, SHORT, LONG, LONGEST) \
    LONGEST(delay, DELAY, BEFORE) \
    SHORT(slew, SLEW, BEFORE) \
    NONE(saturation, SATURATION, BEFORE) \
    AIMED(lag, LAG, BEFORE) \
    LONG(play, PLAY, BEFORE) \
    NONE(load, LOAD, BEHIND) \
    LONG(creep, CREEP, BEHIND) \
    AIMED(resonance, RESONANCE, BEHIND) \
    NONE(drift, DRIFT, BEHIND) \
    NONE(nonlinearity, NONLINEARITY, BEHIND) \
    NONE(hum, HUM, READING)
/* clang-format on */

#define CHAIN_EVERY_STAGE(STAGE) CHAIN_STAGES(STAGE, STAGE, STAGE, STAGE, STAGE)
#define CHAIN_SKIP(name, NAME, side)

/* Names are those of the variable table (python/it2hys/model/variables.toml). */
struct chain_parameters {
    real sampleTime;
    real initialDisplacement;
    real initialDemagnetisation;
    real initialExcursion;
    real initialCreep;
    real initialCreepAge;
    real voltageMin;
    real voltageMax;
    real displacementMin;
    real displacementMax;
    real displacementZero;
    int ruleCount;
    int playCount;
    int creepCount;
    struct it2_rule rule[IT2_MAX_RULES];
#define CHAIN_MEMBER(name, NAME, side) name##_parameters name;
    CHAIN_EVERY_STAGE(CHAIN_MEMBER)
};

/* clang-format off */
enum chain_stage {
#define CHAIN_INDEX(name, NAME, side) CHAIN_STAGE_##NAME,
    CHAIN_EVERY_STAGE(CHAIN_INDEX)
    CHAIN_STAGE_COUNT
};

enum chain_effect {
#define CHAIN_BIT(name, NAME, side) CHAIN_##NAME = 1 << CHAIN_STAGE_##NAME,
    CHAIN_EVERY_STAGE(CHAIN_BIT)
};
/* clang-format on */

struct chain_place;

struct chain {
    unsigned effects; /* that are on, between voltage and displacement (bits) */
    unsigned reading; /* that are on, between displacement and measured */
    const struct chain_place *active[CHAIN_STAGE_COUNT]; /* stages that are on, in their order */
    int before, behind, all;                             /* where in `active` those of each side end */
    /* of them, those that the inverse goes back over, in the same order: that solve, and that limit */
    const struct chain_place *solved[CHAIN_STAGE_COUNT], *limiting[CHAIN_STAGE_COUNT];
    int solved_before, solved_all, limiting_all;
    unsigned char remembering[CHAIN_STAGE_COUNT]; /* numbers in `solved` of those with a LONG memory */
    int remembering_all;
    bool followed[CHAIN_STAGE_COUNT]; /* of `limiting`: what it lets through is where the plant goes */
    struct it2 core;
    struct it2_range displacement; /* of the set */
    struct it2_range reference;    /* that a reference is kept to: wider where a stage behind the core rings */
    struct it2_range voltage;      /* that the inverse keeps to */
    real latency;                  /* of all stages, s */
    /* bytes of struct chain_state, from its beginning, that each way needs */
    size_t walked, retraced;
#define CHAIN_CONSTANTS(name, NAME, side) struct name name;
    CHAIN_EVERY_STAGE(CHAIN_CONSTANTS)
};

#define CHAIN_STATE(name, NAME, side) struct name##_state name;

/* What the plant reached, in the inverse, whose other states are what it aimed at. Only for a time after
 * something was cut off are they different. */
struct chain_reached {
    struct it2_state core;
    CHAIN_STAGES(CHAIN_SKIP, CHAIN_STATE, CHAIN_SKIP, CHAIN_SKIP, CHAIN_SKIP)
};

/* Of type real only. The core's comes first: without effects it is the only one in use. What is long is last. The
 * beginning, to `reached`, is what the inverse aimed at, in the same order. */
struct chain_state {
    struct it2_state core;
    CHAIN_STAGES(CHAIN_SKIP, CHAIN_STATE, CHAIN_SKIP, CHAIN_SKIP, CHAIN_SKIP)
    struct chain_reached reached;
    CHAIN_STAGES(CHAIN_SKIP, CHAIN_SKIP, CHAIN_STATE, CHAIN_SKIP, CHAIN_SKIP)
    CHAIN_STAGES(CHAIN_SKIP, CHAIN_SKIP, CHAIN_SKIP, CHAIN_STATE, CHAIN_SKIP)
    CHAIN_STAGES(CHAIN_SKIP, CHAIN_SKIP, CHAIN_SKIP, CHAIN_SKIP, CHAIN_STATE)
};

enum chain_memory { CHAIN_NONE, CHAIN_AIMED, CHAIN_SHORT, CHAIN_LONG, CHAIN_LONGEST };
enum chain_side { CHAIN_BEFORE, CHAIN_BEHIND, CHAIN_READING };

/* Where a stage is. */
struct chain_place {
    const struct stage *stage;
    enum chain_side side;
    enum chain_memory memory;
    size_t constants; /* in struct chain */
    size_t constants_size;
    size_t state;   /* in struct chain_state */
    size_t reached; /* the same for what the plant reached, where that is kept beside */
    size_t state_size;
};

/* Why the plant does not get to where it should. */
enum chain_limit {
    CHAIN_REFERENCE_RANGE = 1, /* displacementMin..displacementMax */
    CHAIN_AMPLIFIER = 2,       /* a stage that limits */
    CHAIN_VOLTAGE_RANGE = 4,   /* voltageMin..voltageMax */
    CHAIN_RETURNING = 8        /* it is not yet back from where one of these left it */
};

/* What acts on the chain beside its input. */
struct chain_surroundings {
    real force;
    real temperature;
    real time; /* of the tick */
};

/* A state and what the last step made of it, or their derivatives along one direction. */
struct chain_point {
    struct chain_state state;
    real output;
};

/* Is a value outside a range by more than rounding? An inverse that aims at an end takes the plant there but
 * for that. */
static inline bool chain_outside(real value, real minimum, real maximum)
{
    if (value >= minimum && value <= maximum)
        return false;
    const real slack = REAL(1e-9) * (maximum - minimum);
    return !(value >= minimum - slack && value <= maximum + slack);
}

/* Copies a few numbers, one by one: a processor that reads two at a time what was just written one by one
 * waits until it is in memory. Compilers make one copy of it only where the two cannot overlap. */
static inline void copy_words(void *to, const void *from, size_t size)
{
    for (size_t i = 0; i < size; i += sizeof(real))
        memcpy((char *)to + i, (const char *)from + i, sizeof(real));
}

HIDDEN_BEGIN

extern const struct chain_place CHAIN_PLACES[CHAIN_STAGE_COUNT]; /* by enum chain_stage */

/* Of the stages that are on: where they are, their constants and their states. */
static inline const struct chain_place *chain_active(const struct chain *chain, int i)
{
    return chain->active[i];
}

static inline const void *chain_constants_of(const struct chain *chain, const struct chain_place *place)
{
    return (const char *)chain + place->constants;
}

static inline void *chain_state_of(struct chain_state *state, const struct chain_place *place)
{
    return (char *)state + place->state;
}

/* The input of a stage at rest at the output y, and its state. */
static inline real chain_rest_of(const struct chain_place *place, const void *constants, void *state, real y,
                                 const struct chain_parameters *parameters)
{
    real *number = state;

    if (place->stage->rest)
        return place->stage->rest(constants, state, y, parameters);
    for (size_t i = 0; i < place->state_size / sizeof y; i++)
        number[i] = y;
    return y;
}

bool chain_check(const struct chain_parameters *parameters, char *message, size_t size);
void chain_prepare(struct chain *chain, const struct chain_parameters *parameters);

/* Afterwards: where all effects that are on are idle, steps and inverse are those without effects, bit for bit.
 * Not where derivatives by their parameters follow the steps. */
void chain_pass_by_idle(struct chain *chain, const struct chain_parameters *parameters);

/* At rest at initialDisplacement, without force, at drift's reference temperature, time 0: for long if
 * initialCreep is 0, after the play operators' history of initialDemagnetisation and initialExcursion. */
void chain_reset(const struct chain *chain, struct chain_state *state,
                 const struct chain_parameters *parameters);

/* Without effects, one branch is all that the chain adds to the core. */
real chain_step_effects(const struct chain *chain, struct chain_state *state, real voltage,
                        const struct chain_surroundings *around);
static inline real chain_step(const struct chain *chain, struct chain_state *state, real voltage,
                              const struct chain_surroundings *around)
{
    return chain->effects ? chain_step_effects(chain, state, voltage, around)
                          : it2_step(&chain->core, &state->core, voltage);
}

/* The same for a stage, at which nothing is known of what drives the core. */
static inline struct stage_surroundings chain_around(const struct chain_surroundings *around)
{
    return (struct stage_surroundings){ around->force, around->temperature, around->time, 0 };
}

/* Walks the active stages from number `first` to before `end`. */
real chain_walk(const struct chain *chain, int first, int end, struct chain_state *state, real x,
                const struct stage_surroundings *around);

/* The displacement with what is picked up on the way to the recorder. */
real chain_measure_effects(const struct chain *chain, real displacement, real time);
static inline real chain_measure(const struct chain *chain, real displacement, real time)
{
    return chain->reading ? chain_measure_effects(chain, displacement, time) : displacement;
}

/* Voltage that takes the plant to `displacement`. Where it does not get there, `*limits` says why (enum
 * chain_limit, or-ed; otherwise 0), and the voltage is the nearest that can be given. */
real chain_inverse(const struct chain *chain, struct chain_state *state, real displacement,
                   const struct chain_surroundings *around, unsigned *limits);

/* Directional derivatives of chain_step and chain_inverse at `state`, before either advances it:
 * from derivatives of state, input and surroundings to those of the next state and the output. */
struct chain_point chain_step_tangent(const struct chain *chain, const struct chain_state *state, real voltage,
                                      const struct chain_surroundings *around, struct chain_state d_state,
                                      real d_voltage, const struct chain_surroundings *d_around);
struct chain_point chain_inverse_tangent(const struct chain *chain, const struct chain_state *state,
                                         real displacement, const struct chain_surroundings *around,
                                         struct chain_state d_state, real d_displacement,
                                         const struct chain_surroundings *d_around);

/* Is the plant elsewhere than where the inverse aimed at? */
bool chain_is_astray(const struct chain_state *state);

/* Voltage that holds the plant where it is, and the nearest to it that the inverse may give; not finite where
 * none holds it. */
real chain_hold(const struct chain *chain, const struct chain_state *state);
real chain_equilibrium(const struct chain *chain, const struct chain_state *state);

/* Derivative of chain_equilibrium right after chain_reset, in the direction of `d_parameters`. */
real chain_equilibrium_tangent(const struct chain *chain, const struct chain_state *state,
                               const struct chain_parameters *parameters,
                               const struct chain_parameters *d_parameters);

/* By enum chain_stage. */
extern const struct stage_analysis *const CHAIN_ANALYSES[CHAIN_STAGE_COUNT];

static inline const struct stage_analysis *chain_analysis(const struct chain *chain, int i)
{
    return CHAIN_ANALYSES[chain->active[i] - CHAIN_PLACES];
}

/* Derivatives of the constants of all active stages, by the stages' tangents. */
void chain_prepare_tangent(const struct chain *chain, struct chain *d,
                           const struct chain_parameters *parameters,
                           const struct chain_parameters *d_parameters);

/* Derivative of the input at rest of the active stages from number `first` to before `end`, whose output there
 * is y, and of their states at rest. */
real chain_rest_tangent(const struct chain *chain, int first, int end, const struct chain *d_chain, real y,
                        const struct chain_parameters *parameters, struct chain_state *d, real d_y,
                        const struct chain_parameters *d_parameters);

HIDDEN_END

/* --- fmu.h --- */

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

/* --- fmu_clock.h --- */

/* The clock: which ticks lie in a communication step. All FMUs of this project count by it.
 *
 * Ticks are at k * sampleTime and counted as integers; fmi2DoStep(t, h) runs those in [t, t + h). Masters
 * compute t += h, and after millions of steps their t is off by more than a tick may be. So an instance
 * keeps the time itself: startTime plus the lengths of the steps since, as a tick and a rest. What the
 * master says of the time is compared with that at every step:
 *
 *   1. Where they differ by no more than CLOCK_TOLERANCE and what a master's additions can have lost since
 *      startTime (half a unit in the last place each; CLOCK_ADDITIONS of them for each step and each sample
 *      time), the clock goes on by the step's length. So no tick slips, whether the master adds up or
 *      multiplies, and whichever of them goes on from a state that another has left.
 *   2. Where they differ by more, and yet the step begins where the master's last one ended (to within
 *      2 CLOCK_TOLERANCE), its times and lengths contradict each other: the clock is set to its time.
 *   3. Anything else is a jump, and refused. The way back is an FMU state.
 *
 * Where a step ends within CLOCK_ROUNDING of a tick, the clock is put on the tick: the length of a step may
 * be the difference of two times, and have lost what they have. A tick less than 2 CLOCK_TOLERANCE before
 * the end of a step is taken to lie at the end, and runs in the next one: a master may count nanoseconds,
 * or shorten its last step by what it has lost. No tick is run twice or left out. */

#define CLOCK_TOLERANCE 5e-4 /* sample times */
#define CLOCK_ROUNDING 2e-15 /* of the time: what a few operations do to it */
#define CLOCK_ADDITIONS 64.0 /* a master may have a step of its own, shorter than that of this instance */

/* Beyond this, ticks are no longer exact in a double. */
#define CLOCK_LARGEST_TICK 9007199254740992.0

/* Ticks: half a minute's work, which nobody can interrupt. */
#define CLOCK_LONGEST_STEP 1e9

/* No padding, because it is serialized. */
struct fmu_clock {
    int64_t tick;      /* the last one at or before now */
    double rest;       /* from there to now, in sample times: 0 <= rest < 1 */
    int64_t next_tick; /* to be run */
    int64_t additions; /* steps and whole sample times since the clock was set */
    double time;       /* now, as the master says */
    double stop_time;  /* INFINITY where there is none */
};

/* Sets start and stop; where they are none, returns false, and `text` says why. */
static inline bool fmu_clock_setup(struct fmu_clock *clock, double start_time, bool stop_time_defined,
                                   double stop_time, char *text, size_t size)
{
    if (!isfinite(start_time)) {
        snprintf(text, size, "startTime is not a finite number");
        return false;
    }
    if (stop_time_defined && !(stop_time >= start_time)) {
        snprintf(text, size, "stopTime, %g s, must not be before startTime, %g s", stop_time, start_time);
        return false;
    }
    clock->time = start_time;
    clock->stop_time = stop_time_defined ? stop_time : INFINITY;
    return true;
}

/* Now, in sample times. */
static inline double fmu_clock_ticks(const struct fmu_clock *clock)
{
    return (double)clock->tick + clock->rest;
}

/* Puts the clock `ticks` >= 0 behind clock->tick; on a tick that is within `rounding`. */
static inline void fmu_clock_put(struct fmu_clock *clock, double ticks, double rounding)
{
    const int64_t whole = (int64_t)ticks; /* floor is a call where the processor may be an old one */
    const double rest = ticks - (double)whole;
    const bool before = rest >= 1.0 - rounding;

    clock->tick += whole + before;
    clock->rest = before || rest <= rounding ? 0.0 : rest;
    const int64_t due = clock->tick + (clock->rest > 2.0 * CLOCK_TOLERANCE);
    if (due > clock->next_tick)
        clock->next_tick = due;
}

/* Sets the clock to the master's time. */
static inline void fmu_clock_set(struct fmu_clock *clock, double sample_time)
{
    const double ticks = clock->time / sample_time;
    const bool countable = fabs(ticks) < CLOCK_LARGEST_TICK;

    clock->tick = countable ? (int64_t)ticks - (ticks < 0.0) : (int64_t)CLOCK_LARGEST_TICK;
    fmu_clock_put(clock, countable ? ticks - (double)clock->tick : 0.0, CLOCK_ROUNDING * fabs(ticks));
    clock->additions = 0;
}

/* When initialization is over. */
static inline void fmu_clock_start(struct fmu_clock *clock, double sample_time)
{
    clock->next_tick = INT64_MIN;
    fmu_clock_set(clock, sample_time);
}

/* How far two numbers for the same time may be apart, in sample times. */
static inline double fmu_clock_slack(const struct fmu_clock *clock)
{
    return CLOCK_TOLERANCE + CLOCK_ROUNDING * fabs((double)clock->tick);
}

/* What a master's additions can have lost since the clock was set, in sample times. No time since then is
 * farther from now than there are additions. */
static inline double fmu_clock_lost(const struct fmu_clock *clock)
{
    const double additions = (double)clock->additions;

    return CLOCK_ADDITIONS * additions * 0.5 * DBL_EPSILON * (fabs((double)clock->tick) + additions);
}

/* Rules 1 and 2. */
static inline bool fmu_clock_agrees(const struct fmu_clock *clock, double sample_time, double time)
{
    const double off = fabs(time - fmu_clock_ticks(clock) * sample_time);

    return off <= (fmu_clock_slack(clock) + fmu_clock_lost(clock)) * sample_time;
}

static inline bool fmu_clock_continues(const struct fmu_clock *clock, double sample_time, double time)
{
    return fabs(time - clock->time) <= 2.0 * fmu_clock_slack(clock) * sample_time;
}

/* By the clock's time and by the master's: one of them may have lost something. */
static inline bool fmu_clock_beyond_stop(const struct fmu_clock *clock, double sample_time)
{
    const double beyond = clock->stop_time + 2.0 * fmu_clock_slack(clock) * sample_time;

    return clock->time > beyond && fmu_clock_ticks(clock) * sample_time > beyond;
}

/* fmu_clock_step by the rules. */
static inline bool fmu_clock_any_step(const struct fmu_clock *now, double sample_time, double time, double step,
                                      struct fmu_clock *end)
{
    const double ticks = step / sample_time;

    *end = *now;
    if (!fmu_clock_agrees(now, sample_time, time)) {
        if (!fmu_clock_continues(now, sample_time, time))
            return false;
        end->time = time;
        fmu_clock_set(end, sample_time);
    }
    const double largest = fabs((double)end->tick) + ticks;
    if (!(ticks >= 0.0 && ticks <= CLOCK_LONGEST_STEP && largest < CLOCK_LARGEST_TICK))
        return false;
    const double rounding = CLOCK_ROUNDING * largest;
    fmu_clock_put(end, end->rest + ticks, rounding < 0.25 * ticks ? rounding : 0.25 * ticks);
    end->time = time + step;
    end->additions += 1 + (int64_t)ticks;
    return !(end->time > end->stop_time && fmu_clock_beyond_stop(end, sample_time));
}

/* Is a step one from a tick to the next, as most are, by rule 1? Hardly ever one gets beyond its tolerance. */
static inline bool fmu_clock_is_tick(const struct fmu_clock *now, double sample_time, double time, double step)
{
    const double off = fabs(time - (double)now->tick * sample_time);

    return step == sample_time && now->rest <= 0.0 && now->next_tick == now->tick &&
           now->tick < (int64_t)CLOCK_LARGEST_TICK - 1 && time + step <= now->stop_time &&
           (off <= CLOCK_TOLERANCE * sample_time || fmu_clock_agrees(now, sample_time, time));
}

/* Goes on by such a step, which ends at `time`. */
static inline void fmu_clock_tick(struct fmu_clock *clock, double time)
{
    clock->tick++;
    clock->next_tick = clock->tick;
    clock->additions += 2;
    clock->time = time;
}

/* Sets `end` to the end of a step, whose ticks are those from now->next_tick to before end->next_tick. False
 * where there is no such step (fmu_clock_refusal says why): where anything is not a number, too. */
static inline bool fmu_clock_step(const struct fmu_clock *now, double sample_time, double time, double step,
                                  struct fmu_clock *end)
{
    if (!fmu_clock_is_tick(now, sample_time, time, step))
        return fmu_clock_any_step(now, sample_time, time, step, end);
    *end = *now;
    fmu_clock_tick(end, time + step);
    return true;
}

/* Why a step was refused. */
static inline const char *fmu_clock_refusal(const struct fmu_clock *now, double sample_time, double time,
                                            double step, char *text, size_t size)
{
    const double end = time + step;
    const double ticks = step / sample_time;

    if (!isfinite(time) || !isfinite(step) || step < 0.0)
        snprintf(text, size,
                 "a step of %g s from %g s is not possible; both must be finite and the step not "
                 "negative",
                 step, time);
    else if (!(fabs(time / sample_time) + ticks < CLOCK_LARGEST_TICK &&
               fabs((double)now->tick) + ticks < CLOCK_LARGEST_TICK))
        snprintf(text, size, "at %g s ticks of %g s can no longer be counted", end, sample_time);
    else if (!fmu_clock_agrees(now, sample_time, time) && !fmu_clock_continues(now, sample_time, time))
        snprintf(text, size,
                 "the step begins at %.17g s, but this instance is at %.17g s; to go back, set an "
                 "earlier FMU state",
                 time, now->time);
    else if (ticks > CLOCK_LONGEST_STEP)
        snprintf(text, size,
                 "the step of %g s has %.4g ticks of %g s; at most %g are run in one step, so make "
                 "shorter ones",
                 step, ticks, sample_time, CLOCK_LONGEST_STEP);
    else
        snprintf(text, size, "the step ends at %.17g s, after stopTime, %.17g s", end, now->stop_time);
    return text;
}

/* Can these numbers be those of a clock? For states that were not made here. */
static inline bool fmu_clock_plausible(const struct fmu_clock *clock, double sample_time)
{
    struct fmu_clock due = { .tick = clock->tick, .next_tick = INT64_MIN };

    if (!(isfinite(clock->time) && clock->stop_time > -INFINITY && clock->rest >= 0.0 && clock->rest < 1.0 &&
          fabs((double)clock->tick) <= CLOCK_LARGEST_TICK && clock->additions >= 0 &&
          (double)clock->additions <= 2.0 * CLOCK_LARGEST_TICK))
        return false;
    fmu_clock_put(&due, clock->rest, 0.0);
    const double ahead = (double)clock->next_tick - (double)due.next_tick; /* since it was set back */
    const double off = fabs(clock->time / sample_time - fmu_clock_ticks(clock));
    return ahead >= 0.0 && ahead <= CLOCK_LONGEST_STEP &&
           off <= 2.0 * fmu_clock_slack(clock) + fmu_clock_lost(clock);
}

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

/* --- fmu_places.h --- */

/* Generated from variables.toml by codegen.py. */
#define IN_REFERENCE 0
#define IN_FORCE 1
#define IN_TEMPERATURE 2
#define OUT_VOLTAGE 0
#define OUT_SATURATED 0
#define IN_VOLTAGE 0
#define OUT_DISPLACEMENT 0
#define OUT_MEASURED 1
#define OUT_OUT_OF_RANGE 0
#define FMU_TABLE_ROWS 237
#define FMU_PLANT_INPUT_START { 0.0, 0.0, 293.15 }
#define FMU_INVERSE_INPUT_START { 0.0, 0.0, 293.15 }

#define MICROMETRES "\xc2\xb5m" /* as UTF-8, whatever the compiler takes the source for */

enum { FMU_PLANT = 1, FMU_INVERSE = 2 };

HIDDEN_BEGIN

extern const struct fmu_model plant_model, inverse_model;

extern const struct fmu_variable actuator_table[];

/* The constants. */
struct actuator {
    struct chain chain; /* first: a pointer to it is one to the actuator */
    struct it2_table table;
};

bool actuator_settle(void *constants);

bool actuator_check(const struct fmu_model *model, const void *parameters, char *message, size_t size);

static inline struct chain_surroundings actuator_surroundings(const double input[FMU_INPUTS], double time)
{
    return (struct chain_surroundings){ input[IN_FORCE], input[IN_TEMPERATURE], time };
}

/* The derivative of it; time is none of the knowns. */
static inline struct chain_surroundings actuator_surroundings_tangent(const double d_input[FMU_INPUTS])
{
    return actuator_surroundings(d_input, 0.0);
}

HIDDEN_END

/* Initialisers of what their models have in common. */
#define ACTUATOR \
    .table = actuator_table, .rows = FMU_TABLE_ROWS, .parameters_size = sizeof(struct chain_parameters), \
    .constants_size = sizeof(struct actuator), .state_size = sizeof(struct chain_state), .interpolates = true, \
    .check = actuator_check

#endif
