/* Adjoint derivatives, from directional ones: of each known, the derivatives of the unknowns weighted by their
 * seeds. The models have few inputs, and a vector times a matrix costs no more than the matrix. */
#include <stdlib.h>

#include "fmu.h"

enum fmu_status fmu_adjoint_derivative(struct fmu *fmu, const char *function, const unsigned unknowns[],
                                       size_t unknown_count, const unsigned knowns[], size_t known_count,
                                       const double seeds[], double values[])
{
    static const double one = 1.0;
    enum fmu_status status = FMU_OK;

    if (known_count == 0) /* the call is checked all the same */
        return fmu_directional_derivative(fmu, function, NULL, 0, NULL, 0, NULL, NULL);
    double *column = malloc((unknown_count + known_count) * sizeof *column);
    if (!column)
        return fmu ? fmu_say(fmu, FMU_ERROR, "%s: out of memory.", function) : FMU_ERROR;
    double *found = column + unknown_count; /* nothing is handed out where the last one is refused */
    for (size_t j = 0; j < known_count && status == FMU_OK; j++) {
        status =
            fmu_directional_derivative(fmu, function, unknowns, unknown_count, knowns + j, 1, &one, column);
        found[j] = 0.0;
        for (size_t i = 0; i < unknown_count && status == FMU_OK; i++)
            found[j] += seeds[i] * column[i];
    }
    for (size_t j = 0; j < known_count && status == FMU_OK; j++)
        values[j] = found[j];
    free(column);
    return status;
}
