#include "message.h"

typedef struct {
    char *at;
    size_t left; /* capacity without the terminating zero */
} text;

static void put(text *out, char letter)
{
    if (!out->left) return;
    *out->at++ = letter;
    out->left--;
}

static void put_text(text *out, const char *from)
{
    while (*from) put(out, *from++);
}

static void put_number(text *out, size_t number)
{
    char digits[24];
    size_t count = 0;
    do digits[count++] = (char)('0' + number % 10);
    while (number /= 10);
    while (count) put(out, digits[--count]);
}

static void put_signed(text *out, int number)
{
    if (number < 0) put(out, '-');
    put_number(out, number < 0 ? 0u - (unsigned)number : (unsigned)number);
}

void message_write(char *message, size_t capacity, const char *format, va_list arguments)
{
    text out = {message, capacity - 1};
    if (!capacity) return;
    for (; *format; format++) {
        if (*format != '%') {
            put(&out, *format);
            continue;
        }
        switch (*++format) {
        case 's': put_text(&out, va_arg(arguments, const char *)); break;
        case 'd': put_signed(&out, va_arg(arguments, int)); break;
        case 'u': put_number(&out, va_arg(arguments, unsigned)); break;
        case 'z': put_number(&out, va_arg(arguments, size_t)), format++; break;
        default: put(&out, '%'), format--; /* other conversions are not supported */
        }
    }
    *out.at = 0;
}

int reject(char *message, size_t capacity, const char *format, ...)
{
    if (message && capacity) {
        va_list arguments;
        va_start(arguments, format);
        message_write(message, capacity, format, arguments);
        va_end(arguments);
    }
    return 1;
}
