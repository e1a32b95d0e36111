/* Where the FMU's resources are: at the URI that the host gives, or beside this very binary, which
 * lies in binaries/<platform>/ of the unpacked FMU. Hosts differ in the URI: with and without a
 * trailing slash, file:/ or file:///, percent-encoded or not, a plain path, or none at all. */
#if !defined _WIN32 && !defined _GNU_SOURCE
#define _GNU_SOURCE /* dladdr */
#endif
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#if defined _WIN32
#include <windows.h>
#else
#include <dlfcn.h>
#endif

#include "fmu.h"

static const char ANCHOR = 0; /* an address within this binary */

static int hex_digit(char c)
{
    if (c >= '0' && c <= '9')
        return c - '0';
    if (c >= 'a' && c <= 'f')
        return c - 'a' + 10;
    return c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
}

static void decode_percent(char *text)
{
    char *out = text;

    for (; *text; text++, out++) {
        if (*text == '%' && hex_digit(text[1]) >= 0 && hex_digit(text[2]) >= 0) {
            *out = (char)(16 * hex_digit(text[1]) + hex_digit(text[2]));
            text += 2;
        } else
            *out = *text;
    }
    *out = '\0';
}

/* Path of a file: URI; a text that is no URI is taken as a path. */
static bool uri_to_path(const char *uri, char *path, size_t size)
{
    const bool is_uri = strncmp(uri, "file:", 5) == 0;
    const char *rest = is_uri ? uri + 5 : uri;

    if (is_uri && strncmp(rest, "//", 2) == 0) {
        rest += 2; /* an authority may follow: nothing or localhost */
        if (strncmp(rest, "localhost/", 10) == 0)
            rest += 9;
    }
#if defined _WIN32
    if (is_uri && rest[0] == '/' && rest[1] && rest[2] == ':')
        rest++; /* /C:/... */
#endif
    if (strlen(rest) >= size)
        return false;
    strcpy(path, rest);
    if (is_uri)
        decode_percent(path);
    return true;
}

static bool append(char *path, size_t size, const char *text)
{
    if (strlen(path) + strlen(text) >= size)
        return false;
    strcat(path, text);
    return true;
}

#if defined _WIN32
static FILE *open_utf8(const char *path)
{
    WCHAR wide[2048];

    return MultiByteToWideChar(CP_UTF8, 0, path, -1, wide, 2048) ? _wfopen(wide, L"rb") : NULL;
}

static bool own_path(char *path, size_t size)
{
    WCHAR wide[2048];
    HMODULE module;
    const DWORD flags = GET_MODULE_HANDLE_EX_FLAG_FROM_ADDRESS | GET_MODULE_HANDLE_EX_FLAG_UNCHANGED_REFCOUNT;

    if (!GetModuleHandleExW(flags, (LPCWSTR)(const void *)&ANCHOR, &module))
        return false;
    const DWORD length = GetModuleFileNameW(module, wide, 2048);
    return length > 0 && length < 2048 &&
           WideCharToMultiByte(CP_UTF8, 0, wide, -1, path, (int)size, NULL, NULL) > 0;
}
#else
static FILE *open_utf8(const char *path)
{
    return fopen(path, "rb");
}

static bool own_path(char *path, size_t size)
{
    Dl_info info;

    if (!dladdr(&ANCHOR, &info) || !info.dli_fname || strlen(info.dli_fname) >= size)
        return false;
    strcpy(path, info.dli_fname);
    return true;
}
#endif

/* <fmu>/binaries/<platform>/<binary> -> <fmu>/resources */
static bool own_resources(char *path, size_t size)
{
    if (!own_path(path, size))
        return false;
    for (int level = 0; level < 3; level++) {
        char *slash = strrchr(path, '/');
        char *backslash = strrchr(path, '\\');
        char *last = backslash > slash ? backslash : slash;
        if (!last)
            return false;
        *last = '\0';
    }
    return append(path, size, "/resources");
}

void *fmu_open_resource(const char *uri, const char *file, char *path, size_t size)
{
    FILE *opened = NULL;

    if (uri && *uri && uri_to_path(uri, path, size) && append(path, size, "/") && append(path, size, file))
        opened = open_utf8(path);
    if (!opened && own_resources(path, size) && append(path, size, "/") && append(path, size, file))
        opened = open_utf8(path);
    return opened;
}
