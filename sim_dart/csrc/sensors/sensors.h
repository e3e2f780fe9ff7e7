/* Sensors of a robot: lengths at the motors, tensions, torques, encoders, IMUs.

   A measurement is  r round((x + offset + noise g)/r), with the resolution r, if it is not 0, and g with a
   normal distribution, and is delayed by a number of measurements. g depends only on the seed, the number of
   the measurement and the channel, and is bit-identical on every platform. From the time `stuck` on a
   channel repeats its last value.

     lengths        l(q) - c f, with the compliances c and the tensions f
     gyroscope, accelerometer     angular velocity, and specific force with the mean qdd since the last measurement

   The sensors do not allocate memory, have no global state and no I/O. They need their own core handle.
   Every function of one handle must be called from one thread at a time. */
#ifndef CARDSFLOW_SENSORS_H
#define CARDSFLOW_SENSORS_H

#include "../core.h"

typedef struct sensors sensors;

/* Return the size of the working memory in bytes; 0 if there are too many sensors. imus: number of IMUs;
   delay: in measurements. */
CORE_API size_t sensors_size(const core *c, int32_t imus, int32_t delay);

/* Create a handle in `memory`, which is 8-byte aligned and has sensors_size bytes; this call sets it to
   zero. Neither core nor memory may be moved. imu_frame is the frame of each IMU in the blob. Return NULL if
   a frame does not exist. */
CORE_API sensors *sensors_open(core *c, int32_t imus, const int32_t *imu_frame, int32_t delay, void *memory);

/* Return an array by name, and its number of elements; NULL if the array does not exist. n coordinates, m
   muscles, i IMUs; channels: lengths m, tensions m, torques n, encoders n, gyroscopes 3 i, accelerometers 3
   i.

   Ground truth, to be written before a measurement
     q, qd          n
     tensions       m, in [N]
     torques        n

   Settings
     noise, resolution, offset    of each channel, in its unit
     stuck          of each channel, in [s]; infinite: never
     compliance     m, in [m/N]
     seed           1
     imu_rotation   axes of an IMU in its frame, row by row, 9 i
     imu_position   in its frame, 3 i, in [m]

   Results
     readings       measurement of each channel

   Internal state, to be saved and restored
     remembered */
CORE_API real *sensors_array(sensors *s, const char *name, size_t *length);

/* Reset to the state before the first measurement. */
CORE_API void sensors_reset(sensors *s);

/* Measure, at the time h after the last measurement. Return 0, or 1 + the coordinate that is not finite. */
CORE_API int sensors_read(sensors *s, real h);

#endif
