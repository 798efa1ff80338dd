/* Time per sample of an exported controller: samples from a file, over and over. What counts is the shortest time of each sample, as other
 * programs disturb the rest; printed are the mean and the longest of them, ns. */
#define _POSIX_C_SOURCE 199309L
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "hydrocrane_controller.h"
#include "hydrocrane_parameters.h"

enum { MOST = 2000, NUMBERS = 1 + 3 * HYDROCRANE_JOINTS + HYDROCRANE_AXES, PASSES = 200 };

static uint64_t memory[HYDROCRANE_MEMORY / 8];
static double samples[MOST][NUMBERS];
static double shortest[MOST];

void hydrocrane_stop(void) { abort(); }

static double now(void) {
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return 1e9 * (double)time.tv_sec + (double)time.tv_nsec;
}

int main(void) {
    double spool[HYDROCRANE_JOINTS], sum = 0.0, longest = 0.0;
    int count = 0;
    for (; count < MOST; count++) {
        for (int i = 0; i < NUMBERS; i++) {
            if (scanf("%lf", &samples[count][i]) != 1) {
                goto read;
            }
        }
        shortest[count] = 1e30;
    }
read:
    if (count < 2 || hydrocrane_create(memory, sizeof memory, hydrocrane_parameters, sizeof hydrocrane_parameters)) {
        return 1;
    }
    for (int pass = 0; pass < PASSES; pass++) {
        for (int k = 0; k < count; k++) {
            const double *row = samples[k];
            hydrocrane_sample sample = {row[0], row + 1, row + 1 + HYDROCRANE_JOINTS};
            if (k == 0 && hydrocrane_reset(memory, &sample)) {
                return 2;
            }
            double before = now();
            if (hydrocrane_step(memory, &sample, HYDROCRANE_MODE, row + 1 + 3 * HYDROCRANE_JOINTS, HYDROCRANE_AXES, spool,
                                HYDROCRANE_JOINTS)) {
                return 3;
            }
            double taken = now() - before;
            shortest[k] = taken < shortest[k] ? taken : shortest[k];
        }
    }
    for (int k = 0; k < count; k++) {
        sum += shortest[k];
        longest = shortest[k] > longest ? shortest[k] : longest;
    }
    printf("%.1f %.1f\n", sum / count, longest);
    return 0;
}
