/* The muscle laws of a robot: checks, derived constants, ranges and inverses. */
#include "laws.h"

#include "../blob/message.h"
#include "../math/elementary.h"
#include "hill/activation.h"
#include "muscle_law.h"

#include <math.h>
#include <string.h>

#if !IS_ONE_UNIT
#include "../../generated/law_table.h"
#endif

static int is_within(const law_bounds *bounds, real x)
{
    const int above = bounds->is_open ? value_of(x) > value_of(bounds->low) : value_of(x) >= value_of(bounds->low);
    return above && value_of(x) <= value_of(bounds->high) && isfinite(x);
}

/* Check the parameters of a muscle against the bounds and rules of its law. */
static int parameters_check(const law_entry *entry, const real *p, int m, char *message, size_t capacity)
{
    for (int i = 0; i < entry->parameters; i++) {
        const law_bounds *bounds = BOUNDS + entry->bounds[i];
        if (!is_within(bounds, p[i]))
            return reject(message, capacity, "muscle %d: %s: %s must be %s", m, entry->name, entry->names[i], bounds->words);
    }
    const char *wrong = entry->broken_rule ? entry->broken_rule(p) : NULL;
    if (!wrong && entry->law->check) wrong = entry->law->check(p);
    return wrong ? reject(message, capacity, "muscle %d: %s: %s", m, entry->name, wrong) : 0;
}

int laws_check(blob_view *view, char *message, size_t capacity)
{
    const real *p = view->law_parameter;
    int64_t left = view->counts.law_parameters, states = 0, constants = 0;
    view->stretches = 0;
    for (int32_t m = 0; m < view->counts.muscles; m++) {
        const int32_t kind = view->law_kind[m];
        if (kind < 0 || kind >= LAW_KINDS)
            return reject(message, capacity, "muscle %d: unknown muscle law %d", (int)m, (int)kind);
        const law_entry *entry = LAW_TABLE + kind;
        const tension_law *law = entry->law;
        if (!law) return reject(message, capacity, "the robot needs USES_LAW_%s; define it in CARDSFLOW_PARTS", entry->name);
        left -= entry->parameters;
        if (left < 0) break;
        if (parameters_check(entry, p, (int)m, message, capacity)) return 1;
        if (view->muscle_bends[m] && entry->pushes)
            return reject(message, capacity, "muscle %d: %s pushes and cannot have friction", (int)m, entry->name);
        if (law->place && view->muscle_points[m] != 2)
            return reject(message, capacity, "muscle %d: %s hangs between two via points", (int)m, entry->name);
        states += entry->states ? entry->states(p) : 0;
        if (law->stretch) view->stretches += view->muscle_bends[m];
        constants += law->constants;
        p += entry->parameters;
    }
    if (left) return reject(message, capacity, "the law parameters do not add up");
    view->law_states = (int32_t)states + view->stretches + view->counts.bends, view->law_constants = (int32_t)constants;
    return 0;
}

/* Share constants with the muscle before, if they are equal. */
static void share_constants(const muscle_law *before, muscle_law *at)
{
    if (!at->law->shared_from || before->law != at->law) return;
    for (int i = at->law->shared_from; i < at->entry->parameters; i++)
        if (before->p[i] != at->p[i]) return;
    const ptrdiff_t away = law_shared(before->k) - at->k;
    at->k[LAW_SHARED] = (real)away;
    if (law_shared(at->k) - at->k != away) at->k[LAW_SHARED] = 0; /* the offset must be exact */
}

/* Tensions at both ends of the command range of a muscle, and the state at which core_reach found them. */
typedef struct {
    real is_known, l, v, h, x[MAX_LAW_STATES], at_low, at_high;
} reach;

_Static_assert(sizeof(reach) == REACH_NUMBERS * sizeof(real), "REACH_NUMBERS is wrong");

static reach *reach_of(const core *c, const muscle_law *at)
{
    return (reach *)(void *)c->reached + at->m;
}

/* With tangents, the ranges of commands and the numbers of states are those of the plain handle. */
void laws_prepare(core *c)
{
    muscle_law at, before = {0};
    for EACH_MUSCLE (c, &at) {
        if (!HAS_TANGENT) {
            at.entry->range(at.p, at.k);
            at.k[LAW_STATES] = at.entry->states ? at.entry->states(at.p) : 0;
        }
        at.k[LAW_SHARED] = 0;
        if (at.law->prepare) at.law->prepare(at.p, at.k);
        reach_of(c, &at)->is_known = 0;
        share_constants(&before, &at);
        before = at;
        c->has_weight |= at.law->place != NULL;
        c->has_fibres |= at.law->settle && at.k[LAW_STATES] == 2;
    }
}

