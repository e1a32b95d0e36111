/* Long runs: test_soak [TICKS], 1e7 by default; `make bench` runs 1e9. Time is N * Ts after N ticks, to
 * the bit; a run that was serialized on the way and went on elsewhere ends in the same bits; memory
 * does not grow. */
#include <stdlib.h>

#include "fmi2_fixture.h"

CHECK_MAIN;

#define BLOCK 1000 /* ticks, made in steps of different sizes */

static const int STEP[] = { 1, 7, 100, 892 };

/* Pages of address space; 0 where the system does not say. */
static long memory_pages(void)
{
    long size = 0, resident = 0;
    FILE *file = fopen("/proc/self/statm", "r");

    if (file) {
        if (fscanf(file, "%ld %ld", &size, &resident) != 2)
            size = 0;
        fclose(file);
    }
    return size;
}

/* Blocks from..to-1; masters that count their steps hand over times without drift. */
static void run(const struct fmi2_api *m, fmi2Component c, long from, long to)
{
    const fmi2ValueReference input = reference_of(m, input_of(m));
    long wrong = 0;

    for (long block = from; block < to; block++) {
        double tick = (double)block * BLOCK;
        for (int i = 0; i < 4; i++) {
            const double time = tick * TS, end = (tick + STEP[i]) * TS;
            const double value = signal(m, (double)(block % 977) * 0.0037 + 0.001 * i);
            wrong += m->SetReal(c, &input, 1, &value) != fmi2OK;
            wrong += m->DoStep(c, time, end - time, fmi2True) > fmi2Warning;
            tick += STEP[i];
        }
    }
    CHECK(wrong == 0);
}

static void soak(const struct fmi2_api *m, long blocks)
{
    const long late = blocks - blocks / 10;
    const double ticks = (double)blocks * BLOCK;
    struct state_bytes half, whole, again;
    fmi2FMUstate state = NULL;
    double time = -1.0;
    fmi2Component c = make_running(m, 0.0);

    run(m, c, 0, blocks / 100);
    const long pages = memory_pages();
    run(m, c, blocks / 100, late);
    read_state(m, c, &half);
    run(m, c, late, blocks);
    CHECK(memory_pages() == pages);
    CHECK(m->GetRealStatus(c, fmi2LastSuccessfulTime, &time) == fmi2OK);
    CHECK(fabs(time - ticks * TS) <= 1e-15 * time); /* the last t + h, rounded once */
    CHECK(block_of(c)->s.clock.next_tick == (int64_t)blocks * BLOCK);
    read_state(m, c, &whole);
    m->FreeInstance(c);

    c = make(m);
    CHECK(m->DeSerializeFMUstate(c, half.byte, half.size, &state) == fmi2OK);
    CHECK(m->SetFMUstate(c, state) == fmi2OK);
    run(m, c, late, blocks);
    read_state(m, c, &again);
    CHECK(same_state(&whole, &again));
    m->FreeFMUstate(c, &state);
    m->FreeInstance(c);
    printf("%s: %.3g ticks, time %.17g s, %s\n", m->identifier, ticks, time,
           pages ? "no page of memory more" : "memory not measured on this system");
}

int main(int count, char **argument)
{
    const double ticks = count > 1 ? strtod(argument[1], NULL) : 1e7;
    const long blocks = (long)(ticks / BLOCK);

    soak(&PLANT, blocks);
    if (count == 1)
        soak(&INVERSE, blocks);
    return check_report("soak");
}
