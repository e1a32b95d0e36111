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
#ifndef IT2HYS_FMU_CLOCK_H
#define IT2HYS_FMU_CLOCK_H

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

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

#endif
