/* Log categories, the quiet default, and percent signs, which a logger takes for a printf format. */
#include "fmi2_fixture.h"

CHECK_MAIN;

static fmi2Component named(const struct fmi2_api *m, const char *name, fmi2Boolean logging)
{
    forget_log();
    return m->Instantiate(name, fmi2CoSimulation, guid_of(m), NULL, &CALLBACKS, fmi2False, logging);
}

/* Without loggingOn events are not logged; what comes with a status is. */
static void default_is_quiet(const struct fmi2_api *m)
{
    fmi2Component c = named(m, "quiet", fmi2False);

    CHECK(c && logged.count == 0);
    CHECK(m->EnterInitializationMode(c) == fmi2OK && m->ExitInitializationMode(c) == fmi2OK);
    CHECK(set_real(m, c, input_of(m), m == &PLANT ? -10.0 : 1e-3) == fmi2OK); /* out of range */
    CHECK(m->DoStep(c, 0.0, TS, fmi2True) == fmi2Warning && logged.count > 0);
    CHECK(strcmp(logged.category, "logStatusWarning") == 0 && logged.status == fmi2Warning);
    forget_log();
    CHECK(m->DoStep(c, TS, 100 * TS, fmi2True) == fmi2OK && logged.count == 0); /* said once */
    CHECK(set_real(m, c, input_of(m), NAN) == fmi2Discard && logged.count == 1);
    CHECK(strcmp(logged.category, "logStatusDiscard") == 0 && strcmp(logged.instance, "quiet") == 0);
    CHECK(m->EnterInitializationMode(c) == fmi2Error && logged.count == 2);
    CHECK(strcmp(logged.category, "logStatusError") == 0 && logged.status == fmi2Error);
    m->FreeInstance(c);
}

static void loud_says_events(const struct fmi2_api *m)
{
    fmi2Component c = named(m, "loud", fmi2True);

    CHECK(c && logged.count == 1 && strcmp(logged.category, "logEvents") == 0);
    CHECK(log_says(m->identifier) && logged.status == fmi2OK);
    m->FreeInstance(c);
}

/* How many messages one error, one discard and one warning leave. */
static void provoke(const struct fmi2_api *m, fmi2Component c, int *errors, int *discards, int *warnings)
{
    forget_log();
    m->EnterInitializationMode(c);
    *errors = logged.count;
    forget_log();
    set_real(m, c, "force", NAN);
    *discards = logged.count;
    forget_log();
    set_real(m, c, input_of(m), m == &PLANT ? 2e-1 : 1e-3);
    m->DoStep(c, 0.0, TS, fmi2True);
    *warnings = logged.count;
}

static void categories(const struct fmi2_api *m)
{
    static const struct {
        const char *category;
        fmi2Boolean on;
        int errors, discards, warnings;
    } CASES[] = {
        { "logAll", fmi2True, 1, 1, 1 },
        { "logAll", fmi2False, 0, 0, 0 },
        { "logStatusWarning", fmi2False, 1, 1, 0 },
        { "logStatusError", fmi2False, 0, 1, 1 },
        { "logStatusDiscard", fmi2False, 1, 0, 1 },
        { "logEvents", fmi2True, 1, 1, 1 },
        { NULL, fmi2True, 1, 1, 1 },
        { NULL, fmi2False, 0, 0, 0 },
    };

    for (size_t i = 0; i < sizeof CASES / sizeof CASES[0]; i++) {
        fmi2Component c = make_running(m, 0.0);
        int errors, discards, warnings;
        CHECK(m->SetDebugLogging(c, CASES[i].on, CASES[i].category ? 1 : 0, &CASES[i].category) == fmi2OK);
        provoke(m, c, &errors, &discards, &warnings);
        CHECK(errors == CASES[i].errors && discards == CASES[i].discards);
        if (m == &INVERSE) /* its reference out of reach warns */
            CHECK((warnings > 0) == CASES[i].warnings);
        m->FreeInstance(c);
    }
}

static void unknown_categories(const struct fmi2_api *m)
{
    fmi2Component c = make(m);
    const fmi2String bad[] = { "logAll", "logNothing" }, none[] = { NULL }, percent[] = { "100%s%n%d" };
    int errors, discards, warnings;

    forget_log();
    CHECK(m->SetDebugLogging(c, fmi2False, 2, bad) == fmi2Error);
    CHECK(log_says("'logNothing'") && log_says("logStatusWarning"));
    CHECK(m->SetDebugLogging(c, fmi2False, 1, none) == fmi2Error && log_says("(null)"));
    CHECK(m->SetDebugLogging(c, fmi2True, 1, NULL) == fmi2Error && log_says("null"));
    CHECK(m->SetDebugLogging(c, fmi2True, 1, percent) == fmi2Error && log_says("'100%s%n%d'"));
    m->FreeInstance(c);
    c = make_running(m, 0.0);
    m->SetDebugLogging(c, fmi2False, 2, bad); /* refused as a whole: errors are still logged */
    provoke(m, c, &errors, &discards, &warnings);
    CHECK(errors == 1 && discards == 1);
    m->FreeInstance(c);
}

static void awkward_texts(const struct fmi2_api *m)
{
    static char text[3000];
    fmi2Component c = named(m, "50 % %s %n rig", fmi2False);
    const fmi2String category[] = { text };

    CHECK(m->DoStep(c, 0.0, TS, fmi2True) == fmi2Error);
    CHECK(strcmp(logged.instance, "50 % %s %n rig") == 0);
    memset(text, '%', sizeof text - 1); /* longer than any message, doubled when escaped */
    CHECK(m->SetDebugLogging(c, fmi2True, 1, category) == fmi2Error && log_says("%%%%%%%%"));
    CHECK(strlen(logged.text) < 1024);
    m->FreeInstance(c);
}

static void of_model(const struct fmi2_api *m)
{
    default_is_quiet(m);
    loud_says_events(m);
    categories(m);
    unknown_categories(m);
    awkward_texts(m);
}

int main(void)
{
    of_model(&PLANT);
    of_model(&INVERSE);
    return check_report("fmi2 log");
}
