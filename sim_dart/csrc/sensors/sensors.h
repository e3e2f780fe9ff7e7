/* What sensors read of a robot: lengths at the motors, tensions, torques, encoders, inertial units.

   A reading is  r round((x + offset + noise g)/r), with the resolution r if there is one and g of a normal
   distribution, and comes whole readings late. g follows from the seed, the number of the reading and the
   channel alone, by the same bits everywhere; from the time `stuck` on a channel repeats itself.

     lengths        l(q) - c f, with the compliances c and the tensions f
     gyroscope, accelerometer     angular velocity, and specific force with the mean qdd since the last reading

   No allocation, no global state, no I/O. The core handle is the sensors' own. Every function of one handle must
   be called from one thread at a time.                                                                     */
#ifndef CARDSFLOW_SENSORS_H
#define CARDSFLOW_SENSORS_H

#include "../core.h"

typedef struct sensors sensors;

/* Bytes of working memory; 0 if there are too many. imus: inertial units; delay: in readings. */
CORE_API size_t sensors_size(const core *c, int32_t imus, int32_t delay);

/* A handle in `memory`, 8-byte aligned and of sensors_size bytes, zeroed by this call; both must not be moved.
   imu_frame says which frame of the blob each unit is on. NULL if a frame does not exist.               */
CORE_API sensors *sensors_open(core *c, int32_t imus, const int32_t *imu_frame, int32_t delay, void *memory);

/* An array by name, and its number of elements; NULL if there is no such array. n coordinates, m muscles, i units;
   channels: lengths m, tensions m, torques n, encoders n, gyroscopes 3 i, accelerometers 3 i.
   The truth, to be written before a reading
     q, qd          n
     tensions       m, in [N]
     torques        n
   Settings
     noise, resolution, offset    of each channel, in its unit
     stuck          of each channel, in [s]; infinite: never
     compliance     m, in [m/N]
     seed           1
     imu_rotation   row by row, of a unit's axes in its frame, 9 i
     imu_position   in its frame, 3 i, in [m]
   Results
     readings       of each channel
   Everything that they remember
     remembered                                                                                            */
CORE_API real *sensors_array(sensors *s, const char *name, size_t *length);

/* Back to the first reading. */
CORE_API void sensors_reset(sensors *s);

/* Read, h after the last reading. 0, or 1 + the coordinate that is not a number. */
CORE_API int sensors_read(sensors *s, real h);

#endif
