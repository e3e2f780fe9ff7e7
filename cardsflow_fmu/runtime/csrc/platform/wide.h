/* Wide strings for Windows functions. */
#ifndef WIDE_H
#define WIDE_H

#ifdef _WIN32
#include <wchar.h>

/* Return a copy on the heap; NULL if memory is insufficient. */
wchar_t *wide_from_utf8(const char *text);
char *utf8_from_wide(const wchar_t *text);
#endif

#endif
