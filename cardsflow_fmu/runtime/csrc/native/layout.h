/* The settings of a model in native.bin: groups of variables, counts, and fields.
 *
 * Only this file defines their order. Python reads the order from the library as text (native_layout), so
 * that both sides agree by construction. Every file contains the hash of this text.
 *
 * Groups and counts come first, in order, as two uint32 each: the index of the first variable of a group, or
 * 0 for a count; and the number of variables. The fields follow, each padded to 8 bytes. */
#ifndef NATIVE_LAYOUT_H
#define NATIVE_LAYOUT_H

#include "../platform/text.h"

#include <stddef.h>
#include <stdint.h>

enum native_kind { NATIVE_PLANT, NATIVE_CONTROLLER, NATIVE_REFERENCE, NATIVE_SENSORS, NATIVE_ESTIMATOR, NATIVE_KINDS };

/* GROUP(name, number of variables: for n coordinates, m muscles, a actuators, which are the muscles and then
 *       the motors of joints, r rows of the reference, k tasks; or ANY)
 * FIELD(element type, name, elements per item, group or count that specifies the number of items)
 *     load_rows         row of each load in the list of all rows of all tasks
 *     task_rows         row of each task coordinate in this list
 *     commanded         muscle of each command
 *     motors            coordinate of each torque
 *     modelled          muscle of each tension
 *     rubbing           muscle of each tension at the far end of a cable with friction
 *     state_order       index of each state among the states of all muscles
 *     external_frame    frame of each point of external wrenches, those of loads first; -1 for the world
 *     external_point    position in that frame, in [m]
 *     substeps          steps of the integrator per step of the plant
 *     integrator        0 semi-implicit Euler, 1 Runge-Kutta
 *     tension_scale     factor on the tension of each muscle
 *     break_time        time at which the cable of each muscle breaks, in [s]; infinite: never
 *     fixed_energy      potential energy of fixed bodies, in [J]
 *     nominals          nominal value of each state, in model exchange: those of q, qd, states and work
 *     limited           coordinate of each event indicator, times 2; plus 1 for the upper limit */
#define PLANT_GROUPS(GROUP)                                                                                   \
    GROUP(commands, ANY)                                                                                      \
    GROUP(torques, ANY)                                                                                       \
    GROUP(loads, ANY)                                                                                         \
    GROUP(wrenches, ANY)                                                                                      \
    GROUP(q, n)                                                                                               \
    GROUP(qd, n)                                                                                              \
    GROUP(lengths, m)                                                                                         \
    GROUP(tasks, ANY)                                                                                         \
    GROUP(tensions, ANY)                                                                                      \
    GROUP(far_tensions, ANY)                                                                                  \
    GROUP(states, ANY)                                                                                        \
    GROUP(energies, ANY)                                                                                      \
    GROUP(q_start, n)                                                                                         \
    GROUP(qd_start, n)                                                                                        \
    GROUP(step, ANY)                                                                                          \
    GROUP(worker_timeout, ANY)                                                                                \
    GROUP(derivatives, ANY)                                                                                   \
    GROUP(indicators, ANY)
#define PLANT_COUNTS(COUNT) COUNT(external_points) COUNT(models)
#define PLANT_FIELDS(FIELD)                                                                                   \
    FIELD(uint32_t, load_rows, 1, loads)                                                                      \
    FIELD(uint32_t, task_rows, 1, tasks)                                                                      \
    FIELD(uint32_t, commanded, 1, commands)                                                                   \
    FIELD(uint32_t, motors, 1, torques)                                                                       \
    FIELD(uint32_t, modelled, 1, tensions)                                                                    \
    FIELD(uint32_t, rubbing, 1, far_tensions)                                                                 \
    FIELD(uint32_t, state_order, 1, states)                                                                   \
    FIELD(int32_t, external_frame, 1, external_points)                                                        \
    FIELD(double, external_point, 3, external_points)                                                         \
    FIELD(uint32_t, substeps, 1, models)                                                                      \
    FIELD(uint32_t, integrator, 1, models)                                                                    \
    FIELD(double, tension_scale, 1, lengths)                                                                  \
    FIELD(double, break_time, 1, lengths)                                                                     \
    FIELD(double, fixed_energy, 1, models)                                                                    \
    FIELD(double, nominals, 1, derivatives)                                                                   \
    FIELD(uint32_t, limited, 1, indicators)

