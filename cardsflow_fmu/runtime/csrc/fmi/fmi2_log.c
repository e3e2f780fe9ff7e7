#include "fmi2_log.h"

#include "../platform/utf8.h"

#include <string.h>

/* Hosts truncate messages; FMPy does so after 2047 bytes. */
enum { MAX_MESSAGE = 2000 };

/* The message is a printf format, in which "#r0#" refers to a variable. */
static int is_special(char c)
{
    return c == '%' || c == '#';
}

/* Return how many bytes to put into one message: up to the end, a line break, or the end of a character. */
static size_t piece_length(const char *text)
{
    size_t width = 0, line = 0, i = 0;
    while (text[i]) {
        size_t length = utf8_next(text + i);
        width += is_special(text[i]) ? 2 : length;
        if (width > MAX_MESSAGE)
            return line ? line : i;
        if (text[i] == '\n')
            line = i;
        i += length;
    }
    return i;
}

/* Copy the text with doubled special characters, and question marks for bytes that are not UTF-8. */
static void escape(char *out, const char *text, size_t length)
{
    for (const char *end = text + length; text < end; text += utf8_next(text)) {
        size_t size = utf8_length(text);
        if (is_special(*text))
            *out++ = *text;
        memcpy(out, size ? text : "?", utf8_next(text));
        out += utf8_next(text);
    }
    *out = '\0';
}

/* The text is the format, without arguments: a logger that is a ctypes function does not receive arguments. */
void fmi2_log_write(void *context, enum status status, const char *text)
{
    const struct fmi2_log *log = context;
    char message[MAX_MESSAGE + 1];
    if (!log->callbacks.logger)
        return;
    do {
        size_t length = piece_length(text);
        escape(message, text, length);
        log->callbacks.logger(log->callbacks.componentEnvironment, log->instance_name,
                              (fmi2Status)status, log_category(status), message);
        text += length;
        text += *text == '\n';
    } while (*text);
}
