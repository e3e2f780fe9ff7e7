#include "joint_variables.h"

#include <string.h>

/* Evaluate a polynomial by Horner's rule: f, f', f''. */
static void polynomial(const real *numbers, int32_t size, real x, real out[3])
{
    memset(out, 0, 3 * sizeof(real));
    for (int32_t k = size; k-- > 0;) {
        out[2] = out[2] * x + 2 * out[1];
        out[1] = out[1] * x + out[0];
        out[0] = out[0] * x + numbers[k];
    }
}

/* Evaluate the last piece that begins at or before x, or the first piece. */
static void pieces(const real *numbers, int32_t size, real x, real out[3])
{
    int32_t low = 0, high = size;
    while (high - low > 1) {
        const int32_t middle = low + (high - low) / 2;
        if (value_of(numbers[PIECE_NUMBERS * middle]) <= value_of(x)) low = middle;
        else high = middle;
    }
    const real *piece = numbers + PIECE_NUMBERS * low, D = x - piece[0];
    out[0] = piece[1] + D * (piece[2] + D * (piece[3] + D * piece[4]));
    out[1] = piece[2] + D * (2 * piece[3] + D * 3 * piece[4]);
    out[2] = 2 * piece[3] + D * 6 * piece[4];
}

void variables_move(core *c)
{
    const blob_view *b = &c->blob;
    const real *numbers = b->term_number;
    for (int32_t k = b->counts.dofs, t = 0; k < b->counts.variables; k++) {
        real sum = 0, value[3];
        for (const int32_t end = t + b->variable_terms[k]; t < end; t++) {
            const int is_polynomial = b->term_kind[t] == TERM_POLYNOMIAL;
            (is_polynomial ? polynomial : pieces)(numbers, b->term_size[t], c->at[b->term_source[t]], value);
            numbers += (is_polynomial ? 1 : PIECE_NUMBERS) * b->term_size[t];
            sum += value[0], c->slope[t] = value[1], c->curve[t] = value[2];
        }
        c->at[k] = sum;
    }
}

void variables_follow(const core *c, const real *qd, real *rates)
{
    const blob_view *b = &c->blob;
    memcpy(rates, qd, (size_t)b->counts.dofs * sizeof(real));
    for (int32_t k = b->counts.dofs, t = 0; k < b->counts.variables; k++) {
        rates[k] = 0;
        for (const int32_t end = t + b->variable_terms[k]; t < end; t++)
            rates[k] += c->slope[t] * rates[b->term_source[t]];
    }
}

const real *variables_rates(core *c, const real *qd)
{
    const blob_view *b = &c->blob;
    variables_follow(c, qd, c->moved);
    for (int32_t k = b->counts.dofs, t = 0; k < b->counts.variables; k++) {
        c->bend[k] = 0;
        for (const int32_t end = t + b->variable_terms[k]; t < end; t++) {
            const int32_t source = b->term_source[t];
            c->bend[k] += c->curve[t] * c->moved[source] * c->moved[source] + c->slope[t] * c->bend[source];
        }
    }
    return c->moved;
}

void variables_fold(const core *c, real *row, real *reduced)
{
    const blob_view *b = &c->blob;
    for (int32_t k = b->counts.variables, t = b->counts.terms; k-- > b->counts.dofs;) {
        const int32_t end = t;
        t -= b->variable_terms[k];
        if (row[k] == 0) continue; /* often: a muscle moves few variables */
        for (int32_t i = end; i-- > t;) row[b->term_source[i]] += c->slope[i] * row[k];
    }
    memcpy(reduced, row, (size_t)c->blob.counts.dofs * sizeof(real));
}

void variables_fold_matrix(core *c, real *reduced)
{
    const blob_view *b = &c->blob;
    const size_t dofs = (size_t)c->blob.counts.dofs, width = (size_t)c->blob.counts.variables;
    for (int32_t k = b->counts.variables, t = b->counts.terms; k-- > b->counts.dofs;)
        for (const int32_t begin = t - b->variable_terms[k]; t > begin;) {
            const real slope = c->slope[--t], *from = c->wide_matrix + (size_t)k * width;
            real *to = c->wide_matrix + (size_t)b->term_source[t] * width;
            for (size_t j = 0; j < width; j++) to[j] += slope * from[j];
        }
    for (size_t i = 0; i < dofs; i++) variables_fold(c, c->wide_matrix + i * width, reduced + i * dofs);
}