/* Fields of the parts of a reference:
 *     part_begin, part_duration    of each part, in [s]
 *     part_kind, part_segments, part_powers, part_data   of each part: reference_part in
 *                       controllers/csrc/references/references.h */
#define PART_FIELDS(FIELD)                                                                                    \
    FIELD(double, part_begin, 1, parts)                                                                       \
    FIELD(double, part_duration, 1, parts)                                                                    \
    FIELD(uint32_t, part_kind, 1, parts)                                                                      \
    FIELD(uint32_t, part_segments, 1, parts)                                                                  \
    FIELD(uint32_t, part_powers, 1, parts)                                                                    \
    FIELD(double, part_data, 1, part_numbers)

/* The report: number of actuators at a bound, computation time of the tick, infeasible, not converged; in
 * operational space limits dropped; with model predictive control fallback, iterations and late.
 *     is_angle          whether each task coordinate is an angle
 *     muscle_horizon    in [s], 0 for late_periods periods; see muscles.h
 *     start_forces      tensions before the first tick, for muscles with laws; start_commands: their commands
 *     observer          bandwidth in [rad/s]
 *     ramp_down, ramp_in   ramps of the commands when the state is lost and returns, in [s]; q_start: start pose
 *     dependent         whether each coordinate depends on the others, due to loops
 *     motion_begin, motion_values   rows along an optimal motion; see controllers/csrc/laws/held_motion.h
 *     motion_actuator   actuator of each control; motion_low, motion_high: its bounds, for commands
 *     motion_state      input of each state of muscles in the rows
 *     motion_use        0 without a motion; 1 for its forces as the pretension; 2 for feedback by forces, 3 by
 *                       commands of muscle laws
 *     nodes             intervals of model predictive control, or 0; see controllers/csrc/mpc/mpc.h
 *     plan_steps        Runge-Kutta steps in each of these intervals
 *     plan_robot        robot blob for its motions: ideal cables, joints without limits
 *     array_names       names of arrays of the loop or of its law, zero-terminated; see control_loop.h. Those of
 *                       model predictive control begin with "mpc."
 *     array_values      the values of these arrays, in the same order
 *     policy            numbers of a policy instead of the law; see controller/policy/policy.h
 *     bounded           muscle of each bound; full_bounds: bounds of muscles without faults, in [N]
 *     reaction_begins, reaction_speeds   table of a reaction, with a row per bound; see
 *                       controllers/csrc/reaction/reaction.h */
#define CONTROLLER_GROUPS(GROUP)                                                                              \
    GROUP(q, n)                                                                                               \
    GROUP(qd, n)                                                                                              \
    GROUP(reference, 3 * r)                                                                                   \
    GROUP(loads, ANY)                                                                                         \
    GROUP(states, ANY)                                                                                        \
    GROUP(estimated_loads, ANY)                                                                               \
    GROUP(valid, ANY)                                                                                         \
    GROUP(bounds, ANY)                                                                                        \
    GROUP(reached, ANY)                                                                                       \
    GROUP(reaction, ANY)                                                                                      \
    GROUP(forces, a)                                                                                          \
    GROUP(commands, ANY)                                                                                      \
    GROUP(slack, r)                                                                                           \
    GROUP(report, ANY)                                                                                        \
    GROUP(kp, r)                                                                                              \
    GROUP(kd, r)                                                                                              \
    GROUP(f_min, a)                                                                                           \
    GROUP(f_max, a)                                                                                           \
    GROUP(period, 1)
