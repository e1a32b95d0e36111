/* The parameter set of a packaged FMU: found by any spelling of the resources' location, refused
 * where it is not the set that the GUID names. Works in its own directory, that of the build. */
#if !defined _WIN32
#define _POSIX_C_SOURCE 200809L
#endif
#include <stdlib.h>
#if defined _WIN32
#include <direct.h>
#define make_directory(name) _mkdir(name)
#define current_directory(path, size) _getcwd(path, size)
#else
#include <sys/stat.h>
#include <unistd.h>
#define make_directory(name) mkdir(name, 0777)
#define current_directory(path, size) getcwd(path, size)
#endif

#include "fmi2_fixture.h"

CHECK_MAIN;

#define DIRECTORY "parameters 100%"
#define ENCODED "parameters%20100%25"

static char set[8192];
static size_t set_size;

static void add(const char *name, const char *type, const char *value)
{
    set_size += (size_t)snprintf(set + set_size, sizeof set - set_size,
                                 "<ssv:Parameter name=\"%s\"><ssv:%s value=\"%s\"/></ssv:Parameter>\n", name,
                                 type, value);
}

/* One rule: y = 0.5 y + 1e-8 x. */
static void make_set(void)
{
    set_size = 0;
    add("sampleTime", "Real", "2.5e-4");
    add("initialDisplacement", "Real", "1e-06");
    add("voltageMin", "Real", "-10.5");
    add("voltageMax", "Real", "110.0");
    add("displacementMin", "Real", "0.0");
    add("displacementMax", "Real", "1.5e-05");
    add("ruleCount", "Integer", "1");
    add("rule[1].sigmaLower", "Real", "1e-06");
    add("rule[1].sigmaUpper", "Real", "2e-06");
    add("rule[1].centre", "Real", "3e-06");
    add("rule[1].q1", "Real", "0.5");
    add("rule[1].q2", "Real", "1e-08");
    add("rule[1].q3", "Real", "0.0");
}

static void write_set(void)
{
    FILE *file = fopen(DIRECTORY "/parameters.ssv", "wb");

    CHECK(file && fwrite(set, 1, set_size, file) == set_size);
    if (file)
        fclose(file);
}

static const char *guid_of_set(const struct fmi2_api *m)
{
    static char guid[64];
    const unsigned long long table = m->table_hash, parameters = fmu_hash(set, set_size);

    snprintf(guid, sizeof guid, "{%08llx-%04llx-%04llx-%04llx-%012llx}", table >> 32, table >> 16 & 0xffffu,
             table & 0xffffu, parameters >> 48, parameters & 0xffffffffffffu);
    return guid;
}

static fmi2Component instantiate(const struct fmi2_api *m, const char *resources)
{
    forget_log();
    return m->Instantiate("a", fmi2CoSimulation, guid_of_set(m), resources, &CALLBACKS, fmi2False, fmi2False);
}

static void uses_the_set(const struct fmi2_api *m, const char *resources)
{
    fmi2Component c = instantiate(m, resources);

    if (!CHECK(c != NULL)) {
        fprintf(stderr, "  from '%s': %s\n", resources, logged.text);
        return;
    }
    CHECK(m->EnterInitializationMode(c) == fmi2OK);
    CHECK(get_real(m, c, "sampleTime") == 2.5e-4 && get_real(m, c, "voltageMin") == -10.5);
    CHECK(get_integer(m, c, "ruleCount") == 1 && get_real(m, c, "rule[1].q2") == 1e-8);
    CHECK(get_real(m, c, "rule[2].q1") == 0.0);
    CHECK(m->ExitInitializationMode(c) == fmi2OK);
    m->FreeInstance(c);
}

static void locations(const struct fmi2_api *m)
{
    static const char *const forms[] = { "%s/" DIRECTORY,      "%s/" DIRECTORY "/",
                                         "file://%s/" ENCODED, "file://%s/" ENCODED "/",
                                         "file:%s/" ENCODED,   "file://localhost%s/" ENCODED };
    char here[1024], location[2048];

    make_set();
    write_set();
    uses_the_set(m, DIRECTORY);
    CHECK(current_directory(here, sizeof here) != NULL);
    if (here[0] != '/') /* a drive letter: other forms */
        return;
    for (size_t i = 0; i < sizeof forms / sizeof forms[0]; i++) {
        const char *place = strstr(forms[i], "%s");
        snprintf(location, sizeof location, "%.*s%s%s", (int)(place - forms[i]), forms[i], here, place + 2);
        uses_the_set(m, location);
    }
}

static void refused(const struct fmi2_api *m, const char *resources, const char *reason)
{
    fmi2Component c = instantiate(m, resources);

    CHECK(c == NULL && logged.status == fmi2Error && log_says(reason));
    m->FreeInstance(c);
}

/* Found by fuzz_parameters: numbers that are none, or that no int can hold. */
static void numbers_out_of_range(const struct fmi2_api *m)
{
    static const char *const counts[] = { "1e300", "-1e300", "nan", "17", "0" };

    make_set();
    add("rule[2].q1", "Real", "nan");
    write_set();
    refused(m, DIRECTORY, "rule[2].q1");
    make_set();
    add("sampleTime", "Real", "1e999");
    write_set();
    refused(m, DIRECTORY, "sampleTime");
    for (size_t i = 0; i < sizeof counts / sizeof counts[0]; i++) {
        make_set();
        add("ruleCount", "Integer", counts[i]);
        write_set();
        refused(m, DIRECTORY, "ruleCount");
    }
}

static void missing_edited_damaged(const struct fmi2_api *m)
{
    static char longest[4000];

    make_set();
    write_set();
    memset(longest, 'x', sizeof longest - 1);
    refused(m, "no/such/place", "cannot be read");
    refused(m, NULL, "cannot be read");
    refused(m, "", "cannot be read");
    refused(m, "http://example.org/%s%n", "cannot be read");
    refused(m, longest, "cannot be read");
    set[set_size - 30]++; /* the GUID is of this text now, the file is as before */
    refused(m, DIRECTORY, "package the FMU anew");
    make_set();
    add("rule[99].q1", "Real", "1.0");
    write_set();
    refused(m, DIRECTORY, "rule[99].q1");
    make_set();
    add("rule[2].q1", "Real", "one");
    write_set();
    refused(m, DIRECTORY, "rule[2].q1");
    make_set();
    add("rule[2].q1", "Real", "");
    write_set();
    refused(m, DIRECTORY, "rule[2].q1");
    numbers_out_of_range(m);
}

int main(void)
{
    make_directory(DIRECTORY);
    locations(&PLANT);
    locations(&INVERSE);
    missing_edited_damaged(&PLANT);
    return check_report("fmi2 parameters");
}
