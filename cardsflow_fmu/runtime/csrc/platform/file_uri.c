#include "file_uri.h"

#include <ctype.h>
#include <stdlib.h>
#include <string.h>

static int starts_with(const char *text, const char *start)
{
    for (; *start; text++, start++)
        if (tolower((unsigned char)*text) != *start)
            return 0;
    return 1;
}

static int hex_digit(char c)
{
    if (c >= '0' && c <= '9')
        return c - '0';
    c = (char)tolower((unsigned char)c);
    return c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1;
}

/* Decode in place; return 0 unless each '%' is followed by two hexadecimal digits other than 00. */
static int decode_percent(char *text)
{
    char *out = text;
    for (const char *in = text; *in; out++) {
        if (*in != '%') {
            *out = *in++;
            continue;
        }
        int high = hex_digit(in[1]);
        int low = high < 0 ? -1 : hex_digit(in[2]);
        if (low < 0 || high + low == 0)
            return 0;
        *out = (char)(high * 16 + low);
        in += 3;
    }
    *out = '\0';
    return 1;
}

#ifdef _WIN32
/* Return the path: file://server/share is the path //server/share. */
static const char *path_on_host(const char *uri)
{
    return uri;
}

/* Remove the first slash: /C:/folder is the path C:/folder. */
static void drop_slash_before_drive(char *path)
{
    if (path[0] == '/' && isalpha((unsigned char)path[1]) && path[2] == ':')
        memmove(path, path + 1, strlen(path));
}
#else
static const char *path_on_host(const char *uri)
{
    (void)uri;
    return NULL;
}

static void drop_slash_before_drive(char *path)
{
    (void)path;
}
#endif

/* Return the part after the scheme and the local host; NULL if the URI is not a file of this machine. */
static const char *path_part(const char *uri)
{
    if (!starts_with(uri, "file:/"))
        return NULL;
    uri += strlen("file:");
    if (starts_with(uri, "//localhost/"))
        return uri + strlen("//localhost");
    if (starts_with(uri, "///"))
        return uri + strlen("//");
    return starts_with(uri, "//") ? path_on_host(uri) : uri;
}

char *path_from_file_uri(const char *uri)
{
    const char *part = path_part(uri);
    char *path = part ? malloc(strlen(part) + 1) : NULL;
    if (!path)
        return NULL;
    strcpy(path, part);
    if (!decode_percent(path)) {
        free(path);
        return NULL;
    }
    drop_slash_before_drive(path);
    for (size_t n = strlen(path); n > 1 && path[n - 1] == '/'; n--)
        path[n - 1] = '\0';
    return path;
}
