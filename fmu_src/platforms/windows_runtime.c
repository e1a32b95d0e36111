/* What MinGW's runtime would add to an FMU's DLL: the entry point, and the C functions that Windows' own
 * C library has under other names. Only for the cross-compiled binaries, not among an FMU's sources. */
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <windows.h>

/* There is nothing to set up: no constructors, no data of threads. */
BOOL WINAPI DllMainCRTStartup(HINSTANCE module, DWORD reason, LPVOID reserved);
BOOL WINAPI DllMainCRTStartup(HINSTANCE module, DWORD reason, LPVOID reserved)
{
    (void)module, (void)reason, (void)reserved;
    return TRUE;
}

int vsnprintf(char *text, size_t size, const char *format, va_list arguments)
{
    return __stdio_common_vsprintf(_CRT_INTERNAL_PRINTF_STANDARD_SNPRINTF_BEHAVIOR, text, size, format, NULL,
                                   arguments);
}

int snprintf(char *text, size_t size, const char *format, ...)
{
    va_list arguments;

    va_start(arguments, format);
    const int length = vsnprintf(text, size, format, arguments);
    va_end(arguments);
    return length;
}

/* behind isfinite and isnan */
int __fpclassify(double x)
{
    return __builtin_fpclassify(FP_NAN, FP_INFINITE, FP_NORMAL, FP_SUBNORMAL, FP_ZERO, x);
}