#define PERIOD_TOLERANCE (real)1e-6 /* of a period */
#define MAX_HELD 100

/* Return the tension at the driven end of a cable with the mean tension f. */
static real tension_at_driven_end(const core *c, int32_t m, real f)
{
    return does_stretch(c, m) ? f / (1 + c->cable_rise[m]) : f;
}

/* Return the tension after a time h with command u; the current tension for a law without states. A command
   that moves along with the path does so after every `hold`. */
static real tension_after(const core *c, const muscle_law *at, real u, real h, real hold)
{
    const real l = c->lengths[at->m], driven = length_at(c, at->m), v = c->rates[at->m];
    if (!at->states) return tension_at_driven_end(c, at->m, bounded_tension(at, NULL, l, v, u));
    real x[MAX_LAW_STATES];
    memcpy(x, at->x, (size_t)at->states * sizeof(real));
    const int steps = at->law->moves_along ? whole_steps(ceil(h / hold - PERIOD_TOLERANCE), MAX_HELD) : 1;
    const real t = h / steps, along = at->law->moves_along ? v * t : 0;
    for (int i = 0; i < steps; i++) at->law->advance(at->k, x, driven + v * t * i, v, u + along * i, t);
    return tension_at_driven_end(c, at->m, bounded_tension(at, x, l + v * h, v, u));
}

static void store_reach(const core *c, const muscle_law *at, real h, real at_low, real at_high)
{
    reach *r = reach_of(c, at);
    if (at->law->moves_along || at->law->place || does_stretch(c, at->m)) return; /* not a function of the state */
    r->is_known = 1, r->l = c->lengths[at->m], r->v = c->rates[at->m], r->h = h;
    r->at_low = at_low, r->at_high = at_high;
    memcpy(r->x, at->x, (size_t)at->states * sizeof(real));
}

/* Return the result of core_reach if nothing has changed since; otherwise NULL. */
static const reach *cached_reach(const core *c, const muscle_law *at, real h)
{
    const reach *r = reach_of(c, at);
    int same = r->is_known == 1 && r->l == c->lengths[at->m] && r->v == c->rates[at->m] && r->h == h;
    for (int32_t i = 0; i < at->states; i++) same &= r->x[i] == at->x[i];
    return same ? r : NULL;
}

void core_reach(core *c, real h)
{
    muscle_law at;
    for EACH_MUSCLE (c, &at) {
        real *low = c->force_low + at.m, *high = c->force_high + at.m;
        if (c->blob.law_kind[at.m] == KIND_ideal) {
            *low = 0, *high = INFINITY;
            continue;
        }
        const real a = tension_after(c, &at, at.k[LAW_LOW], h, h);
        const real b = at.entry->driven ? tension_after(c, &at, at.k[LAW_HIGH], h, h) : a;
        *low = smaller(a, b), *high = larger(a, b);
        store_reach(c, &at, h, a, b);
    }
}

#define MAX_INVERSIONS 60
#define FORCE_TOLERANCE PRECISE(1e-14, 5e-6) /* relative tolerance of a force */
#define ROUGH_TOLERANCE PRECISE(1e-11, 2e-5) /* the same, for laws that are rough */
#define NEAR_INVERSIONS 6

/* Difference of the tension from f at a command, during the search. */
typedef struct {
    real u, off;
} attempt;

static real secant_zero(const attempt *a, const attempt *b)
{
    return (a->u * b->off - b->u * a->off) / (b->off - a->off);
}

static attempt evaluate_attempt(const core *c, const muscle_law *at, real u, real f, real h, real hold)
{
    return (attempt){u, tension_after(c, at, u, h, hold) - f};
}

/* Return whether u is between two commands. */
static int is_between(const attempt *a, const attempt *b, real u)
{
    return value_of(u) > value_of(smaller(a->u, b->u)) && value_of(u) < value_of(larger(a->u, b->u));
}

static real tolerance_of(const muscle_law *at, real f, const attempt *a, const attempt *b)
{
    const real enough = FORCE_TOLERANCE * (fabs(f) + fabs(a->off - b->off));
    return at->law->is_rough ? enough + ROUGH_TOLERANCE * fabs(f) : enough;
}

