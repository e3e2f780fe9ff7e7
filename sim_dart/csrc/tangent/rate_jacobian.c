#include "rate_jacobian.h"

#include <string.h>

#if HAS_CORE_TANGENT

#include "../blob/state.h"
#include "../loops/loops.h"

struct rate_jacobian {
    core *plain;
    core_tangent *tangent;
    size_t n, m, states, width, columns;
    double *rows;              /* the result */
    double *response, *pull;   /* M^-1; -M^-1 L', row by row of muscles */
    double *laws, *path_rates; /* see core_tangent_laws; rates of paths by q, row by row of coordinates */
    double *row;               /* two rows of coordinates */
};

static size_t own_numbers(const core *plain)
{
    const size_t n = (size_t)plain->blob.counts.dofs, m = (size_t)plain->blob.counts.muscles, width = state_size(plain);
    return width * (width + m + n) + n * n + 2 * n * m + LAW_PARTIALS * m + 2 * n;
}

size_t rate_jacobian_size(const core *plain)
{
    return sizeof(rate_jacobian) + own_numbers(plain) * sizeof(double) + core_tangent_size(plain);
}

rate_jacobian *rate_jacobian_open(core *plain, void *memory)
{
    rate_jacobian *r = memory;
    r->plain = plain;
    r->n = (size_t)plain->blob.counts.dofs, r->m = (size_t)plain->blob.counts.muscles;
    r->states = (size_t)plain->blob.law_states, r->width = state_size(plain);
    r->columns = r->width + r->m + r->n;
    r->rows = (double *)(void *)(r + 1);
    memset(r->rows, 0, own_numbers(plain) * sizeof(double));
    r->response = r->rows + r->width * r->columns;
    r->pull = r->response + r->n * r->n;
    r->laws = r->pull + r->n * r->m;
    r->path_rates = r->laws + LAW_PARTIALS * r->m;
    r->row = r->path_rates + r->n * r->m;
    r->tangent = core_tangent_open(plain, r->row + 2 * r->n);
    return r;
}

core_tangent *rate_jacobian_tangent(const rate_jacobian *r)
{
    return r->tangent;
}

/* Compute the accelerations due to unit external forces, and due to unit tensions. */
static void respond(rate_jacobian *r)
{
    const core *c = r->plain;
    for (size_t j = 0; j < r->n; j++) {
        memset(r->row, 0, r->n * sizeof(double));
        r->row[j] = 1;
        loops_respond(r->plain, r->row, r->response + j * r->n);
    }
    memset(r->pull, 0, r->n * r->m * sizeof(double));
    for (size_t m = 0; m < r->m; m++)
        for (size_t j = 0; j < r->n; j++) {
            const double arm = c->jacobian[m * r->n + j], *response = r->response + j * r->n;
            if (arm == 0) continue;
            for (size_t i = 0; i < r->n; i++) r->pull[m * r->n + i] -= arm * response[i];
        }
}

/* Write a column of the accelerations. */
static void set_column(rate_jacobian *r, size_t column, const double *from)
{
    for (size_t i = 0; i < r->n; i++) r->rows[(r->n + i) * r->columns + column] = from[i];
}

/* Fill the columns of q and qd with constant tensions. */
static void fill_state(rate_jacobian *r)
{
    const size_t n = r->n;
    for (size_t i = 0; i < n; i++) r->rows[i * r->columns + n + i] = 1;
    for (size_t j = 0; j < n; j++) { /* first, since the tree has no changes yet */
        core_tangent_accelerate_along_qd(r->tangent, j, r->row);
        set_column(r, n + j, r->row);
    }
    for (size_t j = 0; j < n; j++) {
        core_tangent_accelerate_along_q(r->tangent, j, r->row, r->path_rates + j * r->m);
        set_column(r, j, r->row);
    }
}

/* Fill the columns of commands and external forces; the commands of heavy cables also change their weight. */
static void fill_controls(rate_jacobian *r)
{
    for (size_t j = 0; j < r->n; j++) set_column(r, r->width + r->m + j, r->response + j * r->n);
    for (size_t m = 0; m < r->m; m++) {
        const double by_command = r->laws[LAW_PARTIALS * m + LAW_BY_COMMAND];
        for (size_t i = 0; i < r->n; i++) r->row[i] = by_command * r->pull[m * r->n + i];
        if (r->plain->has_weight) {
            double *weight = r->row + r->n;
            core_tangent_weight_along_command(r->tangent, m, weight);
            for (size_t j = 0; j < r->n; j++)
                for (size_t i = 0; i < r->n; i++) r->row[i] += weight[j] * r->response[j * r->n + i];
        }
        set_column(r, r->width + m, r->row);
    }
}

/* Add scale times the change of the length or rate of muscle m by the state to a row. */
static void add_path(const rate_jacobian *r, size_t m, double by_length, double by_rate, double *row)
{
    const double *arms = r->plain->jacobian + m * r->n;
    for (size_t j = 0; j < r->n; j++) {
        row[j] += by_length * arms[j] + by_rate * r->path_rates[j * r->m + m];
        row[r->n + j] += by_rate * arms[j];
    }
}

/* Add the effect of the length, rate and states of a muscle on its tension and on its states. */
static void add_muscle(rate_jacobian *r, size_t m, size_t first, size_t count)
{
    const double *law = r->laws + LAW_PARTIALS * m;
    for (size_t i = 0; i < r->n; i++) {
        double *row = r->rows + (r->n + i) * r->columns;
        const double pull = r->pull[m * r->n + i];
        if (pull == 0) continue;
        add_path(r, m, pull * law[LAW_BY_LENGTH], pull * law[LAW_BY_RATE], row);
        for (size_t k = 0; k < count; k++) row[2 * r->n + first + k] += pull * law[LAW_BY_STATES + k];
    }
    for (size_t k = 0; k < count; k++) {
        double *row = r->rows + (2 * r->n + first + k) * r->columns;
        law += LAW_INPUTS;
        add_path(r, m, law[LAW_BY_LENGTH], law[LAW_BY_RATE], row);
        for (size_t i = 0; i < count; i++) row[2 * r->n + first + i] = law[LAW_BY_STATES + i];
        row[r->width + m] = law[LAW_BY_COMMAND];
    }
}

const double *rate_jacobian_fill(rate_jacobian *r, const double *commands, const double *torques)
{
    core_tangent_place(r->tangent, r->plain, commands, torques);
    core_tangent_laws(r->tangent, r->laws);
    memset(r->rows, 0, r->width * r->columns * sizeof(double));
    respond(r);
    fill_controls(r);
    fill_state(r);
    if (!r->plain->has_laws) return r->rows;
    for (size_t m = 0, first = 0; m < r->m; m++) {
        const size_t count = (size_t)r->laws[LAW_PARTIALS * m + LAW_STATE_COUNT];
        add_muscle(r, m, first, count);
        first += count;
    }
    return r->rows;
}

const double *rate_jacobian_close(rate_jacobian *r)
{
    for (size_t j = 0; j < 2 * r->n; j++) {
        double *column = r->rows + 2 * r->n * 2 * r->n;
        core_tangent_close_along(r->tangent, r->plain, j, column);
        for (size_t i = 0; i < 2 * r->n; i++) r->rows[i * 2 * r->n + j] = column[i];
    }
    return r->rows;
}

#else
typedef int no_rate_jacobian; /* ISO C forbids empty translation units */
#endif
