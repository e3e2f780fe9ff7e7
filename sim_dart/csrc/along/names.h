/* Compiling the core for numbers that carry a derivative along: how, and what its functions are called
   then. Every file here that does begins with this, and ends with end.h.                               */
#ifndef CARDSFLOW_ALONG_NAMES_H
#define CARDSFLOW_ALONG_NAMES_H

#define CARDSFLOW_ALONG

/* Products and quotients of the schoolbook: here are no infinities to be careful of. And small code: the
   processor is busy with the arithmetic.                                                               */
#if defined(__clang__)
#pragma STDC CX_LIMITED_RANGE ON
#pragma clang attribute push(__attribute__((minsize)), apply_to = function)
#elif defined(__GNUC__)
#pragma GCC optimize("cx-limited-range", "Os")
#endif

/* The quick arc tangent's polynomials are for plain numbers. */
#define CARDSFLOW_ARC_H
#define quick_arc_tangent arc_tangent
#define upper_arc_tangent arc_tangent

#define LAW_DE_GROOTE along_LAW_DE_GROOTE
#define LAW_ELASTIC_CABLE along_LAW_ELASTIC_CABLE
#define LAW_IDEAL along_LAW_IDEAL
#define LAW_LIGAMENT along_LAW_LIGAMENT
#define LAW_MCKIBBEN along_LAW_MCKIBBEN
#define LAW_MILLARD along_LAW_MILLARD
#define LAW_MOTOR along_LAW_MOTOR
#define LAW_SPRING along_LAW_SPRING
#define LAW_THELEN along_LAW_THELEN
#define activation_after along_activation_after
#define activations_add along_activations_add
#define activations_finish along_activations_finish
#define activation_rate along_activation_rate
#define arc_cosine along_arc_cosine
#define arc_sine along_arc_sine
#define arc_tangent along_arc_tangent
#define bezier_is_sound along_bezier_is_sound
#define bezier_prepare along_bezier_prepare
#define bezier_value along_bezier_value
#define bezier_values along_bezier_values
#define bracketed_root along_bracketed_root
#define core_accelerate along_core_accelerate
#define core_advance along_core_advance
#define core_count_turns along_core_count_turns
#define core_curve along_core_curve
#define core_drive along_core_drive
#define core_energies along_core_energies
#define core_invert along_core_invert
#define core_law_rates along_core_law_rates
#define core_move along_core_move
#define core_move_checked along_core_move_checked
#define core_pull along_core_pull
#define core_push along_core_push
#define core_runge_kutta along_core_runge_kutta
#define core_rates along_core_rates
#define core_reach along_core_reach
#define core_start along_core_start
#define core_step along_core_step
#define core_task_bias along_core_task_bias
#define core_task_jacobian along_core_task_jacobian
#define core_trace along_core_trace
#define cosine along_cosine
#define dynamics_carry along_dynamics_carry
#define dynamics_factor along_dynamics_factor
#define dynamics_inertias along_dynamics_inertias
#define dynamics_links along_dynamics_links
#define dynamics_respond along_dynamics_respond
#define dynamics_velocities along_dynamics_velocities
#define exponential along_exponential
#define exponential_less_one along_exponential_less_one
#define exponential_of_four along_exponential_of_four
#define friction_keep along_friction_keep
#define hill_advance along_hill_advance
#define hill_curve_by_name along_hill_curve_by_name
#define hill_elastic_tension along_hill_elastic_tension
#define hill_prepare along_hill_prepare
#define hill_rates along_hill_rates
#define hill_refusal along_hill_refusal
#define hill_start along_hill_start
#define hill_states along_hill_states
#define hyperbolic_tangent along_hyperbolic_tangent
#define laws_check along_laws_check
#define laws_prepare along_laws_prepare
#define limits_apply along_limits_apply
#define limits_keep along_limits_keep
#define limits_respond along_limits_respond
#define limits_solve along_limits_solve
#define logarithm along_logarithm
#define muscles_are_sound along_muscles_are_sound
#define muscles_pull along_muscles_pull
#define paths_move along_paths_move
#define paths_prepare along_paths_prepare
#define pulley_off along_pulley_off
#define pushes_add along_pushes_add
#define sequence_solve along_sequence_solve
#define sine along_sine
#define sine_cosine along_sine_cosine
#define tasks_move along_tasks_move
#define tree_direction along_tree_direction
#define tree_move along_tree_move
#define tree_prepare along_tree_prepare
#define wrap_inside_is_clear along_wrap_inside_is_clear
#define wrap_inside_over along_wrap_inside_over
#define wrap_inside_pull along_wrap_inside_pull
#define wrap_is_clear along_wrap_is_clear
#define wrap_lanes_fill along_wrap_lanes_fill
#define wrap_lanes_prepare along_wrap_lanes_prepare
#define wrap_over along_wrap_over
#define wrap_pull along_wrap_pull

#endif
