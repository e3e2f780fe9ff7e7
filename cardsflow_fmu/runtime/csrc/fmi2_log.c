#include "fmi2_log.h"

#include <string.h>

/* By status. */
static const char *const CATEGORIES[] = {"logEvents", "logStatusWarning", "logStatusDiscard",
                                         "logStatusError"};

/* Hosts cut messages off; FMPy does so behind 2047 bytes. */
enum { LONGEST_MESSAGE = 2000 };

/* The message is a printf format, in which "#r0#" stands for a variable. */
static int is_special(char c)
{
    return c == '%' || c == '#';
}

static int is_continuation(unsigned char byte)
{
    return (byte & 0xc0) == 0x80;
}

/* Whether the second byte is within the range that the first one leaves it. */
static int is_second(unsigned char first, unsigned char second)
{
    unsigned char low = first == 0xe0 ? 0xa0 : first == 0xf0 ? 0x90 : 0x80;
    unsigned char high = first == 0xed ? 0x9f : first == 0xf4 ? 0x8f : 0xbf;
    return second >= low && second <= high;
}

/* Length of the UTF-8 character that the text begins with; 0 when there is none. */
static size_t character_length(const char *text)
{
    const unsigned char *bytes = (const unsigned char *)text;
    if (bytes[0] < 0x80)
        return 1;
    size_t length = bytes[0] < 0xe0 ? 2 : bytes[0] < 0xf0 ? 3 : 4;
    if (bytes[0] < 0xc2 || bytes[0] > 0xf4 || !is_second(bytes[0], bytes[1]))
        return 0;
    for (size_t i = 2; i < length; i++)
        if (!is_continuation(bytes[i]))
            return 0;
    return length;
}

/* Length of the next character or stray byte. */
static size_t next_length(const char *text)
{
    size_t length = character_length(text);
    return length ? length : 1;
}

/* How many bytes fit into one message: up to the end, a line break, or the end of a character. */
static size_t piece_length(const char *text)
{
    size_t width = 0, line = 0, i = 0;
    while (text[i]) {
        size_t length = next_length(text + i);
        width += is_special(text[i]) ? 2 : length;
        if (width > LONGEST_MESSAGE)
            return line ? line : i;
        if (text[i] == '\n')
            line = i;
        i += length;
    }
    return i;
}

/* Copies with doubled special characters, and a question mark for what is not UTF-8. */
static void escape(char *out, const char *text, size_t length)
{
    for (const char *end = text + length; text < end; text += next_length(text)) {
        size_t size = character_length(text);
        if (is_special(*text))
            *out++ = *text;
        memcpy(out, size ? text : "?", next_length(text));
        out += next_length(text);
    }
    *out = '\0';
}

/* The text is the format itself, without arguments: hosts whose logger is a ctypes function do not
 * see arguments. */
void fmi2_log_write(void *context, enum status status, const char *text)
{
    const struct fmi2_log *log = context;
    char message[LONGEST_MESSAGE + 1];
    if (!log->callbacks.logger)
        return;
    do {
        size_t length = piece_length(text);
        escape(message, text, length);
        log->callbacks.logger(log->callbacks.componentEnvironment, log->instance_name,
                              (fmi2Status)status, CATEGORIES[status], message);
        text += length;
        text += *text == '\n';
    } while (*text);
}

static int is_known(const char *category)
{
    for (size_t i = 0; i < sizeof CATEGORIES / sizeof *CATEGORIES; i++)
        if (strcmp(category, CATEGORIES[i]) == 0)
            return 1;
    return strcmp(category, "logAll") == 0;
}

int fmi2_log_asks_for_events(size_t count, const fmi2String categories[])
{
    int asked = count == 0;
    for (size_t i = 0; i < count; i++) {
        if (!categories[i] || !is_known(categories[i]))
            return -1;
        if (strcmp(categories[i], "logAll") == 0 || strcmp(categories[i], "logEvents") == 0)
            asked = 1;
    }
    return asked;
}
