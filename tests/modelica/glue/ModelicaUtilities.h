/* As much of the standard's header as the library's C sources use. glue_host.c is the tool. */
#ifndef MODELICA_UTILITIES_H
#define MODELICA_UTILITIES_H

void ModelicaFormatError(const char *format, ...) __attribute__((noreturn, format(printf, 1, 2)));
void ModelicaFormatWarning(const char *format, ...) __attribute__((format(printf, 1, 2)));

#endif
