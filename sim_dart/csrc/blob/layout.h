/* The robot blob: one flat, read-only piece of memory that holds a robot's numbers.

   This is the only place that states the order of its fields. Python asks the library for it as text
   (core_layout), so that both ends agree by construction; the hash of that text stands in every blob.

   A blob is a header, then the fields one after the other, each padded to 8 bytes; it begins at a multiple
   of 8 bytes. All this holds for numbers of single precision too, where reals have 4 bytes, and the first
   word of the header tells such a blob from one of doubles. Frames are the
   moving frames of the tree, parents first; frame -1 is the world. Links that a fixed joint connects share
   a frame. Each frame is driven by a variable of its own. The first variables are the degrees of freedom q;
   those after them, if any, are sums of functions of earlier ones. Where there are none of these, there is a
   frame for each degree of freedom.                                                                   */
#ifndef CARDSFLOW_LAYOUT_H
#define CARDSFLOW_LAYOUT_H

#include "../numbers/real.h"

#include <stdint.h>

#define BLOB_MAGIC_DOUBLE 0x45524f43u /* "CORE" */
#define BLOB_MAGIC_FLOAT 0x66524f43u  /* "CORf" */
#define BLOB_MAGIC PRECISE(BLOB_MAGIC_DOUBLE, BLOB_MAGIC_FLOAT)
#define BLOB_VERSION 1u

/* COUNT(name, largest value) */
#define BLOB_COUNTS(COUNT)                                                                             \
    COUNT(dofs, 4096)                                                                                  \
    COUNT(frames, 4096)                                                                                \
    COUNT(variables, 6144)                                                                             \
    COUNT(terms, 65536)                                                                                \
    COUNT(term_numbers, 4194304)                                                                       \
    COUNT(limit_forces, 6144)                                                                          \
    COUNT(muscles, 65536)                                                                              \
    COUNT(points, 1048576)                                                                             \
    COUNT(closures, 4096)                                                                              \
    COUNT(tasks, 4096)                                                                                 \
    COUNT(law_parameters, 4194304)                                                                     \
    COUNT(surfaces, 65536)                                                                             \
    COUNT(wraps, 1048576)                                                                              \
    COUNT(pulleys, 65536)                                                                              \
    COUNT(bends, 2097152)                                                                              \
    COUNT(guides, 1048576)                                                                             \
    COUNT(conditions, 1048576)                                                                         \
    COUNT(moves, 1048576)                                                                              \
    COUNT(pieces, 4194304)                                                                             \
    COUNT(branches, 1048576)                                                                           \
    COUNT(path_terms, 1048576)                                                                         \
    COUNT(robots, 1)

/* FIELD(element type, name, elements an item, count that says how many items)
     parent           frame that this one is fixed to at q = 0, or -1
     motion           enum motion: what moves it
     coordinate       variable that drives it
     offset_rotation  the frame at q = 0 in the parent frame, row by row
     offset_position  its origin, in [m]
     axis             of the motion: unit vector in the frame
     mass             of the bodies that the frame carries, in [kg]; may be 0
     mass_centre      of these bodies, in the frame, in [m]
     inertia          of these bodies about their mass centre, along the frame's axes: xx, yy, zz, xy,
                      xz, yz, in [kg m2]
     damping          of a variable
     stiffness, rest  spring of a variable x: torque -stiffness (x - rest)
     armature         of a variable: inertia besides the bodies'
     variable_terms   how many functions a variable is the sum of; none of those that are q
     term_source      the variable that a function is of, before the one that it is part of
     term_kind        enum term
     term_size        how many coefficients, or pieces
     term_number      c0, c1, ... of a polynomial; x_k, a, b, c, d of each piece a + D (b + D (c + D d)),
                      D = x - x_k, which holds from x_k on, the first one before the second
     limit_variable   that a force beyond a range acts on
     limit_numbers    low, high, stiffness below and above, damping, transition
     friction         Coulomb's, of a coordinate, by its index in q: largest force or torque
     lower, upper     limits of a coordinate, by its index in q; infinite if there is none
     gravity          in the world, in [m/s2]
     muscle_points    via points of a muscle, at least 2
     muscle_bends     bends of a muscle's cable with friction, see bends.h; 0 without. Its first via point is
                      the driven end
     bend_friction    mu there, from 0 on, along the path, muscle after muscle
     presliding       way over which that friction turns round, in [m]
     point_frame      frame that a via point is fixed to, or -1
     point_position   in that frame, in [m]; muscle after muscle
     closure_kind     enum closure: an equation of a loop joint
     closure_frame    the frames of its two sides A and B, or -1
     closure_along    u, unit vector in A
     closure_at       of a point p_A; of a direction the one in A that v is to point along, or 0 for either way
     closure_other    in B: of a point p_B, of a direction v, a unit vector
     task_kind        enum task: what of the frame counts
     task_frame       frame that a task is fixed to, or -1
     task_position    of a point in that frame, in [m]
     task_rotation    of a link in that frame, row by row
     law_kind         which muscle law: the how many-th law of core_laws()
     law_parameter    of every muscle's law, muscle after muscle, in SI units
     surface_kind     enum surface
     surface_frame    frame that a surface is fixed to, or -1
     surface_centre   in that frame, in [m]
     surface_axis     its z axis there: unit vector
     surface_across   its x axis there: unit vector
     surface_radius   in [m]; of an ellipsoid its half axis along x
     surface_half_axes  of an ellipsoid those along y and z, in [m]; 0 of others
     surface_half     half the length of a cylinder, in [m]; 0 if it has no ends
     wrap_point       via point before it, one of all, in order; never a muscle's last
     wrap_surface     what it goes over
     wrap_side        sense of turning about the z axis: 1, -1, or 0 for the shorter way; 2 inside it
     wrap_turns       whole turns besides
     wrap_last        via point before the last segment that it may be in; wrap_point but for OpenSim's rules
     wrap_rule        enum rule
     wrap_guide       guide that says on which side, or -1
     guide_frame      frame that a guide is fixed to, or -1
     guide_vector     in it: of MuJoCo's rules a point, of OpenSim's the quadrant's direction
     condition_point  via point that is in use at times, one of all, in order, one each
     condition_coordinate  by which variable it is
     condition_low, condition_high  from where to where
     condition_smoothing   over how far its share changes outside of that; 0: at once
     move_point       via point that moves on its link, one of all, in order
     move_coordinate  by which variable it does
     move_axis        in the point's frame, along which
     move_low, move_high   beyond which it stands still
     move_first, move_pieces  the pieces of its function
     piece            of a function: x0, a, b, c, d of a + D (b + D (c + D d)), D = x - x0, from x0 on; the
                      first one from anywhere
     branch_point     via point that a branch begins with, one of all, in order
     branch_divisor   of its length
     path_term_muscle muscle whose length has a part in proportion to a variable, in order
     path_term_coordinate, path_term_factor   which one, and the derivative
     pulley_point     first via point of a muscle, one of all, in order
     pulley_direction in which the cable comes on: unit vector in that point's frame
     pulley_radius    in [m]                                                                           */
