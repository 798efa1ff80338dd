/* Tries the controllers in C with damaged parameters, readings and pointers: `controller_fuzz PARAMETERS MEMORY JOINTS SEED START END`.
 *
 * Says what worker.py says, a line per event. Compiled with the sanitisers for this file; the library is not compiled with them, so all that it
 * is given ends at a page that nobody may touch. */
#include <math.h>
#include <setjmp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <time.h>
#include <unistd.h>

#include "hydrocrane_controller.h"

enum { MOST_JOINTS = 8, CALLS = 24 };

static uint64_t state;
static long number;
static int forged;
static jmp_buf before;

static uint64_t draw(uint64_t below) {
    state += 0x9e3779b97f4a7c15u;
    uint64_t z = state;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return (z ^ z >> 31) % below;
}

static void fault(const char *what) {
    printf("fault %ld wrong %s\n", number, what);
    fflush(stdout);
    _exit(0);
}

/* Parameters with a checksum that fits are the caller's word: where they are senseless, to stop is right. */
void hydrocrane_stop(void) {
    if (forged) {
        longjmp(before, 1);
    }
    fault("the library stopped: a mistake of its own");
    _exit(1);
}

/* Memory whose end is the end of what may be touched. */
static void *guarded(size_t size) {
    size_t page = (size_t)sysconf(_SC_PAGESIZE), whole = (size + page - 1) / page * page;
    char *place = mmap(NULL, whole + page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (place == MAP_FAILED || mprotect(place + whole, page, PROT_NONE) != 0) {
        exit(1);
    }
    return place + whole - size;
}

static uint32_t crc32_of(const uint8_t *bytes, size_t length) {
    uint32_t crc = ~0u;
    for (size_t i = 0; i < length; i++) {
        crc ^= bytes[i];
        for (int bit = 0; bit < 8; bit++) {
            crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0);
        }
    }
    return ~crc;
}

static double reading(double sound) {
    static const double odd[] = {NAN, INFINITY, -INFINITY, 0.0, -0.0, 1e300, -1e300, 1e-320, 1e12, -1e12};
    return draw(6) ? sound : odd[draw(sizeof odd / sizeof *odd)];
}

/* A few bytes changed, most often with a checksum that fits again. */
static void damage(uint8_t *block, size_t length) {
    for (uint64_t i = draw(4); i > 0; i--) {
        uint64_t at = draw(length);
        block[at] = (uint8_t)draw(256);
    }
    if (draw(4)) {
        uint64_t sum = crc32_of(block, length - 8);
        memcpy(block + length - 8, &sum, 8);
    }
}

static int one(const uint8_t *parameters, size_t length, size_t bytes, size_t joints) {
    static uint8_t *memory, *block;
    static double *q, *p, *axes, *spool;
    if (memory == NULL) {
        memory = guarded(bytes), block = guarded(length), q = guarded(8 * joints), p = guarded(16 * joints);
        spool = guarded(8 * joints);
    }
    memcpy(block, parameters, length);
    memset(memory, (int)draw(256), bytes);
    forged = draw(3) != 0;
    if (forged) {
        damage(block, length);
    }
    if (setjmp(before)) {
        return 0;
    }
    hydrocrane_status made = hydrocrane_create(memory, draw(20) ? bytes : draw(bytes), block, length);
    double t = 0.0;
    for (int call = 0; call < (made == HYDROCRANE_OK ? CALLS : 3); call++) {
        size_t count = draw(3) ? 2 : draw(MOST_JOINTS + 1);
        axes = (double *)guarded(8 * (count + 1)) + 1;
        for (size_t i = 0; i < joints; i++) {
            q[i] = reading(1.5), p[2 * i] = reading(80e5), p[2 * i + 1] = reading(60e5), spool[i] = NAN;
        }
        for (size_t i = 0; i < count; i++) {
            axes[i] = reading((double)draw(201) / 100.0 - 1.0);
        }
        t = draw(8) ? t + 0.01 : reading(t);
        hydrocrane_sample sample = {t, draw(30) ? q : NULL, draw(30) ? p : NULL};
        switch (draw(8)) {
        case 0: hydrocrane_reset(memory, draw(20) ? &sample : NULL); break;
        case 1: hydrocrane_set_point(memory, (double *)(draw(2) ? (void *)q : NULL)), hydrocrane_period(memory); break;
        case 2: hydrocrane_notices(memory), hydrocrane_sensor_fault(memory, (uint32_t)draw(1u << 31)); break;
        default: {
            size_t spools = draw(20) ? joints : draw(joints);
            const double *from = draw(30) ? axes : draw(2) ? NULL : spool;
            size_t many = draw(30) ? count : from == axes ? SIZE_MAX : draw(joints + 1);
            hydrocrane_status status = hydrocrane_step(draw(30) ? memory : NULL, draw(30) ? &sample : NULL, (int32_t)draw(5) - 1, from,
                                                       from == spool ? joints : many, spool, spools);
            for (size_t i = 0; i < spools; i++) {
                if (status == HYDROCRANE_OK ? !isfinite(spool[i]) : spool[i] != 0.0) {
                    fault(status == HYDROCRANE_OK ? "a command is no number" : "a status, and a command that is not zero");
                }
            }
            if (hydrocrane_text(status)[0] == '\0') {
                fault("a status without a text");
            }
        }
        }
        size_t page = (size_t)sysconf(_SC_PAGESIZE);
        munmap((void *)((uintptr_t)(axes - 1) / page * page), 2 * page);
    }
    return made == HYDROCRANE_OK;
}

int main(int argc, char **argv) {
    if (argc != 7) {
        return 2;
    }
    FILE *file = fopen(argv[1], "rb");
    static uint8_t parameters[1 << 20];
    size_t length = file == NULL ? 0 : fread(parameters, 1, sizeof parameters, file);
    for (number = atol(argv[5]); number < atol(argv[6]) && length > 8; number++) {
        printf("begin %ld\n", number);
        fflush(stdout);
        state = (uint64_t)atol(argv[4]) << 32 ^ (uint64_t)number;
        clock_t began = clock();
        int ran = one(parameters, length, (size_t)atol(argv[2]), (size_t)atol(argv[3]));
        printf("%s %ld %.4f\n", ran ? "ran" : "refused", number, (double)(clock() - began) / CLOCKS_PER_SEC);
    }
    return length > 8 ? 0 : 2;
}
