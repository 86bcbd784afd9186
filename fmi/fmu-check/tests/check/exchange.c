/* FMI 2.0 FMU for Model Exchange alone, by the book: dx/dt = v + u, dv/dt = -x, y = x; with -DSTATES=0 only the output y = 2 u.
 * Arrays of its vectors are written to whatever their length is, as some tools do. Which dependencies are declared is up to the
 * description. Value references: Real 0 u (input), 1 y (output), 2 x, 3 v (states), 4 dx/dt, 5 dv/dt. */
#include <stddef.h>
#include <stdlib.h>

#ifndef STATES
#define STATES 2
#endif

typedef struct {
    double u, x[2], time;
} Model;

const char *fmi2GetVersion(void) { return "2.0"; }
const char *fmi2GetTypesPlatform(void) { return "default"; }
void *fmi2Instantiate(const char *name, int kind, const char *guid, const char *resources, const void *callbacks, int visible, int logging) {
    (void)name, (void)guid, (void)resources, (void)callbacks, (void)visible, (void)logging;
    Model *m = kind == 0 ? calloc(1, sizeof *m) : NULL;
    if (m)
        m->x[0] = 1;
    return m;
}
void fmi2FreeInstance(void *c) { free(c); }
int fmi2SetupExperiment(void *c, int has_tolerance, double tolerance, double start, int has_stop, double stop) {
    (void)has_tolerance, (void)tolerance, (void)has_stop, (void)stop;
    ((Model *)c)->time = start;
    return 0;
}
int fmi2EnterInitializationMode(void *c) { return (void)c, 0; }
int fmi2ExitInitializationMode(void *c) { return (void)c, 0; }
int fmi2EnterEventMode(void *c) { return (void)c, 0; }
int fmi2EnterContinuousTimeMode(void *c) { return (void)c, 0; }
int fmi2NewDiscreteStates(void *c, int *info) { return (void)c, (void)info, 0; }
int fmi2CompletedIntegratorStep(void *c, int no_set_prior, int *enter, int *ends) {
    (void)c, (void)no_set_prior;
    return *enter = *ends = 0;
}
int fmi2SetTime(void *c, double t) {
    ((Model *)c)->time = t;
    return 0;
}
int fmi2GetDerivatives(void *c, double *dx, size_t n) {
    Model *m = c;
    (void)n;
    dx[0] = m->x[1] + m->u;
    if (STATES)
        dx[1] = -m->x[0];
    return 0;
}
int fmi2GetContinuousStates(void *c, double *x, size_t n) {
    (void)n;
    for (int k = 0; k < 2; k++)
        x[k] = ((Model *)c)->x[k];
    return 0;
}
int fmi2SetContinuousStates(void *c, const double *x, size_t n) {
    (void)n;
    for (int k = 0; k < 2; k++)
        ((Model *)c)->x[k] = x[k];
    return 0;
}
int fmi2GetNominalsOfContinuousStates(void *c, double *x, size_t n) {
    (void)c, (void)n;
    return (x[0] = x[1] = 1), 0;
}
int fmi2GetEventIndicators(void *c, double *z, size_t n) {
    (void)c, (void)n;
    return z[0] = 1, 0;
}
int fmi2GetReal(void *c, const unsigned *vr, size_t n, double *value) {
    Model *m = c;
    double dx[2], all[6];
    fmi2GetDerivatives(c, dx, 2);
    all[0] = m->u, all[1] = STATES ? m->x[0] : 2 * m->u, all[2] = m->x[0], all[3] = m->x[1], all[4] = dx[0], all[5] = dx[1];
    for (size_t k = 0; k < n; k++)
        value[k] = all[vr[k]];
    return 0;
}
int fmi2SetReal(void *c, const unsigned *vr, size_t n, const double *value) {
    for (size_t k = 0; k < n; k++)
        if (vr[k] == 0)
            ((Model *)c)->u = value[k];
    return 0;
}
