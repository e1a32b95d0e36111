/* The one list of stages, in the order of the chain: those before the core, behind it, and on the way to the
 * recorder. Each stands under the memory that it has:
 *
 *   NONE      no state
 *   AIMED     a tick or two; the inverse keeps what it aimed at, and beside it what the plant reached
 *   SHORT     a tick; the inverse keeps what the plant reached
 *   LONG      many numbers, of which the same is true
 *   LONGEST   even more of them */
#ifndef IT2HYS_STAGES_H
#define IT2HYS_STAGES_H

#include "creep.h"
#include "delay.h"
#include "drift.h"
#include "hum.h"
#include "lag.h"
#include "load.h"
#include "nonlinearity.h"
#include "play.h"
#include "resonance.h"
#include "saturation.h"
#include "slew.h"

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

#endif