#define CONTROLLER_COUNTS(COUNT)                                                                              \
    COUNT(tasks) COUNT(modelled) COUNT(motors) COUNT(letters) COUNT(numbers) COUNT(models)                    \
    COUNT(plan_bytes) COUNT(parts) COUNT(part_numbers) COUNT(policy_numbers)                        \
    COUNT(motion_rows) COUNT(motion_numbers) COUNT(motion_controls) COUNT(motion_states)                      \
    COUNT(reaction_times) COUNT(reaction_numbers)
#define CONTROLLER_FIELDS(FIELD)                                                                              \
    FIELD(uint32_t, load_rows, 1, loads)                                                                      \
    FIELD(uint32_t, task_rows, 1, tasks)                                                                      \
    FIELD(uint32_t, motors, 1, motors)                                                                        \
    FIELD(uint32_t, is_angle, 1, tasks)                                                                       \
    FIELD(uint32_t, state_order, 1, states)                                                                   \
    FIELD(uint32_t, commanded, 1, commands)                                                                   \
    FIELD(double, muscle_horizon, 1, models)                                                                  \
    FIELD(double, late_periods, 1, models)                                                                    \
    FIELD(double, start_forces, 1, modelled)                                                                  \
    FIELD(double, start_commands, 1, modelled)                                                                \
    FIELD(double, observer, 1, models)                                                                        \
    FIELD(double, ramp_down, 1, models)                                                                       \
    FIELD(double, ramp_in, 1, models)                                                                         \
    FIELD(double, q_start, 1, q)                                                                              \
    FIELD(double, dependent, 1, q)                                                                            \
    FIELD(double, motion_begin, 1, motion_rows)                                                               \
    FIELD(double, motion_values, 1, motion_numbers)                                                           \
    FIELD(uint32_t, motion_actuator, 1, motion_controls)                                                      \
    FIELD(double, motion_low, 1, motion_controls)                                                             \
    FIELD(double, motion_high, 1, motion_controls)                                                            \
    FIELD(uint32_t, motion_state, 1, motion_states)                                                           \
    FIELD(uint32_t, motion_use, 1, models)                                                                    \
    FIELD(char, array_names, 1, letters)                                                                      \
    FIELD(double, array_values, 1, numbers)                                                                   \
    FIELD(double, policy, 1, policy_numbers)                                                                  \
    FIELD(uint32_t, nodes, 1, models)                                                                         \
    FIELD(uint32_t, plan_steps, 1, models)                                                                    \
    FIELD(char, plan_robot, 1, plan_bytes)                                                                    \
    FIELD(uint32_t, bounded, 1, bounds)                                                                       \
    FIELD(double, full_bounds, 1, bounds)                                                                     \
    FIELD(double, reaction_begins, 1, reaction_times)                                                         \
    FIELD(double, reaction_speeds, 1, reaction_numbers)                                                       \
    PART_FIELDS(FIELD)

/* Fields of a reference:
 *     load_forces       loads that act from load_begin to load_end, in [s]
 *     ramp              duration of changes of the speed, in [s] */
#define REFERENCE_GROUPS(GROUP) GROUP(reference, 3 * r) GROUP(loads, ANY) GROUP(speed, ANY) GROUP(reached, ANY)
#define REFERENCE_COUNTS(COUNT) COUNT(parts) COUNT(part_numbers) COUNT(models)
#define REFERENCE_FIELDS(FIELD)                                                                               \
    PART_FIELDS(FIELD)                                                                                        \
    FIELD(double, load_begin, 1, models)                                                                      \
    FIELD(double, load_end, 1, models)                                                                        \
    FIELD(double, load_forces, 1, loads)                                                                      \
    FIELD(double, ramp, 1, models)

/* Fields of sensors and estimators, with i IMUs:
 *     measured          muscle of each length and tension
 *     motors            coordinate of each torque
 *     encoded           coordinate of each encoder
 *     imu_frame         frame of each IMU
 *     delay             in measurements
 *     exact             whether the transition matrix is exact
 *     frames            of a horizon; 0 for the Kalman filter
 *     other fields      arrays of sensors.h and estimator.h, with the same channels and sizes */
