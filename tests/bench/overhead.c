/* Time of one fmi2SetReal of 4 + fmi2DoStep + fmi2GetReal of 4, ns: overhead NAME LIBRARY GUID
 * Prints name, unit, median and fastest of the batches, separated by tabs. */
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

enum { BATCHES = 31, STEPS = 20000 };

typedef struct {
    void *logger, *allocate, *release, *finished, *environment;
} Callbacks;

static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return t.tv_sec + 1e-9 * t.tv_nsec;
}

static int ascending(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void *symbol(void *library, const char *name) {
    void *address = dlsym(library, name);
    if (!address) {
        fprintf(stderr, "%s\n", dlerror());
        exit(1);
    }
    return address;
}

int main(int argc, char **argv) {
    void *library = argc == 4 ? dlopen(argv[2], RTLD_NOW) : NULL;
    if (!library) {
        fprintf(stderr, "usage: overhead NAME LIBRARY GUID (%s)\n", argc == 4 ? dlerror() : "three arguments");
        return 1;
    }
    void *(*instantiate)(const char *, int, const char *, const char *, const void *, int, int) =
        symbol(library, "fmi2Instantiate");
    int (*enter)(void *) = symbol(library, "fmi2EnterInitializationMode");
    int (*leave)(void *) = symbol(library, "fmi2ExitInitializationMode");
    int (*reset)(void *) = symbol(library, "fmi2Reset");
    int (*set)(void *, const unsigned *, size_t, const double *) = symbol(library, "fmi2SetReal");
    int (*get)(void *, const unsigned *, size_t, double *) = symbol(library, "fmi2GetReal");
    int (*step)(void *, double, double, int) = symbol(library, "fmi2DoStep");
    Callbacks none = {0};
    void *c = instantiate("one", 1, argv[3], NULL, &none, 0, 0);
    const unsigned inputs[] = {0, 1, 2, 3}, outputs[] = {4, 5, 6, 7};
    double u[] = {1, 2, 3, 4}, x[4], times[BATCHES], h = 1e-3;
    for (int batch = 0; batch < BATCHES; batch++) {
        int failed = !c || enter(c) || leave(c);
        double start = now();
        for (int k = 0; k < STEPS; k++)
            failed |= set(c, inputs, 4, u) | step(c, k * h, h, 1) | get(c, outputs, 4, x);
        times[batch] = 1e9 * (now() - start) / STEPS;
        if (failed || reset(c)) {
            fprintf(stderr, "%s: a call failed\n", argv[1]);
            return 1;
        }
    }
    qsort(times, BATCHES, sizeof *times, ascending);
    printf("{\"name\":\"%s\",\"unit\":\"ns\",\"median\":%.1f,\"least\":%.1f}\n", argv[1], times[BATCHES / 2], times[0]);
    return 0;
}
