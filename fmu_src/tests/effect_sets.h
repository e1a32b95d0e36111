/* Random parameter sets with effects, and signals for them. Lengths in um. */
#ifndef IT2HYS_EFFECT_SETS_H
#define IT2HYS_EFFECT_SETS_H

#include <math.h>

#include "chain.h"
#include "sets.h"

/* Table 1 without effects. */
static inline void plain(struct chain_parameters *p)
{
    *p = (struct chain_parameters){ .sampleTime = 1e-4,
                                    .voltageMin = -50.0,
                                    .voltageMax = 150.0,
                                    .displacementMax = 16.0,
                                    .ruleCount = 3,
                                    .initialDisplacement = 5.0,
                                    .displacementZero = 0.3 };
    memcpy(p->rule, TABLE_1, sizeof TABLE_1);
}

static inline void add_memory(uint64_t *seed, struct chain_parameters *p)
{
    double threshold = 0.0;

    p->playCount = 1 + (int)random_between(seed, 0.0, PLAY_MAX);
    for (int j = 0; j < p->playCount; j++) {
        p->play[j].threshold = threshold += random_between(seed, 0.1, 6.0);
        p->play[j].weight = random_between(seed, -0.5, 0.5) / p->playCount;
    }
}

static inline void add_creep(uint64_t *seed, struct chain_parameters *p)
{
    p->creepCount = 1 + (int)random_between(seed, 0.0, CREEP_MAX);
    for (int i = 0; i < p->creepCount; i++) {
        p->creep[i].gain = random_between(seed, -0.01, 0.03);
        p->creep[i].timeConstant = pow(10.0, random_between(seed, -4.5, 2.0));
    }
}

static inline void add_effects(uint64_t *seed, struct chain_parameters *p, unsigned effects)
{
    if (effects & CHAIN_DELAY)
        p->delay.time = 1e-4 * random_between(seed, 0.0, 8.0);
    if (effects & CHAIN_SLEW)
        p->slew.rate = random_between(seed, 2e3, 2e4);
    if (effects & CHAIN_SATURATION)
        p->saturation = (struct saturation_parameters){ random_between(seed, 0.0, 40.0),
                                                        random_between(seed, 70.0, 100.0) };
    if (effects & CHAIN_LAG)
        p->lag.timeConstant = random_between(seed, 1e-5, 1e-3);
    if (effects & CHAIN_PLAY)
        add_memory(seed, p);
    if (effects & CHAIN_LOAD)
        p->load.compliance = random_between(seed, 0.0, 0.05);
    if (effects & CHAIN_CREEP)
        add_creep(seed, p);
    if (effects & CHAIN_RESONANCE)
        p->resonance =
            (struct resonance_parameters){ random_between(seed, 300.0, 4500.0), random_between(seed, 0.02, 0.9),
                                           random_between(seed, -0.6, 0.0), 0.0 };
    /* no inverse makes up for this one, either */
    if (effects & CHAIN_RESONANCE && effects & CHAIN_DELAY)
        p->resonance.samplingDelay = 1e-4 * random_between(seed, 0.0, 2.0);
    if (effects & CHAIN_DRIFT)
        p->drift =
            (struct drift_parameters){ random_between(seed, -0.02, 0.02), random_between(seed, -2.0, 2.0) };
    if (effects & CHAIN_NONLINEARITY)
        p->nonlinearity = (struct nonlinearity_parameters){ random_between(seed, -0.3, 0.3),
                                                            random_between(seed, -0.3, 0.3),
                                                            random_between(seed, -0.3, 0.3),
                                                            random_between(seed, -0.3, 0.3),
                                                            random_between(seed, -0.3, 0.3),
                                                            0.0,
                                                            16.0 };
    if (effects & CHAIN_HUM)
        p->hum = (struct hum_parameters){ 0.02, random_between(seed, 10.0, 400.0), 1.0 };
}

/* The voltage that holds a set where it begins. */
static inline double hold_voltage(const struct chain_parameters *p)
{
    struct chain chain;
    struct chain_state state;

    chain_prepare(&chain, p);
    chain_reset(&chain, &state, p);
    return chain_equilibrium(&chain, &state);
}

/* Smooth signals over the actuator's range. */
static inline double swing(double low, double high, int tick, double phase)
{
    const double t = 1e-4 * tick;

    return 0.5 * (low + high) + 0.5 * (high - low) * (0.8 * sin(250.0 * t + phase) + 0.2 * sin(1700.0 * t));
}

static inline struct chain_surroundings surroundings(int tick)
{
    return (struct chain_surroundings){ swing(-10.0, 10.0, tick, 2.0), swing(288.0, 298.0, tick, 1.0),
                                        1e-4 * tick };
}

#endif
