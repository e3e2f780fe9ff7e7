/* A text of variable length, for messages. */
#ifndef TEXT_H
#define TEXT_H

#include <stdarg.h>

#if defined(__GNUC__)
#define TEXT_FORMAT(index, first) __attribute__((format(printf, index, first)))
#else
#define TEXT_FORMAT(index, first)
#endif

struct text {
    char *chars; /* NULL if the text is not set */
};

/* Replace the text; an argument may be a part of the old text. */
void text_set(struct text *text, const char *format, ...) TEXT_FORMAT(2, 3);

void text_set_list(struct text *text, const char *format, va_list arguments);

/* Return the text, never NULL. */
const char *text_get(const struct text *text);

void text_free(struct text *text);

/* Return a copy on the heap; NULL if memory is insufficient. */
char *text_copy(const char *chars);

#endif
