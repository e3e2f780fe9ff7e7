#include "text.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void text_set_list(struct text *text, const char *format, va_list arguments)
{
    va_list again;
    va_copy(again, arguments);
    int length = vsnprintf(NULL, 0, format, arguments);
    char *chars = length < 0 ? NULL : malloc((size_t)length + 1);
    if (chars)
        vsnprintf(chars, (size_t)length + 1, format, again);
    va_end(again);
    free(text->chars);
    text->chars = chars;
}

void text_set(struct text *text, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    text_set_list(text, format, arguments);
    va_end(arguments);
}

const char *text_get(const struct text *text)
{
    return text->chars ? text->chars : "out of memory";
}

void text_free(struct text *text)
{
    free(text->chars);
    text->chars = NULL;
}

char *text_copy(const char *chars)
{
    size_t size = strlen(chars) + 1;
    char *copy = malloc(size);
    return copy ? memcpy(copy, chars, size) : NULL;
}
