/* A Modelica tool as the glue sees it, driven by lines on stdin. external.h is generated from the
 * library's external clauses: a function for each, with the arguments of the Modelica function.
 *
 *     new ID plant|inverse COUNT then as many numbers
 *     tick ID TIME INPUT FORCE TEMPERATURE
 *     free ID
 *
 * Answers, one a line: `ok`, the outputs (three: of the inverse with a 0 before the flag), or `error: ...`;
 * `warning: ...` lines come before. */
#include <setjmp.h>
#include <stdarg.h>

#include "IT2Hysteresis.h"
#include "external.h"

enum { OBJECTS = 8 };

static jmp_buf on_error;
static struct {
    void *instance;
    int inverse;
} object[OBJECTS];

void ModelicaFormatError(const char *format, ...)
{
    va_list arguments;

    va_start(arguments, format);
    fputs("error: ", stdout);
    vprintf(format, arguments);
    va_end(arguments);
    longjmp(on_error, 1);
}

void ModelicaFormatWarning(const char *format, ...)
{
    va_list arguments;

    va_start(arguments, format);
    fputs("warning: ", stdout);
    vprintf(format, arguments);
    va_end(arguments);
}

/* Exactly as many numbers as the glue is told of: reading beyond them is an error that is found. */
static double *read_numbers(size_t count)
{
    double *numbers = malloc(count * sizeof *numbers + (count == 0));

    for (size_t i = 0; i < count; i++)
        if (scanf("%lf", &numbers[i]) != 1)
            exit(2);
    return numbers;
}

static void construct(int id, int inverse)
{
    static double *values; /* static: it outlives a longjmp */
    size_t count;

    if (scanf("%zu", &count) != 1)
        exit(2);
    values = read_numbers(count);
    object[id].inverse = inverse;
    object[id].instance = NULL;
    if (setjmp(on_error) == 0) {
        object[id].instance =
            (inverse ? InverseObject_constructor : PlantObject_constructor)(values, count, "M.stage");
        puts("ok");
    }
    free(values);
}

static void tick(int id)
{
    double number[4], first, second = 0.0;
    int flag;

    for (int i = 0; i < 4; i++)
        if (scanf("%lf", &number[i]) != 1)
            exit(2);
    if (setjmp(on_error) != 0)
        return;
    if (object[id].inverse)
        inverseTick(object[id].instance, number[0], number[1], number[2], number[3], &first, &flag);
    else
        plantTick(object[id].instance, number[0], number[1], number[2], number[3], &first, &second, &flag);
    printf("%.17g %.17g %d\n", first, second, flag);
}

int main(void)
{
    char command[16], kind[16];
    int id;

    while (scanf("%15s %d", command, &id) == 2 && id >= 0 && id < OBJECTS) {
        if (strcmp(command, "new") == 0 && scanf("%15s", kind) == 1)
            construct(id, strcmp(kind, "inverse") == 0);
        else if (strcmp(command, "tick") == 0)
            tick(id);
        else {
            (object[id].inverse ? InverseObject_destructor
                                : PlantObject_destructor)(object[id].instance);
            puts("ok");
        }
    }
    return 0;
}
