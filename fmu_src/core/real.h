/* The number type of the core: double, or float where IT2HYS_SINGLE is defined, for processors whose
 * floating-point unit is single. All sources of a program are compiled with the same choice.
 *
 * Nothing is computed in double then. So literals that meet a `real` are whole numbers, which C converts to
 * either type without a loss, or stand in REAL(); functions of <math.h> are called by the names below, and
 * what is printed is cast. <tgmath.h> would choose the functions too, but not the literals, and compilers for
 * small processors often lack it. */
#ifndef IT2HYS_REAL_H
#define IT2HYS_REAL_H

#include <float.h>
#include <math.h>

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

#endif
