/* Formatting of messages without printf, which does not exist on a bare machine. */
#ifndef CARDSFLOW_MESSAGE_H
#define CARDSFLOW_MESSAGE_H

#include <stdarg.h>
#include <stddef.h>

/* Write a text into `message`, cut at its capacity. Conversions: %s, %d, %u and %zu, as in printf. */
void message_write(char *message, size_t capacity, const char *format, va_list arguments);

/* Write an error message; return 1. */
#if defined(__GNUC__)
__attribute__((format(printf, 3, 4)))
#endif
int reject(char *message, size_t capacity, const char *format, ...);

#endif
