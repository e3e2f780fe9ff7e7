/* The robot blob: one flat, read-only block of memory with all numbers of a robot.

   Only this file defines the order of the fields. Python reads the order from the library as text
   (core_layout), so that both sides agree by construction. Every blob contains the hash of this text.

   A blob consists of a header and the fields in order. Each field is padded to 8 bytes, and the blob begins
   at a multiple of 8 bytes. In a blob of single precision, reals have 4 bytes; the first word of the header
   specifies the precision. Frames are the moving frames of the tree, parents first; frame -1 is the world.
   Links that a fixed joint connects share a frame. Each frame has a different variable. The first variables
   are the degrees of freedom q. Further variables are sums of functions of earlier variables. Without
   further variables each degree of freedom has one frame. */
#ifndef CARDSFLOW_LAYOUT_H
#define CARDSFLOW_LAYOUT_H

#include "../numbers/real.h"

#include <stdint.h>

#define BLOB_MAGIC_DOUBLE 0x45524f43u /* "CORE" */
#define BLOB_MAGIC_FLOAT 0x66524f43u  /* "CORf" */
#define BLOB_MAGIC PRECISE(BLOB_MAGIC_DOUBLE, BLOB_MAGIC_FLOAT)
#define BLOB_VERSION 1u

/* COUNT(name, maximum) */
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

/* FIELD(element type, name, elements per item, count that specifies the number of items)

     parent           frame that this one is fixed to at q = 0, or -1
     motion           enum motion: type of the joint motion
     coordinate       variable of the joint motion
     offset_rotation  the frame at q = 0 in the parent frame, row by row
     offset_position  origin of the frame in the parent frame, in [m]
     axis             axis of the motion: unit vector in the frame
     mass             mass of the bodies fixed to the frame, in [kg]; may be 0
     mass_centre      mass centre of these bodies, in the frame, in [m]
     inertia          inertia of these bodies about their mass centre, along the axes of the frame: xx, yy, zz,
                      xy, xz, yz, in [kg m2]
     damping          damping of a variable
     stiffness, rest  spring of a variable x: torque -stiffness (x - rest)
     armature         inertia of a variable in addition to the bodies
     variable_terms   number of functions in the sum of a variable; 0 for q
     term_source      argument of a function: a variable before the variable of the sum
     term_kind        enum term
     term_size        number of coefficients or pieces
     term_number      c0, c1, ... of a polynomial; x_k, a, b, c, d of each piece a + D (b + D (c + D d)),
                      D = x - x_k, valid for x >= x_k; the first piece is also valid below
     limit_variable   variable of a limit force, which acts outside of a range
     limit_numbers    low, high, stiffness below and above, damping, transition,
                      inertia of a soft limit or 0, see limits.c
     friction         maximum Coulomb friction of a coordinate, by its index in q
     lower, upper     limits of a coordinate, by its index in q; infinite without a limit
     gravity          gravity in the world, in [m/s2]
     muscle_points    number of via points of a muscle, at least 2
     muscle_bends     number of bends of a cable with friction, see bends.h; 0 without friction. The first via
                      point is the driven end
     bend_friction    friction coefficient mu >= 0 of a bend, in the order of the path, muscle after muscle
     presliding       sliding distance over which cable friction reverses, in [m]
     point_frame      frame that a via point is fixed to, or -1
     point_position   position in that frame, in [m]; muscle after muscle
     closure_kind     enum closure: an equation of a loop joint
     closure_frame    frames of the two sides A and B, or -1
     closure_along    u, unit vector in A
     closure_at       of a point: p_A; of a direction: the direction in A along which v must point, or 0 if v may
                      point in either sense
     closure_other    in B: the point p_B, or the direction v, a unit vector
     task_kind        enum task: point or orientation
     task_frame       frame that a task is fixed to, or -1
     task_position    position of a task point in that frame, in [m]
     task_rotation    orientation of a task link in that frame, row by row
     law_kind         index of the muscle law in core_laws()
     law_parameter    parameters of the muscle laws, muscle after muscle, in SI units
     surface_kind     enum surface
     surface_frame    frame that a surface is fixed to, or -1
     surface_centre   centre in that frame, in [m]
     surface_axis     z axis in that frame: unit vector
     surface_across   x axis in that frame: unit vector
     surface_radius   radius in [m]; of an ellipsoid: half axis along x
     surface_half_axes  half axes of an ellipsoid along y and z, in [m]; 0 for other surfaces
     surface_half     half the length of a cylinder, in [m]; 0 if the cylinder is infinite
     wrap_point       index of the via point before the wrap, in order; never the last point of a muscle
     wrap_surface     surface of the wrap
     wrap_side        sense of turning about the z axis: 1, -1, or 0 for the shorter way; 2 inside the surface
     wrap_turns       number of additional whole turns
     wrap_last        via point before the last allowed segment; equal to wrap_point except with OpenSim's rules
     wrap_rule        enum rule
     wrap_guide       guide that specifies the side, or -1
     guide_frame      frame that a guide is fixed to, or -1
     guide_vector     vector in that frame: a point for MuJoCo's rules, the quadrant's direction for OpenSim's
     condition_point  index of a conditional via point, in order, at most one condition per point
     condition_coordinate  variable of the condition
     condition_low, condition_high  range of the variable in which the point is active
     condition_smoothing   transition width outside of the range; 0: the point switches
     move_point       index of a via point that moves on its link, in order
     move_coordinate  variable that moves the point
     move_axis        axis of the motion in the frame of the point
     move_low, move_high   range of the variable outside of which the point does not move
     move_first, move_pieces  first piece and number of pieces of the function
     piece            x0, a, b, c, d of a piece a + D (b + D (c + D d)), D = x - x0, valid for x >= x0; the first
                      piece is also valid below
     branch_point     index of the first via point of a branch, in order
     branch_divisor   divisor of the length of the branch
     path_term_muscle muscle with a length term that is proportional to a variable, in order
     path_term_coordinate, path_term_factor   variable of the term, and the derivative
     pulley_point     first via point of a muscle with a pulley, in order
     pulley_direction direction of the incoming cable: unit vector in the frame of that point
     pulley_radius    radius in [m] */
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
    FIELD(real, limit_numbers, 7, limit_forces)                                                        \
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