/* Apply the secant method from the guess of a law. Return whether it has found a command within the range. */
static int search_near(const core *c, const muscle_law *at, real f, real h, real hold, real *u)
{
    real step;
    *u = at->law->guess(at->k, at->x, length_at(c, at->m), f, &step);
    attempt before = evaluate_attempt(c, at, *u, f, h, hold), last = before;
    *u += value_of(last.off) > 0 ? step : -step;
    for (int i = 0; i < NEAR_INVERSIONS; i++) {
        if (!(value_of(*u) >= value_of(at->k[LAW_LOW]) && value_of(*u) <= value_of(at->k[LAW_HIGH]))) return 0;
        before = last, last = evaluate_attempt(c, at, *u, f, h, hold);
        if (value_of(fabs(last.off)) <= value_of(tolerance_of(at, f, &before, &last))) return 1;
        *u = secant_zero(&before, &last);
    }
    return 0;
}

/* Apply the secant method on a bracket, which is bisected if a step would leave it, and regularly. First try
   the command that keeps an activation constant: there the time constant changes. */
static real invert_law(const core *c, const muscle_law *at, real f, real h, real hold)
{
    real near;
    if (at->law->guess && search_near(c, at, f, h, hold, &near)) return near;
    const reach *cached = cached_reach(c, at, h);
    attempt low = cached ? (attempt){at->k[LAW_LOW], cached->at_low - f} : evaluate_attempt(c, at, at->k[LAW_LOW], f, h, hold);
    if (low.off == 0) return low.u;
    attempt high = cached ? (attempt){at->k[LAW_HIGH], cached->at_high - f} : evaluate_attempt(c, at, at->k[LAW_HIGH], f, h, hold);
    if ((value_of(low.off) > 0) == (value_of(high.off) > 0))
        return value_of(fabs(low.off)) <= value_of(fabs(high.off)) ? low.u : high.u;
    const real enough = tolerance_of(at, f, &high, &low);
    attempt before = low, last = high;
    real u = at->law->is_hill ? at->x[0] : secant_zero(&low, &high);
    for (int i = 0; i < MAX_INVERSIONS; i++) {
        if (!is_between(&low, &high, u) || i % 8 == 7) u = (low.u + high.u) / 2;
        before = last, last = evaluate_attempt(c, at, u, f, h, hold);
        if (value_of(fabs(last.off)) <= value_of(enough)) break;
        const int is_high = (value_of(last.off) > 0) == (value_of(high.off) > 0);
        *(is_high ? &high : &low) = last;
        if (!i) before = is_high ? low : high; /* the end on the other side of the kink */
        u = secant_zero(&before, &last);
    }
    return last.u;
}

int core_invert(core *c, const real *f, real h, real hold)
{
    for (int32_t m = 0; m < c->blob.counts.muscles; m++)
        if (!isfinite(f[m])) return 1 + m;
    muscle_law at;
    for EACH_MUSCLE (c, &at) {
        if (!at.entry->driven)
            c->commands[at.m] = 0;
        else if (c->blob.law_kind[at.m] == KIND_ideal)
            c->commands[at.m] = larger(f[at.m], 0);
        else
            c->commands[at.m] = invert_law(c, &at, f[at.m], h, hold);
    }
    return 0;
}

void core_fibres(const core *c, int32_t count, const real *points, real *values)
{
    const size_t muscles = (size_t)c->blob.counts.muscles;
    muscle_law at;
    for EACH_MUSCLE (c, &at) {
        for (size_t i = 0; at.law->fibre && i < (size_t)count; i++) {
            const size_t place = i * muscles + (size_t)at.m;
            at.law->fibre(at.k, points + FIBRE_POINT * place, values + FIBRE_VALUES * place);
        }
    }
}

void core_tendons(const core *c, int32_t count, const real *points, real *values)
{
    const size_t muscles = (size_t)c->blob.counts.muscles;
    muscle_law at;
    for EACH_MUSCLE (c, &at) {
        for (size_t i = 0; at.law->tendon && value_of(at.k[HILL_SLACK]) > 0 && i < (size_t)count; i++) {
            const size_t place = TENDON_NUMBERS * (i * muscles + (size_t)at.m);
            at.law->tendon(at.k, points + place, values + place);
        }
    }
}

real core_curve(const core *c, int32_t muscle, const char *curve, real x, int slope)
{
    muscle_law at;
    for EACH_MUSCLE (c, &at) {
        if (at.m != muscle) continue;
        real dydx = NAN;
        const real y = at.law->curve ? at.law->curve(at.k, curve, x, &dydx) : NAN;
        return slope ? dydx : y;
    }
    return NAN;
}