#define BLOB_FIELDS(FIELD)                                                                             \
    FIELD(int32_t, parent, 1, frames)                                                                  \
    FIELD(int32_t, motion, 1, frames)                                                                  \
    FIELD(int32_t, coordinate, 1, frames)                                                              \
    FIELD(real, offset_rotation, 9, frames)                                                            \
    FIELD(real, offset_position, 3, frames)                                                            \
    FIELD(real, axis, 3, frames)                                                                       \
    FIELD(real, mass, 1, frames)                                                                       \
    FIELD(real, mass_centre, 3, frames)                                                                \
    FIELD(real, inertia, 6, frames)                                                                    \
    FIELD(real, damping, 1, variables)                                                                 \
    FIELD(real, armature, 1, variables)                                                                \
    FIELD(int32_t, variable_terms, 1, variables)                                                       \
    FIELD(int32_t, term_source, 1, terms)                                                              \
    FIELD(int32_t, term_kind, 1, terms)                                                                \
    FIELD(int32_t, term_size, 1, terms)                                                                \
    FIELD(real, term_number, 1, term_numbers)                                                          \
    FIELD(int32_t, limit_variable, 1, limit_forces)                                                    \
    FIELD(real, limit_numbers, 6, limit_forces)                                                        \
    FIELD(real, friction, 1, dofs)                                                                     \
    FIELD(real, stiffness, 1, variables)                                                               \
    FIELD(real, rest, 1, variables)                                                                    \
    FIELD(real, lower, 1, dofs)                                                                        \
    FIELD(real, upper, 1, dofs)                                                                        \
    FIELD(real, gravity, 3, robots)                                                                    \
    FIELD(int32_t, muscle_points, 1, muscles)                                                          \
    FIELD(int32_t, muscle_bends, 1, muscles)                                                           \
    FIELD(real, bend_friction, 1, bends)                                                               \
    FIELD(real, presliding, 1, muscles)                                                                \
    FIELD(int32_t, point_frame, 1, points)                                                             \
    FIELD(real, point_position, 3, points)                                                             \
    FIELD(int32_t, closure_kind, 1, closures)                                                          \
    FIELD(int32_t, closure_frame, 2, closures)                                                         \
    FIELD(real, closure_along, 3, closures)                                                            \
    FIELD(real, closure_at, 3, closures)                                                               \
    FIELD(real, closure_other, 3, closures)                                                            \
    FIELD(int32_t, task_kind, 1, tasks)                                                                \
    FIELD(int32_t, task_frame, 1, tasks)                                                               \
    FIELD(real, task_position, 3, tasks)                                                               \
    FIELD(real, task_rotation, 9, tasks)                                                               \
    FIELD(int32_t, law_kind, 1, muscles)                                                               \
    FIELD(real, law_parameter, 1, law_parameters)                                                      \
    FIELD(int32_t, surface_kind, 1, surfaces)                                                          \
    FIELD(int32_t, surface_frame, 1, surfaces)                                                         \
    FIELD(real, surface_centre, 3, surfaces)                                                           \
    FIELD(real, surface_axis, 3, surfaces)                                                             \
    FIELD(real, surface_across, 3, surfaces)                                                           \
    FIELD(real, surface_radius, 1, surfaces)                                                           \
    FIELD(real, surface_half_axes, 2, surfaces)                                                        \
    FIELD(real, surface_half, 1, surfaces)                                                             \
    FIELD(int32_t, wrap_point, 1, wraps)                                                               \
    FIELD(int32_t, wrap_surface, 1, wraps)                                                             \
    FIELD(int32_t, wrap_side, 1, wraps)                                                                \
    FIELD(int32_t, wrap_turns, 1, wraps)                                                               \
    FIELD(int32_t, wrap_last, 1, wraps)                                                                \
    FIELD(int32_t, wrap_rule, 1, wraps)                                                                \
    FIELD(int32_t, wrap_guide, 1, wraps)                                                               \
    FIELD(int32_t, guide_frame, 1, guides)                                                             \
    FIELD(real, guide_vector, 3, guides)                                                               \
    FIELD(int32_t, condition_point, 1, conditions)                                                     \
    FIELD(int32_t, condition_coordinate, 1, conditions)                                                \
    FIELD(real, condition_low, 1, conditions)                                                          \
    FIELD(real, condition_high, 1, conditions)                                                         \
    FIELD(real, condition_smoothing, 1, conditions)                                                    \
    FIELD(int32_t, move_point, 1, moves)                                                               \
    FIELD(int32_t, move_coordinate, 1, moves)                                                          \
    FIELD(real, move_axis, 3, moves)                                                                   \
    FIELD(real, move_low, 1, moves)                                                                    \
    FIELD(real, move_high, 1, moves)                                                                   \
    FIELD(int32_t, move_first, 1, moves)                                                               \
    FIELD(int32_t, move_pieces, 1, moves)                                                              \
    FIELD(real, piece, 5, pieces)                                                                      \
    FIELD(int32_t, branch_point, 1, branches)                                                          \
    FIELD(real, branch_divisor, 1, branches)                                                           \
    FIELD(int32_t, path_term_muscle, 1, path_terms)                                                    \
    FIELD(int32_t, path_term_coordinate, 1, path_terms)                                                \
    FIELD(real, path_term_factor, 1, path_terms)                                                       \
    FIELD(int32_t, pulley_point, 1, pulleys)                                                           \
    FIELD(real, pulley_direction, 3, pulleys)                                                          \
    FIELD(real, pulley_radius, 1, pulleys)

