/* A program in front of the bridge: moves the boom for a second and prints where the tip is.

   cc -O2 -o bridge_client bridge_client.c
   hydrocrane live rottne-f9-lab --bridge udp://127.0.0.1:5005 &
   ./bridge_client 5005

   Packets: docs/reference/bridge-packets.md. This file runs on little-endian machines. */

#include <arpa/inet.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/time.h>

enum { HELLO = 1, VALUES = 2, RESET = 3, DESCRIPTION = 17, SAMPLE = 18, PROBLEM = 19 };
enum { MOST = 1024, CYLINDERS = 3, TIP_X = 12, TIP_Z = 13 };

#pragma pack(push, 1)
struct packet {
    char magic[4];
    uint16_t version, kind;
    uint32_t sequence, count;
    double time;
    uint64_t flags;
    union {
        double values[MOST];
        char text[8 * MOST];
    } body;
};
#pragma pack(pop)

static int s;

static void send_values(uint16_t kind, uint32_t sequence, double time, const double *values, uint32_t count) {
    struct packet p = {.magic = {'H', 'Y', 'C', 'B'}, .version = 1, .kind = kind, .sequence = sequence};
    p.count = count;
    p.time = time;
    if (count > 0) memcpy(p.body.values, values, count * sizeof(double));
    send(s, &p, 32 + count * sizeof(double), 0);
}

/* The next packet of one kind; problems are printed. Ends the program where nothing comes. */
static struct packet next(uint16_t kind) {
    for (;;) {
        static struct packet p;
        ssize_t got = recv(s, &p, sizeof p, 0);
        if (got < 32) {
            fprintf(stderr, "the bridge does not answer\n");
            exit(1);
        }
        if (p.kind == PROBLEM) fprintf(stderr, "%.*s\n", (int)p.count, p.body.text);
        if (p.kind == kind) return p;
    }
}

int main(int argc, char **argv) {
    struct sockaddr_in bridge = {.sin_family = AF_INET, .sin_port = htons((uint16_t)atoi(argc > 1 ? argv[1] : "5005"))};
    inet_pton(AF_INET, "127.0.0.1", &bridge.sin_addr);
    s = socket(AF_INET, SOCK_DGRAM, 0);
    struct timeval patience = {.tv_sec = 5};
    setsockopt(s, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    if (connect(s, (struct sockaddr *)&bridge, sizeof bridge) != 0) return 1;

    send_values(HELLO, 0, 0.0, NULL, 0);
    struct packet p = next(DESCRIPTION);
    printf("%.*s\n", (int)p.count, p.body.text);

    send_values(RESET, 1, 0.0, NULL, 0);
    p = next(SAMPLE);
    double start = p.time, height = p.body.values[TIP_Z];
    for (uint32_t k = 2; p.time < start + 1.0; k++) {
        double spools[CYLINDERS] = {5e-3, 0.0, 0.0};
        send_values(VALUES, k, p.time + 1e-9 * k, spools, CYLINDERS);
        p = next(SAMPLE);
    }
    printf("time %.3f s, flags %u, tip up by %.4f m\n", p.time, (unsigned)p.flags, p.body.values[TIP_Z] - height);
    return 0;
}