#define READING_GROUPS(GROUP)                                                                                 \
    GROUP(lengths, ANY)                                                                                       \
    GROUP(measured_tensions, ANY)                                                                             \
    GROUP(measured_torques, ANY)                                                                              \
    GROUP(encoders, ANY)                                                                                      \
    GROUP(gyroscopes, 3 * i)                                                                                  \
    GROUP(accelerometers, 3 * i)
#define SENSORS_GROUPS(GROUP)                                                                                 \
    GROUP(q, n)                                                                                               \
    GROUP(qd, n)                                                                                              \
    GROUP(tensions, ANY)                                                                                      \
    GROUP(torques, ANY)                                                                                       \
    READING_GROUPS(GROUP)
#define SENSORS_COUNTS(COUNT) COUNT(units) COUNT(channels) COUNT(muscles) COUNT(models)
#define SENSORS_COPIED_FIELDS(FIELD)                                                                          \
    FIELD(double, noise, 1, channels)                                                                         \
    FIELD(double, resolution, 1, channels)                                                                    \
    FIELD(double, offset, 1, channels)                                                                        \
    FIELD(double, stuck, 1, channels)                                                                         \
    FIELD(double, compliance, 1, muscles)                                                                     \
    FIELD(double, seed, 1, models)                                                                            \
    FIELD(double, imu_rotation, 9, units)                                                                     \
    FIELD(double, imu_position, 3, units)
#define SENSORS_FIELDS(FIELD)                                                                                 \
    FIELD(uint32_t, measured, 1, lengths)                                                                     \
    FIELD(uint32_t, motors, 1, torques)                                                                       \
    FIELD(uint32_t, encoded, 1, encoders)                                                                     \
    FIELD(int32_t, imu_frame, 1, units)                                                                       \
    FIELD(uint32_t, delay, 1, models)                                                                         \
    SENSORS_COPIED_FIELDS(FIELD)

#define ESTIMATOR_GROUPS(GROUP)                                                                               \
    READING_GROUPS(GROUP)                                                                                     \
    GROUP(q, n)                                                                                               \
    GROUP(qd, n)                                                                                              \
    GROUP(w, n)                                                                                               \
    GROUP(sd, n)                                                                                              \
    GROUP(report, 4)                                                                                          \
    GROUP(q_start, n)                                                                                         \
    GROUP(offsets, ANY)                                                                                       \
    GROUP(found_offsets, ANY)                                                                                 \
    GROUP(offset_sd, ANY)                                                                                     \
    GROUP(step, 1)                                                                                            \
    GROUP(commands, ANY)                                                                                      \
    GROUP(muscle_faults, ANY)                                                                                 \
    GROUP(length_faults, ANY)                                                                                 \
    GROUP(tension_faults, ANY)                                                                                \
    GROUP(encoder_faults, ANY)                                                                                \
    GROUP(bounds, ANY)                                                                                        \
    GROUP(fault_report, ANY)
/* watched: muscles, joints: coordinates, monitors: 1; all 0 without detection of faults. tracked: muscles; 0 if offsets are
   constant */
#define ESTIMATOR_COUNTS(COUNT)                                                                               \
    COUNT(units) COUNT(muscles) COUNT(tracked) COUNT(numbers) COUNT(watched) COUNT(joints) COUNT(monitors)    \
    COUNT(models)
#define FAULT_FIELDS(FIELD)                                                                                   \
    FIELD(double, false_alarms_per_hour, 1, monitors)                                                         \
    FIELD(double, motor_lag, 1, monitors)                                                                     \
    FIELD(double, command_delay, 1, monitors)                                                                 \
    FIELD(double, start, 1, monitors)                                                                         \
    FIELD(double, force_rate, 1, watched)                                                                     \
    FIELD(double, length_error, 1, watched)                                                                   \
    FIELD(double, tension_noise, 1, watched)                                                                  \
    FIELD(double, tension_error, 1, watched)                                                                  \
    FIELD(double, f_max, 1, watched)                                                                          \
    FIELD(double, load_noise, 1, joints)                                                                      \
    FIELD(double, load_change, 1, joints)
