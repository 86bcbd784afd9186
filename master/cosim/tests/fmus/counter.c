/* An FMU of FMI 2.0 whose code is not made for threads: a step counts in a global variable, and y is what it came to, n. */
#include <stdlib.h>

#ifndef LOOPS
#define LOOPS 20000
#endif

static volatile int counter;
typedef struct {
    double y, n;
} instance;

void *fmi2Instantiate(const char *name, int type, const char *guid, const char *resources, const void *functions, int visible, int logging) {
    instance *c = calloc(1, sizeof *c);
    c->n = LOOPS;
    return c;
}
void fmi2FreeInstance(void *c) { free(c); }
int fmi2SetupExperiment(void *c, int has_tolerance, double tolerance, double start, int has_stop, double stop) { return 0; }
int fmi2EnterInitializationMode(void *c) { return 0; }
int fmi2ExitInitializationMode(void *c) { return 0; }
int fmi2Terminate(void *c) { return 0; }
int fmi2GetReal(void *c, const unsigned *vr, size_t n, double *value) {
    for (size_t k = 0; k < n; k++) value[k] = ((instance *)c)->y;
    return 0;
}
int fmi2SetReal(void *c, const unsigned *vr, size_t n, const double *value) { return 0; }
int fmi2DoStep(void *c, double t, double h, int no_state) {
    instance *i = c;
    counter = 0;
    for (int k = 0; k < i->n; k++) counter++;
    i->y = counter;
    return 0;
}
