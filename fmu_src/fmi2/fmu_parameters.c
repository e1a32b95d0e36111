/* The parameter set of a packaged FMU.
 *
 * A GUID is {table hash, parameter hash}, 64 bits each: it says which variables the XML lists and
 * which parameter set its start values are. One binary serves every packaged FMU: where the set
 * compiled in (fmu_start.h) is not the one meant, it is read from resources/parameters.ssv. XML,
 * resources and binary therefore agree, or there is no instance. */
#include <ctype.h>
#include <locale.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmu.h"
#include "fmu_start.h"

enum { LARGEST_FILE = 1 << 20, LARGEST_NUMBER = 64 };

static const char ENTRY[] = "<ssv:Parameter name=\"";
static const char ENTRY_END[] = "</ssv:Parameter>";
static const char VALUE[] = " value=\"";

/* strtod reads the decimal point of the host's locale, the file has a point. */
static bool read_number(const char *text, size_t length, double *value)
{
    const char *point = localeconv()->decimal_point;
    char buffer[LARGEST_NUMBER];
    size_t n = 0;
    char *end;

    for (size_t i = 0; i < length; i++) {
        const char *piece = text[i] == '.' ? point : text + i;
        const size_t size = text[i] == '.' ? strlen(point) : 1;
        if (n + size >= sizeof buffer)
            return false;
        memcpy(buffer + n, piece, size);
        n += size;
    }
    buffer[n] = '\0';
    *value = strtod(buffer, &end);
    return n > 0 && end == buffer + n && isfinite(*value);
}

static bool set_parameter(struct chain_parameters *parameters, const char *name, size_t name_length,
                          const char *text, size_t length)
{
    const struct fmu_variable *variable = fmu_find_parameter(name, name_length);
    double value;

    if (!variable)
        return false;
    if (variable->base == FMU_BOOLEAN && length >= 4)
        value = strncmp(text, "true", 4) == 0;
    else if (!read_number(text, length, &value))
        return false;
    /* beyond its bounds, a number may have no int to be converted to */
    if (variable->base == FMU_INTEGER && !(value >= variable->minimum && value <= variable->maximum))
        return false;
    char *target = (char *)parameters + variable->offset - offsetof(struct fmu_values, parameter);
    if (variable->base == FMU_REAL)
        *(double *)target = value;
    else
        *(int *)target = (int)value;
    return true;
}

/* Reads the SSV text that the packager writes; the hash has shown that it is that text. */
static bool parse(const char *text, struct chain_parameters *parameters, char *message, size_t size)
{
    memset(parameters, 0, sizeof *parameters);
    for (const char *entry = strstr(text, ENTRY); entry; entry = strstr(entry, ENTRY)) {
        const char *name = entry + sizeof ENTRY - 1;
        const size_t name_length = strcspn(name, "\"");
        const char *end = strstr(name, ENTRY_END);
        const char *value = strstr(name, VALUE);
        if (end && value && value < end) {
            value += sizeof VALUE - 1;
            if (!set_parameter(parameters, name, name_length, value, strcspn(value, "\""))) {
                snprintf(message, size, "parameters.ssv: parameter '%.*s' is unknown or its value is "
                         "not usable",
                         (int)(name_length < 80 ? name_length : 80), name);
                return false;
            }
        }
        entry = name;
    }
    return true;
}

/* {01234567-89ab-cdef-0123-456789abcdef} as two numbers. */
static bool read_guid(const char *guid, uint64_t half[2])
{
    int digits = 0;

    half[0] = half[1] = 0;
    for (; *guid; guid++) {
        if (isxdigit((unsigned char)*guid) && digits < 32) {
            const int c = tolower((unsigned char)*guid);
            half[digits / 16] = half[digits / 16] << 4 | (uint64_t)(c <= '9' ? c - '0' : c - 'a' + 10);
            digits++;
        } else if (*guid != '{' && *guid != '}' && *guid != '-')
            return false;
    }
    return digits == 32;
}

static char *read_all(FILE *file)
{
    char *text = malloc(LARGEST_FILE + 1);
    const size_t size = text ? fread(text, 1, LARGEST_FILE, file) : 0;

    if (text)
        text[size] = '\0';
    return text;
}

bool fmu_load_parameters(const struct fmu_model *model, const char *guid, const char *resources,
                         struct chain_parameters *parameters, char *message, size_t size)
{
    uint64_t half[2];
    char path[2048] = "";

    if (!read_guid(guid, half) || half[0] != model->table_hash) {
        snprintf(message, size, "the GUID '%.64s' is not that of a modelDescription.xml for this binary "
                 "of %s.", guid, model->identifier);
        return false;
    }
    if (half[1] == FMU_START_HASH) {
        *parameters = FMU_START;
        return true;
    }
    FILE *file = fmu_open_resource(resources, "parameters.ssv", path, sizeof path);
    char *text = file ? read_all(file) : NULL;
    if (file)
        fclose(file);
    bool ok = false;
    if (!text)
        snprintf(message, size, "the parameter set cannot be read from '%s' (resource location '%s').",
                 path, resources ? resources : "(null)");
    else if (fmu_hash(text, strlen(text)) != half[1])
        snprintf(message, size, "'%s' is not the parameter set that modelDescription.xml was made for; "
                 "package the FMU anew instead of editing it.", path);
    else
        ok = parse(text, parameters, message, size);
    free(text);
    return ok;
}
