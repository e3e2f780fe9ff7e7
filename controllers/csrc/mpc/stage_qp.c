#include "stage_qp.h"

#include "../qp/vectors.h"

#include <string.h>

/* ARRAY(name, number of elements): first those of stage_qp_array. Arrays of bounds have two sides. */
#define STAGE_ARRAYS(ARRAY)                                                                            \
    ARRAY(H, N *w *w + x * x)                                                                          \
    ARRAY(g, total)                                                                                    \
    ARRAY(C, N *x *w)                                                                                  \
    ARRAY(c, N *x)                                                                                     \
    ARRAY(low, total)                                                                                  \
    ARRAY(high, total)                                                                                 \
    ARRAY(penalty, total)                                                                              \
    ARRAY(curvature, total)                                                                            \
    ARRAY(start, x)                                                                                    \
    ARRAY(is_free, 1)                                                                                  \
    ARRAY(tolerance, 2)                                                                                \
    ARRAY(v, total)                                                                                    \
    ARRAY(step, total)         /* of v */                                                              \
    ARRAY(slope, total)        /* H v + g */                                                           \
    ARRAY(defect, (N + 1) * x) /* start - x_0; C v + c - x of the next stage */                        \
    ARRAY(diagonal, total)    /* what the bounds add to H and g */                                     \
    ARRAY(force, total)                                                                                \
    ARRAY(slack, 2 * total)   /* t > 0 and e > 0, and their multipliers */                             \
    ARRAY(excess, 2 * total)                                                                           \
    ARRAY(z, 2 * total)                                                                                \
    ARRAY(l, 2 * total)                                                                                \
    ARRAY(second_z, 2 * total) /* products of the steps of the predictor */                            \
    ARRAY(second_l, 2 * total)                                                                         \
    ARRAY(factor, N *u *w)    /* rows of the Cholesky factors */                                       \
    ARRAY(P, (N + 1) * x * x) /* Hessians of the costs to go, symmetric */                             \
    ARRAY(root, x *x)         /* Cholesky factor of P_0 */                                             \
    ARRAY(PC, x *w)                                                                                    \
    ARRAY(F, w *w)                                                                                     \
    ARRAY(Pc, x)                                                                                       \
    ARRAY(f, total)

#define STAGE_MEMBER(name, length) real *name;
struct stage_qp {
    size_t N, x, u, w, total;
    int steps;
    STAGE_ARRAYS(STAGE_MEMBER)
};
#undef STAGE_MEMBER

static const size_t HANDLE_SIZE = (sizeof(stage_qp) + 7u) / 8u * 8u;
static const real INTERIOR = 0.995;      /* share of the distance to a bound */
static const real START_DISTANCE = 1e-2; /* from bounds, relative to their range */

size_t stage_qp_size(int stages, int states, int controls)
{
    if (stages < 1 || states < 1 || controls < 1 || stages > 4096 || states > 512 || controls > 512) return 0;
    const size_t N = (size_t)stages, x = (size_t)states, u = (size_t)controls, w = x + u, total = N * w + x;
    size_t count = 0;
#define ADD_LENGTH(name, length) count += length;
    STAGE_ARRAYS(ADD_LENGTH)
#undef ADD_LENGTH
    return HANDLE_SIZE + count * sizeof(real);
}

stage_qp *stage_qp_open(int stages, int states, int controls, void *memory)
{
    const size_t size = stage_qp_size(stages, states, controls);
    if (!size || !memory || (uintptr_t)memory % 8) return NULL;
    memset(memory, 0, size);
    stage_qp *s = memory;
    const size_t N = s->N = (size_t)stages, x = s->x = (size_t)states, u = s->u = (size_t)controls;
    const size_t w = s->w = x + u, total = s->total = N * w + x;
    real *at = (real *)(void *)((char *)memory + HANDLE_SIZE);
#define PLACE(name, length) s->name = at, at += length;
    STAGE_ARRAYS(PLACE)
#undef PLACE
    for (size_t i = 0; i < total; i++) s->low[i] = -INFINITY, s->high[i] = INFINITY;
    s->tolerance[0] = PRECISE(1e-10, 1e-5f), s->tolerance[1] = PRECISE(1e-9, 1e-5f);
    return s;
}

