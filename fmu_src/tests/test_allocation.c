/* A step allocates nothing. The linker sends the program's own calls of malloc and its kin here
 * (-Wl,--wrap); the C library's inner ones, such as a first printf, do not count. */
#include <stdlib.h>

#include "fmi2_fixture.h"

CHECK_MAIN;

static long allocations;

void *__real_malloc(size_t size);
void *__real_calloc(size_t count, size_t size);
void *__real_realloc(void *old, size_t size);
void *__wrap_malloc(size_t size);
void *__wrap_calloc(size_t count, size_t size);
void *__wrap_realloc(void *old, size_t size);

void *__wrap_malloc(size_t size)
{
    allocations++;
    return __real_malloc(size);
}

void *__wrap_calloc(size_t count, size_t size)
{
    allocations++;
    return __real_calloc(count, size);
}

void *__wrap_realloc(void *old, size_t size)
{
    allocations++;
    return __real_realloc(old, size);
}

static void of_model(const struct fmi2_api *m)
{
    allocations = 0;
    fmi2Component c = make_running(m, 0.0);
    const fmi2ValueReference input = reference_of(m, input_of(m)), output = reference_of(m, output_of(m));
    const fmi2Integer order = 1;
    const double seed = 1.0;
    fmi2FMUstate state = NULL;
    double value = 0.0;

    CHECK(allocations > 0); /* the wrapping works */
    CHECK(m->GetFMUstate(c, &state) == fmi2OK);
    allocations = 0;
    for (int k = 0; k < 1000; k++) {
        const double u = signal(m, k * TS), slope = 0.0;
        CHECK(m->SetReal(c, &input, 1, &u) == fmi2OK);
        CHECK(m->SetRealInputDerivatives(c, &input, 1, &order, &slope) == fmi2OK);
        CHECK(m->DoStep(c, k * TS, TS, fmi2True) <= fmi2Warning);
        CHECK(m->GetReal(c, &output, 1, &value) == fmi2OK);
        CHECK(m->GetDirectionalDerivative(c, &output, 1, &input, 1, &seed, &value) == fmi2OK);
        CHECK(m->GetFMUstate(c, &state) == fmi2OK); /* into the memory it has */
        CHECK(m->SetFMUstate(c, state) == fmi2OK);
    }
    CHECK(allocations == 0);
    m->FreeFMUstate(c, &state);
    m->FreeInstance(c);
}

int main(void)
{
    of_model(&PLANT);
    of_model(&INVERSE);
    return check_report("allocation");
}
