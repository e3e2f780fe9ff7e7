/* Numbers as text that reads back exactly, with as few digits as possible; csv_table.py uses it.
 *
 * The digits are computed with the method Schubfach of R. Giulietti ("The Schubfach way to render doubles"). */
#ifndef CSV_ROWS_H
#define CSV_ROWS_H

#include "export.h"

#include <stddef.h>
#include <stdint.h>

enum {
    CSV_MIN_POWER = -292,
    CSV_MAX_POWER = 324,
    CSV_NUMBER = 26, /* maximum bytes of a number with its separator */
    CSV_ROOM = 20    /* additional bytes behind the text */
};

/* The upper and the lower half of 10^k, scaled to 128 significant bits and rounded up. */
struct csv_power {
    uint64_t high, low;
};

/* Write rows as lines: numbers with commas between them, lines with newlines between them. Return the number of
 * bytes, at most CSV_NUMBER for each number; `text` must have CSV_ROOM bytes more. `powers` contains 10^CSV_MIN_POWER
 * to 10^CSV_MAX_POWER; `places` is memory for columns + 1 numbers. */
RUN_API size_t csv_rows(const struct csv_power *powers, const double *values, size_t rows, size_t columns,
                        size_t *places, char *text);

#endif
