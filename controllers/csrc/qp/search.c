/* Exact line search: along lam + t d the dual function is concave and piecewise quadratic, so its slope is
   piecewise linear and decreasing, with a breakpoint where a variable reaches a bound. A heap sorts the
   breakpoints. */
#include "state.h"

#include <math.h>

/* Relative to the maximum curvature, the remaining curvature below this share is a rounding error. */
static const real LOST_DIGITS = PRECISE(1e-8, 1e-5);

static void sift_down(breakpoint *heap, size_t count, size_t at)
{
    const breakpoint moved = heap[at];
    for (size_t child; (child = 2 * at + 1) < count; at = child) {
        if (child + 1 < count && heap[child + 1].at < heap[child].at) child++;
        if (moved.at <= heap[child].at) break;
        heap[at] = heap[child];
    }
    heap[at] = moved;
}

/* Collect the t >= 0 at which v_i + t dv_i enters or leaves its bounds. */
static size_t collect(dual_newton *s)
{
    size_t count = 0;
    for (size_t i = 0; i < s->n; i++) {
        const real v = s->v[i], dv = s->dv[i];
        if (dv == 0 || s->low[i] == s->high[i]) continue;
        const real enters = (dv > 0 ? s->low[i] : s->high[i]) - v;
        const real leaves = (dv > 0 ? s->high[i] : s->low[i]) - v;
        if (s->side[i] && enters / dv >= 0) s->heap[count++] = (breakpoint){enters / dv, dv * dv};
        if ((!s->side[i] || enters / dv >= 0) && isfinite(leaves))
            s->heap[count++] = (breakpoint){leaves / dv, -dv * dv};
    }
    for (size_t k = count / 2; k-- > 0;) sift_down(s->heap, count, k);
    return count;
}

/* Compute the curvature just after t from scratch. */
static real curvature(const dual_newton *s, real floor, real t)
{
    real sum = floor;
    for (size_t i = 0; i < s->n; i++) {
        const real dv = s->dv[i], v = s->v[i] + t * dv;
        if ((dv > 0 ? v >= s->low[i] : v > s->low[i]) && (dv > 0 ? v < s->high[i] : v <= s->high[i]))
            sum += dv * dv;
    }
    return sum;
}

real search_peak(dual_newton *s, real ridge, int *is_far)
{
    real slope = dot(s->m, s->r, s->d), floor = 0, t = 0;
    for (size_t j = 0; j < s->m; j++) floor += (s->eps[j] + ridge) * s->d[j] * s->d[j];
    real bend = floor;
    for (size_t i = 0; i < s->n; i++)
        if (!s->side[i]) bend += s->dv[i] * s->dv[i];
    real largest = bend;
    size_t count = collect(s);
    for (; count; sift_down(s->heap, count, 0)) {
        const breakpoint next = s->heap[0];
        if (slope <= bend * (next.at - t)) break;
        slope -= bend * (next.at - t);
        t = next.at;
        bend += next.change;
        largest = larger(largest, bend);
        if (bend < LOST_DIGITS * largest) bend = largest = curvature(s, floor, t);
        s->heap[0] = s->heap[--count];
    }
    *is_far = !count;
    const real left = larger(bend, floor);
    return left > 0 ? t + slope / left : t; /* a zero direction does not change the value */
}
