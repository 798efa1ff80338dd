/* The controllers of hydrocrane for C programs: no heap, no operating system, double precision.
 *
 * SI units: s, m, rad, Pa (gauge). Joints and cylinders have the order of the machine file. No function but hydrocrane_text may run
 * while another one works on the same memory. */
#ifndef HYDROCRANE_CONTROLLER_H
#define HYDROCRANE_CONTROLLER_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* What a function answers; hydrocrane_text gives it in words. */
typedef int32_t hydrocrane_status;
enum {
    HYDROCRANE_OK = 0,
    HYDROCRANE_NULL_POINTER = 1,
    /* Memory or numbers do not lie at a multiple of 8 bytes. */
    HYDROCRANE_MISALIGNED = 2,
    HYDROCRANE_TOO_LITTLE_MEMORY = 3,
    /* The bytes are no parameters; are damaged; belong to another version of the library; have a number of joints for which the
     * library was not compiled. */
    HYDROCRANE_NO_PARAMETERS = 4,
    HYDROCRANE_DAMAGED = 5,
    HYDROCRANE_OTHER_VERSION = 6,
    HYDROCRANE_OTHER_JOINTS = 7,
    /* There is no controller in this memory. */
    HYDROCRANE_NOT_CREATED = 8,
    /* Time, a joint coordinate or a pressure that is NaN or infinite, or beyond 1e12. With a monitor of the sensors only the time:
     * such a reading is then a failed sensor. */
    HYDROCRANE_BAD_MEASUREMENT = 9,
    /* A deflection beyond -1 to 1 or NaN, or another number of axes than the mode has. */
    HYDROCRANE_BAD_STICK = 10,
    /* This controller does not take sticks of this mode. */
    HYDROCRANE_WRONG_STICK = 11,
    HYDROCRANE_NO_COMMAND = 12,
    HYDROCRANE_NO_SET_POINT = 13,
    HYDROCRANE_TOO_FEW_REVOLUTE = 14,
    /* `spools` is another number than that of the cylinders. */
    HYDROCRANE_OTHER_SPOOLS = 15
};

/* A sample of the sensors. A reading that is missing is NaN. */
typedef struct {
    /* s; grows from sample to sample. */
    double t;
    /* One coordinate per joint, rad or m. */
    const double *q;
    /* Two pressures per cylinder, piston side then rod side, Pa. */
    const double *p;
} hydrocrane_sample;

/* What the axes of the stick move. */
enum {
    /* Two axes: the tip forward and up (tip, heinze-pid); of a crane that slews a third one: across, with a growing angle. */
    HYDROCRANE_TIP = 0,
    /* One axis per cylinder (lever). */
    HYDROCRANE_LEVERS = 1,
    /* One axis per cylinder, while one joint holds the height of the tip (tip). */
    HYDROCRANE_HEIGHT = 2
};

/* Makes a controller in `memory`: HYDROCRANE_MEMORY bytes at a multiple of 8, which stay in their place. */
hydrocrane_status hydrocrane_create(void *memory, size_t bytes, const uint8_t *parameters, size_t length);

/* Time between two samples, s; zero without a controller. */
double hydrocrane_period(const void *memory);

/* Starts anew from a first sample. */
hydrocrane_status hydrocrane_reset(void *memory, const hydrocrane_sample *first);

/* Takes one sample and writes one spool command per cylinder, m, positive extends, into the `spools` numbers at `spool`. Unless the
 * answer is HYDROCRANE_OK, all of them are zero, whatever else is missing or wrong: the spools are to be centred. Sample and axes are
 * read before anything is written, so they may lie where the commands go. */
hydrocrane_status hydrocrane_step(void *memory, const hydrocrane_sample *now, int32_t mode, const double *axes, size_t count,
                                  double *spool, size_t spools);

/* Where the controller wants the tip, x and z, m; of a crane that slews with the slewing joint turned back to zero. */
hydrocrane_status hydrocrane_set_point(const void *memory, double place[2]);

/* What has happened since the last call: a sum of the bits below. Of the controllers only `tip` tells anything; the three bits
 * before the last are those of the monitor of the sensors. */
uint32_t hydrocrane_notices(void *memory);
enum {
    /* The tip stands though the stick is deflected: the load is too heavy for the supply pressure; the tip does not follow its
     * set-point; a keep-out region; a dead centre where closed valves could not hold a joint; limits of joints. */
    HYDROCRANE_STANDS_LOAD = 1 << 0,
    HYDROCRANE_STANDS_LAG = 1 << 1,
    HYDROCRANE_STANDS_REGION = 1 << 2,
    HYDROCRANE_STANDS_HOLDING = 1 << 3,
    HYDROCRANE_STANDS_RANGE = 1 << 4,
    /* The tip sinks at rest, because the supply pressure cannot hold it. */
    HYDROCRANE_SINKS = 1 << 5,
    /* Closed valves cannot hold a joint: it runs away. */
    HYDROCRANE_RUNS_AWAY = 1 << 6,
    /* A cylinder does not hold its place, though nothing measures its load. */
    HYDROCRANE_YIELDS = 1 << 7,
    /* Because of a suspect sensor the crane stops, or does not restart; its valves close and hold the load. */
    HYDROCRANE_SENSOR_STOPS = 1 << 8,
    /* A sensor failed for a moment, and control continued without it. */
    HYDROCRANE_SENSOR_BRIDGED = 1 << 9,
    /* All sensors read plausibly and the stick is released: the controller restarts. */
    HYDROCRANE_SENSORS_RESTART = 1 << 10,
    /* The crane swings on although the valves damp it, so they may act later than the machine file says: the gain of the
     * damping is halved. */
    HYDROCRANE_OSCILLATES = 1 << 11,
    /* The tip is farther off its path than a controller with the true model would let it be: flow, delay, oil or load differ from the
     * machine file. */
    HYDROCRANE_STRAYS = 1 << 12
};

/* The sensors that are suspect, a bit each, until they are trusted again; always zero without a monitor. Bit 3 j is the sensor of joint
 * j, the next two are the pressures of its cylinder, piston side then rod side; j counts from zero. */
uint32_t hydrocrane_suspects(const void *memory);

/* What is wrong with the sensor of one of these bits, by the number of the bit. */
int32_t hydrocrane_sensor_fault(const void *memory, uint32_t sensor);
enum {
    /* Nothing, or there is no such sensor. */
    HYDROCRANE_SENSOR_SOUND = 0,
    HYDROCRANE_SENSOR_NO_READING = 1,
    /* The machine cannot have this position or pressure. */
    HYDROCRANE_SENSOR_OUT_OF_RANGE = 2,
    /* From one sample to the next, which no other reading confirms. */
    HYDROCRANE_SENSOR_JUMPED = 3,
    /* It has not changed while the piston moved. */
    HYDROCRANE_SENSOR_FROZEN = 4,
    /* Both chambers read nothing, where oil carried a load the sample before. */
    HYDROCRANE_SENSOR_VANISHED = 5,
    /* It came in one sample with others that cannot be right. */
    HYDROCRANE_SENSOR_IN_BAD_SAMPLE = 6
};

/* A status in words; the text is constant. */
const char *hydrocrane_text(hydrocrane_status status);

/* YOUR PROGRAM MUST DEFINE THIS. The library calls it only where it finds a mistake of its own, on the thread that made the call; the
 * commands of the present step are zero by then. It closes the valves and must not return. */
void hydrocrane_stop(void);

#ifdef __cplusplus
}
#endif

#endif