real *stage_qp_array(stage_qp *s, const char *name, size_t *length)
{
    const size_t N = s->N, x = s->x, u = s->u, w = s->w, total = s->total;
#define FIND(name_, length_) \
    if (!strcmp(name, #name_)) return *length = length_, s->name_;
    STAGE_ARRAYS(FIND)
#undef FIND
    return NULL;
}

int stage_qp_iterations(const stage_qp *s)
{
    return s->steps;
}

/* ------------------------------------------------------------------------------------ Riccati recursion */

/* Factorize the first `columns` columns of the upper triangle F, n x n, as U'U in its rows; the rest becomes
   their Schur complement. Return nonzero if F is not positive definite. */
static int factorize(size_t n, size_t columns, real *F)
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

/* Eliminate the stages from the last to the first:
     F = H + D + C' P C = U'U in the rows of u,   P <- Schur complement of x. Return nonzero on failure. */
static int eliminate(stage_qp *s)
{
    const size_t N = s->N, x = s->x, u = s->u, w = s->w;
    real *P = s->P + N * x * x;
    const real *H = s->H + N * w * w, *d = s->diagonal + N * w;
    for (size_t i = 0; i < x; i++)
        for (size_t j = i; j < x; j++) P[i * x + j] = P[j * x + i] = H[i * x + j] + (i == j ? d[i] : 0);
    for (size_t k = N; k-- > 0;) {
        const real *C = s->C + k * x * w;
        P = s->P + (k + 1) * x * x, H = s->H + k * w * w, d = s->diagonal + k * w;
        memcpy(s->F, H, w * w * sizeof(real));
        for (size_t i = 0; i < w; i++) s->F[i * w + i] += d[i];
        memset(s->PC, 0, x * w * sizeof(real));
        for (size_t i = 0; i < x; i++)
            for (size_t l = 0; l < x; l++) add(w, s->PC + i * w, P[i * x + l], C + l * w);
        for (size_t l = 0; l < x; l++)
            for (size_t i = 0; i < w; i++) add(w - i, s->F + i * w + i, C[l * w + i], s->PC + l * w + i);
        if (factorize(w, u, s->F)) return 1;
        memcpy(s->factor + k * u * w, s->F, u * w * sizeof(real));
        P = s->P + k * x * x;
        for (size_t i = 0; i < x; i++)
            for (size_t j = i; j < x; j++) P[i * x + j] = P[j * x + i] = s->F[(u + i) * w + u + j];
    }
    if (s->is_free[0] == 0) return 0;
    memcpy(s->root, s->P, x * x * sizeof(real));
    return factorize(x, x, s->root);
}

/* Solve U x = b in place, for the upper rows of a factor. */
static void solve_upper(size_t n, size_t width, const real *U, real *b)
{
    for (size_t i = n; i-- > 0;) b[i] = (b[i] - dot(n - i - 1, U + i * width + i + 1, b + i + 1)) / U[i * width + i];
}

/* Forward elimination of the rows of U' in f, of which the first `rows` are solved. */
static void reduce(size_t rows, size_t width, const real *U, real *f)
{
    for (size_t j = 0; j < rows; j++) {
        f[j] /= U[j * width + j];
        add(width - j - 1, f + j + 1, -f[j], U + j * width + j + 1);
    }
}

/* Compute H v + g and the defects of the dynamics. */
static void linearize(stage_qp *s)
{
    const size_t x = s->x, u = s->u, w = s->w;
    memcpy(s->slope, s->g, s->total * sizeof(real));
    for (size_t i = 0; i < x; i++) s->defect[i] = s->start[i] - s->v[u + i];
    for (size_t k = 0; k <= s->N; k++) {
        const size_t n = k < s->N ? w : x;
        const real *H = s->H + k * w * w, *v = s->v + k * w;
        real *slope = s->slope + k * w;
        for (size_t i = 0; i < n; i++) {
            slope[i] += dot(n - i, H + i * n + i, v + i);
            add(n - i - 1, slope + i + 1, v[i], H + i * n + i + 1);
        }
        for (size_t i = 0; k < s->N && i < x; i++)
            s->defect[(k + 1) * x + i] =
                dot(w, s->C + (k * x + i) * w, v) + s->c[k * x + i] - v[w + (k + 1 < s->N ? u : 0) + i];
    }
}

/* Compute the step of v of the factorized system, with the forces of the bounds. */
static void substitute(stage_qp *s)
{
    const size_t N = s->N, x = s->x, u = s->u, w = s->w;
    for (size_t i = 0; i < s->total; i++) s->f[i] = s->slope[i] - s->force[i];
    for (size_t k = N; k-- > 0;) {
        real *f = s->f + k * w, *p = f + w + (k + 1 < N ? u : 0);
        const real *P = s->P + (k + 1) * x * x, *C = s->C + k * x * w, *c = s->defect + (k + 1) * x;
        for (size_t i = 0; i < x; i++) s->Pc[i] = p[i] + dot(x, P + i * x, c);
        for (size_t i = 0; i < x; i++) add(w, f, s->Pc[i], C + i * w);
        reduce(u, w, s->factor + k * u * w, f);
    }
    real *v = s->step;
    memcpy(v + u, s->defect, x * sizeof(real));
    if (s->is_free[0] != 0) {
        for (size_t i = 0; i < x; i++) v[u + i] = -s->f[u + i];
        reduce(x, x, s->root, v + u);
        solve_upper(x, x, s->root, v + u);
    }
    for (size_t k = 0; k < N; k++, v += w) {
        const real *U = s->factor + k * u * w, *C = s->C + k * x * w;
        for (size_t i = 0; i < u; i++) v[i] = -s->f[k * w + i] - dot(x, U + i * w + u, v + u);
        solve_upper(u, w, U, v);
        real *then = v + w + (k + 1 < N ? u : 0);
        for (size_t i = 0; i < x; i++) then[i] = s->defect[(k + 1) * x + i] + dot(w, C + i * w, v);
    }
}

/* --------------------------------------------------------------------------------------------- bounds */

/* A side of a bound: y + e - t = bound with y = sign v; t z = e l = 0 at the optimum. */
typedef struct {
    real sign, bound, *t, *z, *e, *l, *second_z, *second_l, penalty, curvature;
    int is_soft;
    size_t i;
} side;

/* Return whether side j, of 2 total, has a bound. */
static int side_at(const stage_qp *s, size_t j, side *b)
{
    const size_t total = s->total, i = b->i = j % total;
    b->sign = j < total ? 1 : -1;
    b->bound = j < total ? s->low[i] : -s->high[i];
    if (!isfinite(b->bound) || (i >= s->u && i < s->w && s->is_free[0] == 0)) return 0;
    b->t = s->slack + j, b->z = s->z + j, b->e = s->excess + j, b->l = s->l + j;
    b->second_z = s->second_z + j, b->second_l = s->second_l + j;
    b->penalty = s->penalty[i], b->curvature = s->curvature[i];
    b->is_soft = b->penalty > 0 || b->curvature > 0;
    return 1;
}

/* Steps of t, z, e and l for a step of y, from the linearized conditions t z = m - second_z,
   e l = m - second_l and curvature e + penalty = z + l. */
typedef struct {
    real weight, force, t, z, e, l; /* next z = force - weight dy */
} side_step;

static side_step step_of(const stage_qp *s, const side *b, real m, real dy)
{
    side_step d = {0, 0, 0, 0, 0, 0};
    const real a = *b->z / *b->t, off = b->sign * s->v[b->i] + *b->e - b->bound - *b->t;
    const real push = (m - *b->second_z) / *b->t - a * off;
    d.weight = a, d.force = push;
    if (b->is_soft) {
        const real ease = *b->l / *b->e, rest = b->curvature + ease, stiff = a + rest;
        const real relief = (m - *b->second_l) / *b->e;
        const real pull = relief - b->penalty - b->curvature * *b->e;
        d.weight = a * rest / stiff, d.force = (push * rest - a * pull) / stiff;
        d.e = (push + pull - a * dy) / stiff;
        d.l = relief - ease * d.e - *b->l;
    }
    d.t = dy + d.e + off;
    d.z = push - a * (dy + d.e) - *b->z;
    return d;
}

/* Shorten a step so that a positive number remains positive. */
static void limit(real *length, real value, real change)
{
    if (change < 0) *length = smaller(*length, -value / change);
}

/* Compute the step for the complementarity m. Return its largest length up to 2, or -1
   if the cost is not convex. */
static real solve_step(stage_qp *s, real m, int is_new)
{
    side b;
    real length = 2;
    memset(s->force, 0, s->total * sizeof(real));
    if (is_new) memset(s->diagonal, 0, s->total * sizeof(real));
    for (size_t j = 0; j < 2 * s->total; j++) {
        if (!side_at(s, j, &b)) continue;
        const side_step d = step_of(s, &b, m, 0);
        if (is_new) s->diagonal[b.i] += d.weight;
        s->force[b.i] += b.sign * d.force;
    }
    if (is_new && eliminate(s)) return -1;
    substitute(s);
    for (size_t j = 0; j < 2 * s->total; j++) {
        if (!side_at(s, j, &b)) continue;
        const side_step d = step_of(s, &b, m, b.sign * s->step[b.i]);
        limit(&length, *b.t, d.t), limit(&length, *b.z, d.z);
        if (b.is_soft) limit(&length, *b.e, d.e), limit(&length, *b.l, d.l);
    }
    return length;
}

/* Return the sum of t z and e l after a step; with `keep` the products of steps become the second order. */
static real complementarity(stage_qp *s, real m, real length, int keep, size_t *count)
{
    side b;
    real sum = 0;
    *count = 0;
    for (size_t j = 0; j < 2 * s->total; j++) {
        if (!side_at(s, j, &b)) continue;
        const side_step d = length > 0 ? step_of(s, &b, m, b.sign * s->step[b.i]) : (side_step){0, 0, 0, 0, 0, 0};
        sum += (*b.t + length * d.t) * (*b.z + length * d.z), ++*count;
        if (b.is_soft) sum += (*b.e + length * d.e) * (*b.l + length * d.l), ++*count;
        if (keep) *b.second_z = d.t * d.z, *b.second_l = d.e * d.l;
    }
    return sum;
}

static void apply(stage_qp *s, real m, real length)
{
    side b;
    for (size_t j = 0; j < 2 * s->total; j++) {
        if (!side_at(s, j, &b)) continue;
        const side_step d = step_of(s, &b, m, b.sign * s->step[b.i]);
        *b.t += length * d.t, *b.z += length * d.z;
        if (b.is_soft) *b.e += length * d.e, *b.l += length * d.l;
        *b.second_z = *b.second_l = 0;
    }
    for (size_t i = 0; i < s->total; i++) s->v[i] += length * s->step[i];
}

/* Start within the bounds, with the complementarity of the gradient at v and the distances from the bounds. */
static void begin(stage_qp *s)
{
    side b;
    real sum = 0, count = 0;
    linearize(s);
    for (size_t j = 0; j < 2 * s->total; j++) {
        if (!side_at(s, j, &b)) continue;
        const real y = b.sign * s->v[b.i], range = s->high[b.i] - s->low[b.i];
        const real least = START_DISTANCE * (isfinite(range) ? range : 1);
        *b.t = larger(y - b.bound, least);
        sum += fabs(s->slope[b.i]) * *b.t, count += 1;
    }
    const real m = count > 0 ? larger(sum / count, s->tolerance[0]) : 0;
    for (size_t j = 0; j < 2 * s->total; j++) {
        if (!side_at(s, j, &b)) continue;
        const real beyond = b.bound - b.sign * s->v[b.i] + *b.t;
        *b.z = m / *b.t;
        *b.second_z = *b.second_l = 0;
        if (!b.is_soft) continue;
        *b.e = larger(beyond, m / (b.penalty + b.curvature)), *b.l = m / *b.e; /* z + l is near the penalty */
        if (beyond > 0) *b.z = larger(*b.z, b.penalty);
    }
}

int stage_qp_solve(stage_qp *s, int iterations)
{
    real rest = 1; /* of the residuals of all linear conditions */
    begin(s);
    for (s->steps = 0;; s->steps++) {
        size_t count;
        const real gap = complementarity(s, 0, 0, 0, &count) / (real)(count ? count : 1);
        if (!isfinite(gap)) return STAGE_QP_FAILED;
        if (gap <= s->tolerance[0] && rest <= s->tolerance[1]) return STAGE_QP_SOLVED;
        if (s->steps >= iterations) return STAGE_QP_NOT_CONVERGED;
        linearize(s);
        real length = solve_step(s, 0, 1), m = 0;
        if (length < 0) return STAGE_QP_FAILED;
        if (count) { /* Mehrotra's corrector */
            const real after = complementarity(s, 0, smaller(length, 1), 1, &count) / (real)count;
            m = after / gap * (after / gap) * after;
            length = INTERIOR * solve_step(s, m, 0);
        }
        length = smaller(length, 1);
        apply(s, m, length);
        rest *= 1 - length;
    }
}
