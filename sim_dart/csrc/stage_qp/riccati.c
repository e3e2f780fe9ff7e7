#include "riccati.h"

#include <string.h>

/* ---------------------------------------------------------------------------------------- residuals */

/* Add H v for the upper triangle H, n x n. */
static void add_product(size_t n, const real *H, const real *v, real *out)
{
    for (size_t i = 0; i < n; i++) {
        out[i] += dot(n - i, H + i * n + i, v + i);
        add(n - i - 1, out + i + 1, v[i], H + i * n + i + 1);
    }
}

void riccati_residuals(stage_qp *s)
{
    const size_t x = s->x, w = s->w;
    memcpy(s->slope, s->g, s->total * sizeof(real));
    for (size_t i = 0; i < x; i++) s->defect[i] = s->start[i] - s->v[s->u + i];
    for (size_t k = 0; k < s->N; k++) {
        const real *v = s->v + k * w, *next = s->v + stage_states(s, k + 1);
        add_product(w, s->H + k * w * w, v, s->slope + k * w);
        for (size_t i = 0; i < x; i++)
            s->defect[(k + 1) * x + i] = dot(w, s->C + (k * x + i) * w, v) + s->c[k * x + i] - next[i];
    }
    add_product(x, s->H + s->N * w * w, s->v + s->N * w, s->slope + s->N * w);
}

/* ---------------------------------------------------------------------------------------- factorization */

/* Factorize the first `columns` columns of the upper triangle F, n x n, as U'U in its rows; the rest becomes
   their Schur complement. Return nonzero if F is not positive definite. */
static int factorize_columns(size_t n, size_t columns, real *F)
{
    for (size_t j = 0; j < columns; j++) {
        real *row = F + j * n;
        if (!(row[j] > 0)) return 1;
        const real scale = 1 / sqrt(row[j]);
        for (size_t i = j; i < n; i++) row[i] *= scale;
        for (size_t i = j + 1; i < n; i++) add(n - i, F + i * n + i, -row[i], row + i);
    }
    return 0;
}

/* Compute P = the last x rows and columns of the upper triangle F, n x n, as a symmetric matrix. */
static void copy_symmetric(size_t x, size_t n, const real *F, real *P)
{
    const size_t first = n - x;
    for (size_t i = 0; i < x; i++)
        for (size_t j = i; j < x; j++) P[i * x + j] = P[j * x + i] = F[(first + i) * n + first + j];
}

/* Compute the upper triangle F = H + D + C' P C of stage k, with P of the next stage. */
static void add_cost_to_go(stage_qp *s, size_t k)
{
    const size_t x = s->x, w = s->w;
    const real *C = s->C + k * x * w, *P = s->P + (k + 1) * x * x, *d = s->diagonal + k * w;
    memcpy(s->F, s->H + k * w * w, w * w * sizeof(real));
    for (size_t i = 0; i < w; i++) s->F[i * w + i] += d[i];
    memset(s->PC, 0, x * w * sizeof(real));
    for (size_t i = 0; i < x; i++)
        for (size_t l = 0; l < x; l++) add(w, s->PC + i * w, P[i * x + l], C + l * w);
    for (size_t l = 0; l < x; l++)
        for (size_t i = 0; i < w; i++) add(w - i, s->F + i * w + i, C[l * w + i], s->PC + l * w + i);
}

/* P_N = H_N + D_N; then P_k is the Schur complement of x in F, after the elimination of u: F = U'U in the
   rows of u. */
int riccati_factorize(stage_qp *s)
{
    const size_t N = s->N, x = s->x, u = s->u, w = s->w;
    const real *d = s->diagonal + N * w;
    memcpy(s->F, s->H + N * w * w, x * x * sizeof(real));
    for (size_t i = 0; i < x; i++) s->F[i * x + i] += d[i];
    copy_symmetric(x, x, s->F, s->P + N * x * x);
    for (size_t k = N; k-- > 0;) {
        add_cost_to_go(s, k);
        if (factorize_columns(w, u, s->F)) return 1;
        memcpy(s->factor + k * u * w, s->F, u * w * sizeof(real));
        copy_symmetric(x, w, s->F, s->P + k * x * x);
    }
    return 0;
}

/* --------------------------------------------------------------------------------------------- solution */

/* Solve U x = b in place, for the upper rows of a factor. */
static void solve_upper(size_t n, size_t width, const real *U, real *b)
{
    for (size_t i = n; i-- > 0;) b[i] = (b[i] - dot(n - i - 1, U + i * width + i + 1, b + i + 1)) / U[i * width + i];
}

/* Eliminate the first `rows` variables from f: forward elimination of the rows of U'. */
static void reduce(size_t rows, size_t width, const real *U, real *f)
{
    for (size_t j = 0; j < rows; j++) {
        f[j] /= U[j * width + j];
        add(width - j - 1, f + j + 1, -f[j], U + j * width + j + 1);
    }
}

/* Backward: f_k + C' (p_k+1 + P_k+1 defect), without u; its part of x is the gradient p_k of the cost to go. */
static void eliminate_gradients(stage_qp *s)
{
    const size_t x = s->x, u = s->u, w = s->w;
    for (size_t i = 0; i < s->total; i++) s->f[i] = s->slope[i] - s->force[i];
    for (size_t k = s->N; k-- > 0;) {
        real *f = s->f + k * w, *p = s->f + stage_states(s, k + 1);
        const real *P = s->P + (k + 1) * x * x, *C = s->C + k * x * w, *c = s->defect + (k + 1) * x;
        for (size_t i = 0; i < x; i++) s->Pc[i] = p[i] + dot(x, P + i * x, c);
        for (size_t i = 0; i < x; i++) add(w, f, s->Pc[i], C + i * w);
        reduce(u, w, s->factor + k * u * w, f);
    }
}

void riccati_solve(stage_qp *s)
{
    const size_t x = s->x, u = s->u, w = s->w;
    eliminate_gradients(s);
    memcpy(s->step + u, s->defect, x * sizeof(real));
    for (size_t k = 0; k < s->N; k++) {
        const real *U = s->factor + k * u * w, *C = s->C + k * x * w;
        real *v = s->step + k * w, *next = s->step + stage_states(s, k + 1);
        for (size_t i = 0; i < u; i++) v[i] = -s->f[k * w + i] - dot(x, U + i * w + u, v + u);
        solve_upper(u, w, U, v);
        for (size_t i = 0; i < x; i++) next[i] = s->defect[(k + 1) * x + i] + dot(w, C + i * w, v);
    }
}
