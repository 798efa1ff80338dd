/* Reads samples from standard input and prints commands; on a target the two are sensors and valves.
 *
 * A line is one sample: time, joint coordinates, pressures (two per cylinder), stick axes. The first one is also what the controller
 * starts from. A reading that is missing is `nan`. Printed are the status and the commands, as hexadecimal floating-point numbers: every
 * bit counts. What an operator should know goes to standard error. */
#include <stdio.h>
#include <stdlib.h>

#include "hydrocrane_controller.h"
#include "hydrocrane_parameters.h"

/* Static memory: there is no heap. The type makes it lie at a multiple of 8 bytes. */
static uint64_t memory[HYDROCRANE_MEMORY / 8];

void hydrocrane_stop(void) {
    /* Close the valves here. */
    abort();
}

static int read_numbers(double *numbers, int count) {
    for (int i = 0; i < count; i++) {
        if (scanf("%lf", &numbers[i]) != 1) {
            return 0;
        }
    }
    return 1;
}

/* Tells of the sensors: which ones are suspect when that changes, and what follows from it. */
static void tell(double t, uint32_t *known) {
    static const char *const sensors[] = {"position", "pressure of the piston side", "pressure of the rod side"};
    static const char *const faults[] = {"works again", "gives no reading", "is out of range", "jumped", "is frozen",
                                         "lost its load", "came with others that are wrong"};
    uint32_t suspects = hydrocrane_suspects(memory), notices = hydrocrane_notices(memory);
    for (uint32_t i = 0; i < 3 * HYDROCRANE_JOINTS; i++) {
        if ((suspects ^ *known) >> i & 1) {
            const char *fault = faults[hydrocrane_sensor_fault(memory, i)];
            fprintf(stderr, "%.3f s: joint %d: %s %s\n", t, (int)(i / 3), sensors[i % 3], fault);
        }
    }
    *known = suspects;
    if (notices & HYDROCRANE_SENSOR_STOPS) {
        fprintf(stderr, "%.3f s: the crane stops\n", t);
    }
    if (notices & HYDROCRANE_SENSORS_RESTART) {
        fprintf(stderr, "%.3f s: control restarts\n", t);
    }
}

int main(void) {
    uint32_t suspects = 0;
    double t, q[HYDROCRANE_JOINTS], p[2 * HYDROCRANE_JOINTS], axes[HYDROCRANE_AXES], spool[HYDROCRANE_JOINTS];
    hydrocrane_sample sample = {0.0, q, p};
    hydrocrane_status status =
        hydrocrane_create(memory, sizeof memory, hydrocrane_parameters, sizeof hydrocrane_parameters);
    if (status != HYDROCRANE_OK) {
        fprintf(stderr, "%s\n", hydrocrane_text(status));
        return 1;
    }
    for (int started = 0; read_numbers(&t, 1) && read_numbers(q, HYDROCRANE_JOINTS) &&
                          read_numbers(p, 2 * HYDROCRANE_JOINTS) && read_numbers(axes, HYDROCRANE_AXES);) {
        sample.t = t;
        if (!started) {
            started = hydrocrane_reset(memory, &sample) == HYDROCRANE_OK;
        }
        status = hydrocrane_step(memory, &sample, HYDROCRANE_MODE, axes, HYDROCRANE_AXES, spool, HYDROCRANE_JOINTS);
        printf("%d", (int)status);
        for (int c = 0; c < HYDROCRANE_JOINTS; c++) {
            printf(" %a", spool[c]);
        }
        printf("\n");
        tell(t, &suspects);
    }
    return 0;
}
