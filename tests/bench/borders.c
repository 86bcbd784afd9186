/* Calls through the border of FMI 2.0 or 3.0, for an instruction counter:
 *   borders 2|3 LIBRARY TOKEN step FIRST_IN FIRST_OUT N CALLS
 *   borders 2|3 LIBRARY TOKEN get FIRST N CALLS
 * `step` sets N values, steps and gets N values; `get` gets N values. The values have N references from FIRST on in FMI 2.0, and are one
 * array in FMI 3.0. */
#include <dlfcn.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST = 16 };

static void *library;

static void *symbol(const char *name) {
    void *address = dlsym(library, name);
    if (!address) {
        fprintf(stderr, "%s\n", dlerror());
        exit(1);
    }
    return address;
}

static int two(const char *token, bool steps, const unsigned *in, const unsigned *out, size_t n, int calls) {
    void *(*instantiate)(const char *, int, const char *, const char *, const void *, int, int) = symbol("fmi2Instantiate");
    int (*enter)(void *) = symbol("fmi2EnterInitializationMode"), (*leave)(void *) = symbol("fmi2ExitInitializationMode");
    int (*set)(void *, const unsigned *, size_t, const double *) = symbol("fmi2SetReal");
    int (*get)(void *, const unsigned *, size_t, double *) = symbol("fmi2GetReal");
    int (*step)(void *, double, double, int) = symbol("fmi2DoStep");
    void *none[5] = {0}, *c = instantiate("one", 1, token, NULL, none, 0, 0);
    double u[MOST] = {1, 2, 3, 4, 5, 6}, y[MOST];
    int failed = !c || enter(c) || leave(c);
    for (int k = 0; k < calls && !failed; k++) {
        if (steps)
            failed = set(c, in, n, u) | step(c, k * 1e-3, 1e-3, 1);
        failed |= get(c, out, n, y);
    }
    return failed;
}

static int three(const char *token, bool steps, const unsigned *in, const unsigned *out, size_t n, int calls) {
    void *(*instantiate)(const char *, const char *, const char *, bool, bool, bool, bool, const unsigned *, size_t, void *, void *, void *) =
        symbol("fmi3InstantiateCoSimulation");
    int (*enter)(void *, bool, double, double, bool, double) = symbol("fmi3EnterInitializationMode");
    int (*leave)(void *) = symbol("fmi3ExitInitializationMode");
    int (*set)(void *, const unsigned *, size_t, const double *, size_t) = symbol("fmi3SetFloat64");
    int (*get)(void *, const unsigned *, size_t, double *, size_t) = symbol("fmi3GetFloat64");
    int (*step)(void *, double, double, bool, bool *, bool *, bool *, double *) = symbol("fmi3DoStep");
    void *c = instantiate("one", token, NULL, 0, 0, 0, 0, NULL, 0, NULL, NULL, NULL);
    double u[MOST] = {1, 2, 3, 4, 5, 6}, y[MOST], last;
    bool event, end, early;
    int failed = !c || enter(c, 0, 0, 0, 0, 0) || leave(c);
    for (int k = 0; k < calls && !failed; k++) {
        if (steps)
            failed = set(c, in, 1, u, n) | step(c, k * 1e-3, 1e-3, 1, &event, &end, &early, &last);
        failed |= get(c, out, 1, y, n);
    }
    return failed;
}

int main(int argc, char **argv) {
    bool steps = argc == 9 && !strcmp(argv[4], "step"), gets = argc == 8 && !strcmp(argv[4], "get");
    library = argc > 2 ? dlopen(argv[2], RTLD_NOW) : NULL;
    if (!library || !(steps || gets)) {
        fprintf(stderr, "usage: borders 2|3 LIBRARY TOKEN step FIRST_IN FIRST_OUT N CALLS, or get FIRST N CALLS (%s)\n",
                library ? "other arguments" : dlerror());
        return 1;
    }
    unsigned in[MOST], out[MOST];
    size_t n = strtoul(argv[argc - 2], NULL, 10);
    for (unsigned k = 0; k < MOST; k++) {
        in[k] = atoi(argv[5]) + k;
        out[k] = atoi(argv[steps ? 6 : 5]) + k;
    }
    int calls = atoi(argv[argc - 1]);
    int failed = (argv[1][0] == '3' ? three : two)(argv[3], steps, in, out, n, calls);
    if (failed)
        fprintf(stderr, "borders %s: a call failed\n", argv[1]);
    return failed;
}