/* Maximum number of surfaces in one segment: the working memory of a sequence is on the stack. */
#define MAX_SEQUENCE 8

/* Rules of a wrap: the taut cable, MuJoCo's rules or OpenSim's rules. */
enum rule { RULE_TAUT = 0, RULE_MUJOCO = 1, RULE_OPENSIM = 2, RULES };

/* Value of wrap_side for a cable that runs inside of the surface and touches it from within. */
#define WRAP_INSIDE 2

enum surface { SURFACE_SPHERE = 0, SURFACE_CYLINDER = 1, SURFACE_ELLIPSOID = 2, SURFACES };

/* Maximum ratio of two half axes of an ellipsoid. */
#define MAX_HALF_AXIS 10

/* Functions of one variable. */
enum term { TERM_POLYNOMIAL = 0, TERM_PIECES = 1, TERMS };

/* Number of values of a piece, and of a limit force. */
#define PIECE_NUMBERS 5
#define LIMIT_NUMBERS 7

enum motion { ROTATION = 0, TRANSLATION = 1, MOTIONS };

/* Equations of loop joints: u.(p_B - p_A) = 0, or u.v = 0; see loops/closures.c. */
enum closure { CLOSURE_POINT = 0, CLOSURE_DIRECTION = 1, CLOSURES };

/* A task has three coordinates: x, y, z of a point, or the angles alpha, beta, gamma of R = Rx(alpha)
   Ry(beta) Rz(gamma), which are singular at beta = +-pi/2. */
enum task { TASK_POINT = 0, TASK_ORIENTATION = 1, TASKS };

#define BLOB_COUNT_MEMBER(name, largest) int32_t name;
typedef struct {
    BLOB_COUNTS(BLOB_COUNT_MEMBER)
} blob_counts;
#undef BLOB_COUNT_MEMBER

typedef struct {
    uint32_t magic, version, layout_hash, reserved;
    uint64_t size; /* size of the whole blob, in bytes */
    blob_counts counts;
} blob_header;

/* A checked blob: pointers into the memory of the caller. */
#define BLOB_FIELD_MEMBER(type, name, per_item, count) const type *name;
typedef struct {
    blob_counts counts;
    int32_t law_states, law_constants; /* numbers of all muscles; the states include those of bends */
    int32_t stretches;                 /* number of bends of cables that stretch along their path */
    BLOB_FIELDS(BLOB_FIELD_MEMBER)
} blob_view;
#undef BLOB_FIELD_MEMBER

#endif
