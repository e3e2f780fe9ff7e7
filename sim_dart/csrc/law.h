/* Tension laws: command u, path length l, its rate v and the law's own states x -> tension f and x'.

   A law is one file with pure functions, and a line here. What it makes of its parameters once are its
   constants k, which begin in every law as enum law_constant says.                                    */
#ifndef CARDSFLOW_LAW_H
#define CARDSFLOW_LAW_H

#include "core.h"
#include "real_functions.h"

#include <stddef.h>

/* The parameters of every law, in order; the names are those of addin_sdfusion/robot/model/tension_laws.py. */
#define ELASTIC_CABLE_PARAMETERS(P) P(stiffness) P(damping) P(longest_rest_length)
#define SPRING_PARAMETERS(P) P(K) P(l0)
#define MOTOR_PARAMETERS(P)                                                                            \
    P(resistance)                                                                                      \
    P(bridge_resistance)                                                                               \
    P(inductance)                                                                                      \
    P(back_emf_constant)                                                                               \
    P(torque_constant)                                                                                 \
    P(gear_ratio)                                                                                      \
    P(gear_efficiency)                                                                                 \
    P(gear_inertia) P(motor_inertia) P(spindle_radius) P(stiffness) P(rest_length) P(max_voltage)
#define MCKIBBEN_PARAMETERS(P)                                                                         \
    P(thread_length) P(turns) P(cord_length) P(max_pressure) P(pressure_time_constant)
#define HILL_PARAMETERS(P)                                                                             \
    P(max_isometric_force)                                                                             \
    P(optimal_fibre_length)                                                                            \
    P(tendon_slack_length)                                                                             \
    P(pennation_at_optimal)                                                                            \
    P(max_contraction_velocity)                                                                        \
    P(activation_time_constant) P(deactivation_time_constant) P(minimum_activation) P(elastic_tendon)
#define DE_GROOTE_PARAMETERS(P)                                                                        \
    HILL_PARAMETERS(P)                                                                                 \
    P(fibre_damping)                                                                                   \
    P(active_width_scale) P(passive_fibre_strain) P(tendon_strain) P(activation_smoothing)
#define MILLARD_PARAMETERS(P)                                                                          \
    HILL_PARAMETERS(P)                                                                                 \
    P(fibre_damping)                                                                                   \
    P(maximum_pennation)                                                                               \
    P(active_shortest)                                                                                 \
    P(active_transition)                                                                               \
    P(active_longest)                                                                                  \
    P(active_shallow_slope)                                                                            \
    P(active_minimum)                                                                                  \
    P(concentric_slope_at_vmax)                                                                        \
    P(concentric_slope_near_vmax)                                                                      \
    P(isometric_slope)                                                                                 \
    P(eccentric_slope_at_vmax)                                                                         \
    P(eccentric_slope_near_vmax)                                                                       \
    P(eccentric_force)                                                                                 \
    P(concentric_curviness)                                                                            \
    P(eccentric_curviness)                                                                             \
    P(passive_zero_strain)                                                                             \
    P(passive_fibre_strain)                                                                            \
    P(passive_stiffness_low)                                                                           \
    P(passive_stiffness)                                                                               \
    P(passive_curviness)                                                                               \
    P(tendon_strain) P(tendon_stiffness) P(tendon_toe_force) P(tendon_curviness)
#define THELEN_PARAMETERS(P)                                                                           \
    HILL_PARAMETERS(P)                                                                                 \
    P(tendon_strain)                                                                                   \
    P(passive_fibre_strain)                                                                            \
    P(active_shape) P(passive_shape) P(concentric_shape) P(eccentric_force) P(linear_from)
#define LIGAMENT_PARAMETERS(P)                                                                         \
    P(linear_stiffness) P(transition_strain) P(damping_coefficient) P(slack_length)
#define NO_PARAMETERS(P)

/* LAW(kind, the name of its tension_law, parameters). The order is that of law_kind. */
#define LAWS(LAW)                                                                                      \
    LAW(ideal, IDEAL, NO_PARAMETERS)                                                                   \
    LAW(elastic_cable, ELASTIC_CABLE, ELASTIC_CABLE_PARAMETERS)                                        \
    LAW(passive_spring, SPRING, SPRING_PARAMETERS)                                                     \
    LAW(series_elastic_motor, MOTOR, MOTOR_PARAMETERS)                                                 \
    LAW(mckibben, MCKIBBEN, MCKIBBEN_PARAMETERS)                                                       \
    LAW(hill_degroote2016, DE_GROOTE, DE_GROOTE_PARAMETERS)                                            \
    LAW(hill_millard2012, MILLARD, MILLARD_PARAMETERS)                                                 \
    LAW(hill_thelen2003, THELEN, THELEN_PARAMETERS)                                                    \
    LAW(ligament_blankevoort1991, LIGAMENT, LIGAMENT_PARAMETERS)

#define LAW_KIND(kind, law, parameters) KIND_##law,
enum { LAWS(LAW_KIND) LAW_KINDS };
#undef LAW_KIND

/* Smallest and largest command; how many states there are, and how far off the constants k are that this
   muscle shares with others (see shared_from): both set by laws_prepare; the law's own.                 */
enum law_constant { LAW_LOW = 0, LAW_HIGH, LAW_STATES, LAW_SHARED, LAW_OWN };

#define MOST_LAW_STATES 3
/* Nothing real pulls harder, in [N]: keeps a state that runs away a number. */
#define LARGEST_TENSION 1e15

/* Where a parameter stands: enum { X_PARAMETERS(AT) PARAMETERS }. */
#define AT(name) AT_##name,

typedef struct {
    int parameters, constants;
    /* Muscles in a row that agree in all parameters from this one on look at one of them for what it makes
       of these (law_shared), which so stays at hand; 0 if there is nothing of the kind.                 */
    int shared_from;
    int driven; /* has a command */
    int pushes; /* its tension may be negative */
    int is_hill; /* its constants and states are those of hill.h */
    /* What is wrong with finite parameters p, or NULL; NULL if nothing can be. */
    const char *(*refusal)(const real *p);
    void (*prepare)(const real *p, real *k);
    real (*tension)(const real *k, const real *x, real l, real v, real u);
    /* The next four are NULL for a law without states. */
    int (*states)(const real *p);
    void (*rates)(const real *k, const real *x, real l, real v, real u, real *xd);
    void (*start)(const real *k, real l, real u, real *x);
    /* x after a time h, while l grows by v h. */
    void (*advance)(const real *k, real *x, real l, real v, real u, real h);
    /* See core_curve; NULL for a law without curves. */
    real (*curve)(const real *k, const char *name, real x, real *slope);
} tension_law;

#define DECLARE_LAW(kind, law, parameters) extern const tension_law LAW_##law;
LAWS(DECLARE_LAW)
#undef DECLARE_LAW

static inline const real *law_shared(const real *k)
{
    return k + (ptrdiff_t)value_of(k[LAW_SHARED]);
}

static inline real clamped(real x, real low, real high)
{
    return value_of(x) < value_of(low) ? low : value_of(x) > value_of(high) ? high : x;
}

#endif
