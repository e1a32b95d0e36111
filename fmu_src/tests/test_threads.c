/* 1000 instances in 8 threads, each at its own point of its own run: every one of them computes what
 * a single one computes. Under ThreadSanitizer (hardened.sh) this shows that they share nothing. */
#include <pthread.h>

#include "fmi2_fixture.h"

CHECK_MAIN;

enum { THREADS = 8, INSTANCES = 125, TICKS = 60 };

static const struct fmi2_api *const MODEL[] = { &PLANT, &INVERSE };
static char guid[2][64]; /* from the fixture, whose buffer is for one thread */
static double expected[2][TICKS];

/* The fixture's logger notes messages for one thread. */
static void drop(fmi2ComponentEnvironment environment, fmi2String instance, fmi2Status status,
                 fmi2String category, fmi2String message, ...)
{
    (void)environment, (void)instance, (void)status, (void)category, (void)message;
}

static fmi2Component start(int model)
{
    static const fmi2CallbackFunctions host = { drop, NULL, NULL, NULL, NULL };
    const struct fmi2_api *m = MODEL[model];
    fmi2Component c = m->Instantiate("thread", fmi2CoSimulation, guid[model], NULL, &host, fmi2False, fmi2True);

    if (c) {
        m->SetupExperiment(c, fmi2False, 0.0, 0.0, fmi2False, 0.0);
        m->EnterInitializationMode(c);
        m->ExitInitializationMode(c);
    }
    return c;
}

/* Goes through an own state each tick, so that states are made in parallel too. */
static double tick(int model, fmi2Component c, int k)
{
    const struct fmi2_api *m = MODEL[model];
    const fmi2ValueReference input = model == 0 ? 0 : 1, output = model == 0 ? 4 : 6;
    const double value = signal(m, k * TS);
    fmi2FMUstate state = NULL;
    double result = NAN;

    m->SetReal(c, &input, 1, &value);
    m->GetFMUstate(c, &state);
    m->DoStep(c, k * TS, TS, fmi2True);
    m->SetFMUstate(c, state);
    m->FreeFMUstate(c, &state);
    m->DoStep(c, k * TS, TS, fmi2True);
    m->GetReal(c, &output, 1, &result);
    return result;
}

/* A thread's instances, one tick of each in turn; `argument` counts what differs. */
static void *work(void *argument)
{
    fmi2Component c[INSTANCES];
    long *wrong = argument;

    for (int i = 0; i < INSTANCES; i++) {
        c[i] = start(i % 2);
        *wrong += c[i] == NULL;
    }
    for (int k = 0; k < TICKS; k++)
        for (int i = 0; i < INSTANCES; i++)
            *wrong += c[i] && tick(i % 2, c[i], k) != expected[i % 2][k];
    for (int i = 0; i < INSTANCES; i++)
        MODEL[i % 2]->FreeInstance(c[i]);
    return NULL;
}

int main(void)
{
    pthread_t thread[THREADS];
    long wrong[THREADS] = { 0 };

    for (int model = 0; model < 2; model++) {
        strcpy(guid[model], guid_of(MODEL[model]));
        fmi2Component c = start(model);
        for (int k = 0; k < TICKS; k++)
            expected[model][k] = tick(model, c, k);
        CHECK(isfinite(expected[model][TICKS - 1]));
        MODEL[model]->FreeInstance(c);
    }
    for (int i = 0; i < THREADS; i++)
        CHECK(pthread_create(&thread[i], NULL, work, &wrong[i]) == 0);
    for (int i = 0; i < THREADS; i++) {
        CHECK(pthread_join(thread[i], NULL) == 0);
        CHECK(wrong[i] == 0);
    }
    return check_report("threads");
}
