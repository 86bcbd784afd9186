/* Three lags of FMI 2.0, x' = u - k x by Euler's rule, and outputs that are inputs: a Real, an Integer and a Boolean. */
#include "fmu.h"

enum { U = 0, Y = 3, K = 6, IN = 7, OUT = 8, START = 9 };

typedef struct {
    double r[10];
    int n, b;
} lags;

FMI2_INSTANTIATE {
    lags *m = calloc(1, sizeof *m);
    m->r[K] = 1;
    return m;
}
FMI2_END
FMI2_SETUP { return 0; }
int fmi2EnterInitializationMode(void *c) {
    lags *m = c;
    for (int i = 0; i < 3; i++) m->r[Y + i] = m->r[START] * (i + 1);
    return 0;
}
int fmi2ExitInitializationMode(void *c) { return 0; }
int fmi2GetReal(void *c, const unsigned *vr, size_t n, double *value) {
    lags *m = c;
    for (size_t i = 0; i < n; i++) value[i] = m->r[vr[i] == OUT ? IN : vr[i]];
    return 0;
}
int fmi2SetReal(void *c, const unsigned *vr, size_t n, const double *value) {
    for (size_t i = 0; i < n; i++) ((lags *)c)->r[vr[i]] = value[i];
    return 0;
}
int fmi2GetInteger(void *c, const unsigned *vr, size_t n, int *value) {
    for (size_t i = 0; i < n; i++) value[i] = ((lags *)c)->n;
    return 0;
}
int fmi2SetInteger(void *c, const unsigned *vr, size_t n, const int *value) {
    for (size_t i = 0; i < n; i++) ((lags *)c)->n = value[i];
    return 0;
}
int fmi2GetBoolean(void *c, const unsigned *vr, size_t n, int *value) {
    for (size_t i = 0; i < n; i++) value[i] = ((lags *)c)->b;
    return 0;
}
int fmi2SetBoolean(void *c, const unsigned *vr, size_t n, const int *value) {
    for (size_t i = 0; i < n; i++) ((lags *)c)->b = value[i];
    return 0;
}
int fmi2DoStep(void *c, double t, double h, int no_state) {
    lags *m = c;
    for (int i = 0; i < 3; i++) m->r[Y + i] += h * (m->r[U + i] - m->r[K] * m->r[Y + i]);
    return 0;
}
