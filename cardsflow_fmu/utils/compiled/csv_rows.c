#include "csv_rows.h"

#include <math.h>
#include <string.h>

enum { FRACTION = 52, BIAS = 1075, EXPONENTS = 0x7ff };

struct decimal {
    uint64_t digits; /* value = digits * 10^power */
    int32_t power;
};

__extension__ typedef unsigned __int128 wide;

/* Return the floor of x / 2^n, also for negative x. */
static int32_t floor_shift(int32_t x, int n)
{
    return x >= 0 ? x >> n : -((-x + (1 << n) - 1) >> n);
}

/* Return the upper 64 bits of the product, rounded to odd. */
static uint64_t round_to_odd(const struct csv_power *g, uint64_t factor)
{
    const uint64_t carry = (uint64_t)(((wide)g->low * factor) >> 64);
    const wide product = (wide)g->high * factor + carry;
    return (uint64_t)(product >> 64) | ((uint64_t)product > 1);
}

/* Return the shortest decimal that rounds to a positive, finite double; of several, the closest one. */
static struct decimal shortest(const struct csv_power *powers, uint64_t fraction, int32_t exponent)
{
    const uint64_t c = exponent ? fraction | (uint64_t)1 << FRACTION : fraction;
    const int32_t q = (exponent ? exponent : 1) - BIAS;
    if (exponent && q <= 0 && q >= -FRACTION && !(c & (((uint64_t)1 << -q) - 1))) {
        const struct decimal integer = {c >> -q, 0};
        return integer;
    }
    const int is_even = !(c & 1), is_lower_closer = fraction == 0 && exponent > 1;
    const int32_t k = floor_shift(q * 1262611 - (is_lower_closer ? 524031 : 0), 22);
    const int32_t h = q + floor_shift(-k * 1741647, 19) + 1;
    const struct csv_power *g = &powers[-k - CSV_MIN_POWER];
    const uint64_t lower = round_to_odd(g, (4 * c - 2 + (uint64_t)is_lower_closer) << h) + !is_even;
    const uint64_t middle = round_to_odd(g, 4 * c << h);
    const uint64_t upper = round_to_odd(g, (4 * c + 2) << h) - !is_even;
    const uint64_t s = middle / 4;
    struct decimal found = {s, k};
    if (s >= 10) {
        const uint64_t tenth = s / 10;
        const int is_below = lower <= 40 * tenth, is_above = 40 * tenth + 40 <= upper;
        if (is_below != is_above) {
            found.digits = tenth + (uint64_t)is_above;
            found.power++;
            return found;
        }
    }
    const int is_below = lower <= 4 * s, is_above = 4 * s + 4 <= upper;
    const int is_up = middle > 4 * s + 2 || (middle == 4 * s + 2 && (s & 1));
    found.digits += (uint64_t)(is_below != is_above ? is_above : is_up);
    return found;
}

/* Copies have a fixed length, which is faster; CSV_ROOM bytes after the text may be overwritten. */
static char *put(char *text, const char *from, int32_t count)
{
    memcpy(text, from, CSV_ROOM);
    return text + count;
}

static const char ZEROS[CSV_ROOM + 1] = "0.000000000000000000";

static char *put_zeros(char *text, int32_t count)
{
    memset(text, '0', CSV_ROOM);
    return text + count;
}

static char *put_exponent(char *text, int32_t exponent)
{
    *text++ = 'e';
    *text++ = exponent < 0 ? '-' : '+';
    exponent = exponent < 0 ? -exponent : exponent;
    if (exponent >= 100)
        *text++ = (char)('0' + exponent / 100);
    if (exponent >= 10)
        *text++ = (char)('0' + exponent / 10 % 10);
    *text++ = (char)('0' + exponent % 10);
    return text;
}

static const char PAIRS[] = "00010203040506070809101112131415161718192021222324252627282930313233343536373839"
                            "40414243444546474849505152535455565758596061626364656667686970717273747576777879"
                            "8081828384858687888990919293949596979899";

