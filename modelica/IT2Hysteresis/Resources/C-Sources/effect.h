/* What the effects' files share. An effect is a stage of the chain (chain.h), off by default.
 *
 * Each has a parameter struct with the names of the variable table, a struct of constants set once by
 * <effect>_prepare, a state struct of doubles, and
 *     <effect>_check      are the parameters usable? if not, the message names the culprit
 *     <effect>_reset      the state of rest at a given value
 *     <effect>_step       input to output; advances the state
 *     <effect>_inverse    output to input; advances the state to what step would have left
 * A linear stage (delay, lag, load, creep, resonance) is its own directional derivative: step and
 * inverse of the derivatives of state and input give those of next state and output. The others have
 *     <effect>_step_tangent, and a tangent of the inverse where that is another function. */
#ifndef IT2HYS_EFFECT_H
#define IT2HYS_EFFECT_H

#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

#include "hidden.h"

#define TWO_PI 6.283185307179586

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
static inline double clamp(double value, double low, double high)
{
    return value < low ? low : value > high ? high : value;
}

#endif
