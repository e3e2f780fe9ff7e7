/* The tension laws that a blob may name, and their parameters in it: a law is a line here, and a file with
   pure functions in laws/.                                                                            */
#ifndef CARDSFLOW_LAW_PARAMETERS_H
#define CARDSFLOW_LAW_PARAMETERS_H

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
#define SCHUTTE_PARAMETERS(P) HILL_PARAMETERS(P) P(fibre_damping)
#define LIGAMENT_PARAMETERS(P)                                                                         \
    P(linear_stiffness) P(transition_strain) P(damping_coefficient) P(slack_length)
#define MUJOCO_PARAMETERS(P)                                                                           \
    P(force)                                                                                           \
    P(length_low)                                                                                      \
    P(length_high)                                                                                     \
    P(range_low)                                                                                       \
    P(range_high)                                                                                      \
    P(lmin)                                                                                            \
    P(lmax)                                                                                            \
    P(vmax)                                                                                            \
    P(fpmax)                                                                                           \
    P(fvmax)                                                                                           \
    P(scale)                                                                                           \
    P(acc0)                                                                                            \
    P(passive_range_low)                                                                               \
    P(passive_range_high)                                                                              \
    P(passive_lmax)                                                                                    \
    P(activation_time_constant)                                                                        \
    P(deactivation_time_constant) P(activation_width) P(control_low) P(control_high)
#define PATH_SPRING_PARAMETERS(P) P(stiffness) P(rest_length) P(dissipation)
#define TENDON_SPRING_PARAMETERS(P) P(stiffness) P(rest_low) P(rest_high) P(damping)
#define WINCH_PARAMETERS(P)                                                                            \
    P(drum_radius)                                                                                     \
    P(drum_pitch)                                                                                      \
    P(gear_ratio)                                                                                      \
    P(motor_inertia)                                                                                   \
    P(drum_inertia)                                                                                    \
    P(viscous_friction)                                                                                \
    P(dry_friction)                                                                                    \
    P(axial_stiffness) P(dissipation) P(lead_length) P(rest_length) P(max_torque)
#define WINCH_POSITION_PARAMETERS(P)                                                                   \
    WINCH_PARAMETERS(P) P(position_gain) P(velocity_gain) P(longest_rest_length)
#define HEAVY_CABLE_PARAMETERS(P) P(axial_stiffness) P(mass_per_length) P(damping) P(longest_rest_length)
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
    LAW(hill_schutte1993, SCHUTTE, SCHUTTE_PARAMETERS)                                                 \
    LAW(ligament_blankevoort1991, LIGAMENT, LIGAMENT_PARAMETERS)                                       \
    LAW(mujoco_muscle, MUJOCO, MUJOCO_PARAMETERS)                                                      \
    LAW(path_spring, PATH_SPRING, PATH_SPRING_PARAMETERS)                                              \
    LAW(tendon_spring, TENDON_SPRING, TENDON_SPRING_PARAMETERS)                                        \
    LAW(winch, WINCH, WINCH_PARAMETERS)                                                                \
    LAW(winch_position, WINCH_POSITION, WINCH_POSITION_PARAMETERS)                                     \
    LAW(heavy_cable, HEAVY_CABLE, HEAVY_CABLE_PARAMETERS)

#define LAW_KIND(kind, law, parameters) KIND_##law,
enum { LAWS(LAW_KIND) LAW_KINDS };
#undef LAW_KIND

#endif
