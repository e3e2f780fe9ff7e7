/* Messages without the C library's printf, which a bare machine lacks. */
#ifndef CARDSFLOW_MESSAGE_H
#define CARDSFLOW_MESSAGE_H

#include <stdarg.h>
#include <stddef.h>

/* Write a text into `message`, cut at its capacity, with %s, %d, %u and %zu as printf has them. */
void message_write(char *message, size_t capacity, const char *format, va_list arguments);

/* Write a message for people; always 1. */
#if defined(__GNUC__)
__attribute__((format(printf, 3, 4)))
#endif
int refuse(char *message, size_t capacity, const char *format, ...);

#endif
