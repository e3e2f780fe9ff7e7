#include "check_variables.h"

#include "check_points.h"
#include "../message.h"

/* Check function `t` of the sum for variable `variable`. Return its number of coefficients, or -1. */
static int32_t term_numbers(const blob_view *b, int32_t t, int32_t variable, int32_t left, char *message,
                            size_t capacity)
{
    const int32_t size = b->term_size[t], each = b->term_kind[t] == TERM_PIECES ? PIECE_NUMBERS : 1;
    if (b->term_source[t] < 0 || b->term_source[t] >= variable)
        return reject(message, capacity, "function %d: its variable %d does not come before it", (int)t,
                      (int)b->term_source[t]), -1;
    if (b->term_kind[t] < 0 || b->term_kind[t] >= TERMS || size < 1 || size > left / each)
        return reject(message, capacity, "function %d: unknown kind %d, or it has %d numbers", (int)t,
                      (int)b->term_kind[t], (int)size), -1;
    const real *numbers = b->term_number + (b->counts.term_numbers - left);
    for (int32_t k = 2; k < size && each > 1; k++)
        if (!(numbers[PIECE_NUMBERS * (k - 1)] <= numbers[PIECE_NUMBERS * k]))
            return reject(message, capacity, "function %d: its pieces are out of order", (int)t), -1;
    return size * each;
}

static int check_limit_forces(const blob_view *b, char *message, size_t capacity)
{
    for (int32_t l = 0; l < b->counts.limit_forces; l++) {
        const real *n = b->limit_numbers + LIMIT_NUMBERS * l;
        if (b->limit_variable[l] < 0 || b->limit_variable[l] >= b->counts.variables)
            return reject(message, capacity, "limit force %d: unknown variable %d", (int)l,
                          (int)b->limit_variable[l]);
        if (!all_finite(n, LIMIT_NUMBERS) || !(n[0] <= n[1]) || !(n[2] >= 0) || !(n[3] >= 0) || !(n[4] >= 0) ||
            !(n[5] > 0) || !(n[6] >= 0))
            return reject(message, capacity, "limit force %d: its numbers are invalid", (int)l);
    }
    return 0;
}

int check_variables(const blob_view *b, char *message, size_t capacity)
{
    const int32_t dofs = b->counts.dofs, variables = b->counts.variables;
    if (variables < dofs || b->counts.frames > variables || (variables == dofs && b->counts.frames != dofs))
        return reject(message, capacity, "%d variables for %d frames", (int)variables,
                      (int)b->counts.frames);
    if (!all_finite(b->term_number, (size_t)b->counts.term_numbers))
        return reject(message, capacity, "a function's numbers are not finite");
    int32_t t = 0, left = b->counts.term_numbers;
    for (int32_t k = 0; k < variables; k++) {
        const int32_t terms = b->variable_terms[k];
        if (terms < 0 || terms > b->counts.terms - t || (k < dofs && terms))
            return reject(message, capacity, "variable %d: it cannot have %d functions", (int)k, (int)terms);
        for (const int32_t end = t + terms; t < end; t++) {
            const int32_t numbers = term_numbers(b, t, k, left, message, capacity);
            if (numbers < 0) return 1;
            left -= numbers;
        }
    }
    if (t != b->counts.terms || left)
        return reject(message, capacity, "the functions' numbers do not add up to %d",
                      (int)b->counts.term_numbers);
    return check_limit_forces(b, message, capacity);
}