/* The most surfaces in one segment: the working memory of a sequence lies on the stack. */
#define MAX_SEQUENCE 8

/* Whose rules a wrap goes by: ours, MuJoCo's, OpenSim's. */
enum rule { RULE_TAUT = 0, RULE_MUJOCO = 1, RULE_OPENSIM = 2, RULES };

/* A wrap_side: the cable is led through the surface, which it touches from within. */
#define WRAP_INSIDE 2

enum surface { SURFACE_SPHERE = 0, SURFACE_CYLINDER = 1, SURFACE_ELLIPSOID = 2, SURFACES };

/* How many times longer than another one a half axis of an ellipsoid may be. */
#define MAX_HALF_AXIS 10

/* Functions of one variable. */
enum term { TERM_POLYNOMIAL = 0, TERM_PIECES = 1, TERMS };

/* Numbers of a piece, and of a limit force. */
#define PIECE_NUMBERS 5
#define LIMIT_NUMBERS 6

enum motion { ROTATION = 0, TRANSLATION = 1, MOTIONS };

/* Equations of loop joints: u.(p_B - p_A) = 0, or u.v = 0; see loops/closures.c. */
enum closure { CLOSURE_POINT = 0, CLOSURE_DIRECTION = 1, CLOSURES };

/* Task coordinates are three a task: x, y, z of a point, or the angles alpha, beta, gamma of
   R = Rx(alpha) Ry(beta) Rz(gamma), which are singular at beta = +-pi/2.                              */
enum task { TASK_POINT = 0, TASK_ORIENTATION = 1, TASKS };

#define BLOB_COUNT_MEMBER(name, largest) int32_t name;
typedef struct {
    BLOB_COUNTS(BLOB_COUNT_MEMBER)
} blob_counts;
#undef BLOB_COUNT_MEMBER

typedef struct {
    uint32_t magic, version, layout_hash, reserved;
    uint64_t size; /* of the whole blob, in bytes */
    blob_counts counts;
} blob_header;

/* A validated blob: pointers into the caller's memory. */
#define BLOB_FIELD_MEMBER(type, name, per_item, count) const type *name;
typedef struct {
    blob_counts counts;
    int32_t law_states, law_constants; /* of all muscles together; the states with those of bends */
    int32_t stretches;                 /* bends of cables that stretch all along */
    BLOB_FIELDS(BLOB_FIELD_MEMBER)
} blob_view;
#undef BLOB_FIELD_MEMBER

#endif
