/* Time of one fmi2SetReal of 4 + fmi2DoStep + fmi2GetReal of 4, ns: overhead NAME LIBRARY GUID
 * Prints a line of JSON.
 *
 * For an instruction counter: overhead NAME LIBRARY GUID INSTANCES STEPS
 * makes so many instances, each up to the end of its initialization, and so many steps; prints nothing. */
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

static void *(*instantiate)(const char *, int, const char *, const char *, const void *, int, int);
static int (*enter)(void *), (*leave)(void *), (*reset)(void *);
static int (*set)(void *, const unsigned *, size_t, const double *);
static int (*get)(void *, const unsigned *, size_t, double *);
static int (*step)(void *, double, double, int);

static int steps(void *c, int n) {
    const unsigned inputs[] = {0, 1, 2, 3}, outputs[] = {4, 5, 6, 7};
    double u[] = {1, 2, 3, 4}, x[4], h = 1e-3;
    int failed = 0;
    for (int k = 0; k < n; k++)
        failed |= set(c, inputs, 4, u) | step(c, k * h, h, 1) | get(c, outputs, 4, x);
    return failed;
}

int main(int argc, char **argv) {
    int is_counted = argc == 6;
    void *library = argc == 4 || is_counted ? dlopen(argv[2], RTLD_NOW) : NULL;
    if (!library) {
        fprintf(stderr, "usage: overhead NAME LIBRARY GUID [INSTANCES STEPS] (%s)\n",
                argc == 4 || is_counted ? dlerror() : "three or five arguments");
        return 1;
    }
    instantiate = symbol(library, "fmi2Instantiate");
    enter = symbol(library, "fmi2EnterInitializationMode");
    leave = symbol(library, "fmi2ExitInitializationMode");
    reset = symbol(library, "fmi2Reset");
    set = symbol(library, "fmi2SetReal");
    get = symbol(library, "fmi2GetReal");
    step = symbol(library, "fmi2DoStep");
    Callbacks none = {0};
    int failed = 0;
    if (is_counted) {
        void *c = NULL;
        for (int k = 0; k < atoi(argv[4]); k++) {
            c = instantiate("one", 1, argv[3], NULL, &none, 0, 0);
            failed |= !c || enter(c) || leave(c);
        }
        failed |= steps(c, atoi(argv[5]));
        if (failed)
            fprintf(stderr, "%s: a call failed\n", argv[1]);
        return failed;
    }
    void *c = instantiate("one", 1, argv[3], NULL, &none, 0, 0);
    double times[BATCHES];
    for (int batch = 0; batch < BATCHES; batch++) {
        failed = !c || enter(c) || leave(c);
        double start = now();
        failed |= steps(c, STEPS);
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
