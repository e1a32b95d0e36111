/* The parameter set of a packaged FMU.
 *
 * A GUID is {table hash, parameter hash}, 64 bits each: it says which variables the XML lists and
 * which parameter set its start values are. One binary serves every packaged FMU: where the set
 * compiled in is not the one meant, it is read from resources/parameters.ssv. XML, resources and
 * binary therefore agree, or there is no instance. */
#include <locale.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmu.h"

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

static bool set_parameter(const struct fmu_model *model, void *parameters, const char *name, size_t name_length,
                          const char *text, size_t length)
{
    const struct fmu_variable *variable = fmu_find_parameter(model, name, name_length);
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
    void *target = (char *)parameters + variable->offset;
    if (variable->base == FMU_REAL)
        *(double *)target = value;
    else
        *(int *)target = (int)value;
    return true;
}

/* Reads the SSV text that the packager writes; the hash has shown that it is that text. */
static bool parse(const struct fmu_model *model, const char *text, void *parameters, char *message, size_t size)
{
    memset(parameters, 0, model->parameters_size);
    for (const char *entry = strstr(text, ENTRY); entry; entry = strstr(entry, ENTRY)) {
        const char *name = entry + sizeof ENTRY - 1;
        const size_t name_length = strcspn(name, "\"");
        const char *end = strstr(name, ENTRY_END);
        const char *value = strstr(name, VALUE);
        if (end && value && value < end) {
            value += sizeof VALUE - 1;
            if (!set_parameter(model, parameters, name, name_length, value, strcspn(value, "\""))) {
                snprintf(message, size,
                         "parameters.ssv: parameter '%.*s' is unknown, or its value is "
                         "not valid",
                         (int)(name_length < 80 ? name_length : 80), name);
                return false;
            }
        }
        entry = name;
    }
    return true;
}

static char *read_all(FILE *file)
{
    char *text = malloc(LARGEST_FILE + 1);
    const size_t size = text ? fread(text, 1, LARGEST_FILE, file) : 0;

    if (text)
        text[size] = '\0';
    return text;
}

bool fmu_load_parameters(const struct fmu_model *model, uint64_t hash, const char *resources, void *parameters,
                         char *message, size_t size)
{
    char path[2048] = "";
    FILE *file = fmu_open_resource(resources, "parameters.ssv", path, sizeof path);
    char *text = file ? read_all(file) : NULL;
    bool ok = false;

    if (file)
        fclose(file);
    if (!text)
        snprintf(message, size, "the parameter set cannot be read from '%s' (resource location '%s').", path,
                 resources ? resources : "(null)");
    else if (fmu_hash(text, strlen(text)) != hash)
        snprintf(message, size,
                 "'%s' is not the parameter set that modelDescription.xml was made for; "
                 "package the FMU anew instead of editing it.",
                 path);
    else
        ok = parse(model, text, parameters, message, size);
    free(text);
    return ok;
}
