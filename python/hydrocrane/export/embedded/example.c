/* Reads samples from standard input and prints commands; on a target the two are sensors and valves.
 *
 * A line is one sample: time, joint coordinates, pressures (two per cylinder), stick axes. The first one is also what the controller
 * starts from. Printed are the status and the commands, as hexadecimal floating-point numbers: every bit counts. */
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

int main(void) {
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
        status = hydrocrane_step(memory, &sample, HYDROCRANE_MODE, axes, HYDROCRANE_AXES, spool);
        printf("%d", (int)status);
        for (int c = 0; c < HYDROCRANE_JOINTS; c++) {
            printf(" %a", spool[c]);
        }
        printf("\n");
    }
    return 0;
}
