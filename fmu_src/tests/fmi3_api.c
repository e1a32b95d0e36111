/* Compiled once per model: FMI3_FUNCTION_PREFIX, API, API_KIND, API_HASH say which. */
#include "fmi3_api.h"

#include "fmi3Functions.h"
#include "fmu_table_hash.h"

const struct fmi3_api API = { .kind = API_KIND,
                              .table_hash = API_HASH,
#define FMI3_MEMBER(name) .name = fmi3##name,
                              FMI3_API(FMI3_MEMBER) };