static char *put_pair(char *end, uint32_t pair)
{
    return memcpy(end - 2, PAIRS + 2 * pair, 2);
}

/* Write the digits before `end`; return the first one. */
static char *put_digits(char *end, uint64_t digits)
{
    while (digits >= 100000000) {
        uint32_t low = (uint32_t)(digits % 100000000);
        digits /= 100000000;
        for (int i = 0; i < 4; i++, low /= 100)
            end = put_pair(end, low % 100);
    }
    uint32_t rest = (uint32_t)digits;
    for (; rest >= 100; rest /= 100)
        end = put_pair(end, rest % 100);
    if (rest >= 10)
        return put_pair(end, rest);
    *--end = (char)('0' + rest);
    return end;
}

static char *put_point(char *text, char digit)
{
    text[0] = '.';
    text[1] = digit;
    return text + 2;
}

/* Write digits * 10^power. With `point` digits before the decimal point, 10^(point - 1) <= value < 10^point. */
static char *put_decimal(char *text, struct decimal value)
{
    char room[2 * CSV_ROOM];
    char *const end = room + CSV_ROOM;
    while (value.digits % 10 == 0) {
        value.digits /= 10;
        value.power++;
    }
    const char *digits = put_digits(end, value.digits);
    const int32_t count = (int32_t)(end - digits);
    const int32_t point = count + value.power;
    if (value.power >= 0 && point <= 16)
        return put_point(put_zeros(put(text, digits, count), value.power), '0');
    if (point > 0 && point <= 16) {
        text = put(text, digits, point);
        *text = '.';
        return put(text + 1, digits + point, count - point);
    }
    if (point > -5 && point <= 0)
        return put(put(text, ZEROS, 2 - point), digits, count);
    text = put(text, digits, 1);
    if (count > 1) {
        *text = '.';
        text = put(text + 1, digits + 1, count - 1);
    }
    return put_exponent(text, point - 1);
}

static char *put_number(const struct csv_power *powers, double value, char *text)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    const uint64_t fraction = bits & (((uint64_t)1 << FRACTION) - 1);
    const int32_t exponent = (int32_t)(bits >> FRACTION) & EXPONENTS;
    if (exponent == EXPONENTS && fraction)
        return memcpy(text, "NaN", 3), text + 3;
    if (bits >> 63)
        *text++ = '-';
    if (exponent == EXPONENTS)
        return memcpy(text, "Infinity", 8), text + 8;
    if (!exponent && !fraction)
        return memcpy(text, "0.0", 3), text + 3;
    return put_decimal(text, shortest(powers, fraction, exponent));
}

/* Copy a text of at most CSV_NUMBER bytes; more bytes are copied, in whole registers. The texts may overlap. */
static char *put_again(char *text, const char *from, size_t length)
{
    char room[32];
    memcpy(room, from, sizeof room);
    memcpy(text, room, sizeof room);
    return text + length;
}

/* Controllers hold their outputs: a value that equals that of the row before has the same text, with its
 * separator. places[j] is the position of the last text of column j. */
size_t csv_rows(const struct csv_power *powers, const double *values, size_t rows, size_t columns, size_t *places,
                char *text)
{
    const char *begin = text;
    for (size_t i = 0; i < rows; i++) {
        const double *row = values + i * columns;
        places[columns] = (size_t)(text - begin); /* the end of the row before */
        for (size_t j = 0; j < columns; j++) {
            const size_t last = i ? places[j] : 0, length = i ? places[j + 1] - last : 0;
            places[j] = (size_t)(text - begin);
            if (i && !memcmp(row + j, row + j - columns, sizeof *row)) {
                text = put_again(text, begin + last, length);
                continue;
            }
            text = put_number(powers, row[j], text);
            *text++ = j + 1 < columns ? ',' : '\n';
        }
    }
    return (size_t)(text - begin) - (rows && columns); /* without the last newline */
}