#define ESTIMATOR_COPIED_FIELDS(FIELD)                                                                        \
    FIELD(double, length_noise, 1, muscles)                                                                   \
    FIELD(double, encoder_noise, 1, q)                                                                        \
    FIELD(double, gyroscope_noise, 1, units)                                                                  \
    FIELD(double, accelerometer_noise, 1, units)                                                              \
    FIELD(double, compliance, 1, muscles)                                                                     \
    FIELD(double, slack, 1, models)                                                                           \
    FIELD(double, gate, 1, models)                                                                            \
    FIELD(double, acceleration_noise, 1, q)                                                                   \
    FIELD(double, load_drift, 1, q)                                                                           \
    FIELD(double, bias_drift, 2, models)                                                                      \
    FIELD(double, offset_drift, 1, tracked)                                                                   \
    FIELD(double, start_offset_sd, 1, tracked)                                                                \
    FIELD(double, imu_rotation, 9, units)                                                                     \
    FIELD(double, imu_position, 3, units)                                                                     \
    FIELD(double, search, 1, models)                                                                          \
    FIELD(double, starts, 1, models)                                                                          \
    FIELD(double, start_low, 1, q)                                                                            \
    FIELD(double, start_high, 1, q)                                                                           \
    FIELD(double, start_sd, 1, numbers)                                                                       \
    FIELD(double, largest_sd, 1, q)                                                                           \
    FIELD(double, largest_innovation, 1, models)                                                              \
    FIELD(double, innovation_time, 1, models)
#define ESTIMATOR_HORIZON_FIELDS(FIELD)                                                                       \
    FIELD(double, huber, 1, models)                                                                           \
    FIELD(double, low, 1, q)                                                                                  \
    FIELD(double, high, 1, q)
#define ESTIMATOR_FIELDS(FIELD)                                                                               \
    FIELD(uint32_t, measured, 1, lengths)                                                                     \
    FIELD(uint32_t, motors, 1, measured_torques)                                                              \
    FIELD(uint32_t, encoded, 1, encoders)                                                                     \
    FIELD(int32_t, imu_frame, 1, units)                                                                       \
    FIELD(uint32_t, exact, 1, models)                                                                         \
    FIELD(uint32_t, delay, 1, models)                                                                         \
    FIELD(uint32_t, frames, 1, models)                                                                        \
    ESTIMATOR_HORIZON_FIELDS(FIELD)                                                                           \
    FIELD(uint32_t, has_tensions, 1, models)                                                                  \
    FAULT_FIELDS(FIELD)                                                                                       \
    ESTIMATOR_COPIED_FIELDS(FIELD)

struct native_group {
    uint32_t first, count;
};

/* Pointers into the memory of the file. */
#define NATIVE_GROUP_MEMBER(name, length) struct native_group name;
#define NATIVE_COUNT_MEMBER(name) struct native_group name;
#define NATIVE_FIELD_MEMBER(type, name, per_item, group) const type *name;
#define NATIVE_SETTINGS(kind, KIND)                                                                           \
    struct kind##_settings {                                                                                  \
        struct {                                                                                              \
            KIND##_GROUPS(NATIVE_GROUP_MEMBER) KIND##_COUNTS(NATIVE_COUNT_MEMBER)                             \
        } of;                                                                                                 \
        KIND##_FIELDS(NATIVE_FIELD_MEMBER)                                                                    \
    };                                                                                                        \
    /* Return 0, or nonzero if the size is not that of the settings. */                                       \
    int kind##_settings_read(struct kind##_settings *settings, const void *bytes, size_t size);
NATIVE_SETTINGS(plant, PLANT)
NATIVE_SETTINGS(controller, CONTROLLER)
NATIVE_SETTINGS(reference, REFERENCE)
NATIVE_SETTINGS(sensors, SENSORS)
NATIVE_SETTINGS(estimator, ESTIMATOR)

/* Return the layout of a kind of model, one line per group, count or field; and its hash. */
const char *native_layout(enum native_kind kind);
uint32_t native_layout_hash(enum native_kind kind);

#endif
