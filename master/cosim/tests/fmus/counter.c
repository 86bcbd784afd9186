/* An FMU of FMI 2.0 whose code is not made for threads: a step counts in a global variable, and y is what it came to, n. */
#include "fmu.h"

#ifndef LOOPS
#define LOOPS 20000
#endif

static volatile int counter;
typedef struct {
    double y, n;
} instance;

FMI2_INSTANTIATE {
    instance *c = calloc(1, sizeof *c);
    c->n = LOOPS;
    return c;
}
FMI2_END
FMI2_SETUP { return 0; }
FMI2_MODES
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
