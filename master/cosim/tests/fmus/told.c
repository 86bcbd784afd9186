/* An FMU of FMI 2.0, with -DFMI3 of FMI 3.0, that shows what it is told. Its Real variables: 0 start, 1 stop and 2 tolerance of the run (-1: not
   defined), 3 loggingOn, 4 number of steps, 5 length of the last step, 6 where it ended; from 8 on they keep what they are set to. It refuses a
   step beyond the stop time, and logs each step, with the status OK. With -DSILENT it does not. With
   -DREFUSED no instance can be made; why is said only with loggingOn. */
#include "fmu.h"

#define COUNT 40
typedef struct {
    double r[COUNT];
    void *log, *environment;
} told;

static void say(told *c, int status, const char *text) {
#ifdef FMI3
    ((logger3)c->log)(c->environment, status, "own", text);
#else
    ((logger2)c->log)(c->environment, "told", status, "own", text);
#endif
}
static void *make(void *log, void *environment, int logging) {
    told *c = calloc(1, sizeof *c);
    c->log = log;
    c->environment = environment;
    c->r[1] = c->r[2] = -1;
    c->r[3] = logging;
#ifdef REFUSED
    if (logging) say(c, 3, "the key is lost");
    free(c);
    return NULL;
#endif
    return c;
}
static int begin(told *c, int has_tolerance, double tolerance, double start, int has_stop, double stop) {
    c->r[0] = start;
    c->r[1] = has_stop ? stop : -1;
    c->r[2] = has_tolerance ? tolerance : -1;
    return 0;
}
static int step(told *c, double t, double h) {
    if (c->r[1] != -1 && t + h > c->r[1]) return 3;
    c->r[4] += 1;
    c->r[5] = h;
    c->r[6] = t + h;
#ifndef SILENT
    say(c, 0, "a step is made");
#endif
    return 0;
}
static int get(told *c, const unsigned *vr, size_t n, double *x) {
    for (size_t k = 0; k < n; k++) x[k] = c->r[vr[k]];
    return 0;
}
static int set(told *c, const unsigned *vr, size_t n, const double *x) {
    for (size_t k = 0; k < n; k++) c->r[vr[k]] = x[k];
    return 0;
}

#ifdef FMI3
FMI3_INSTANTIATE {
    return make((void *)log, environment, logging);
}
FMI3_END
int fmi3SetDebugLogging(void *c, bool on, size_t n, const char *const *names) {
    ((told *)c)->r[3] = on;
    return 0;
}
FMI3_ENTER {
    return begin(c, has_tolerance, tolerance, start, has_stop, stop);
}
int fmi3ExitInitializationMode(void *c) { return 0; }
int fmi3GetFloat64(void *c, const unsigned *vr, size_t n, double *x, size_t m) {
    if (n == 1 && m > 1) { /* an array: as many values from its reference on */
        for (size_t k = 0; k < m; k++) x[k] = ((told *)c)->r[vr[0] + k];
        return 0;
    }
    return get(c, vr, n, x);
}
int fmi3SetFloat64(void *c, const unsigned *vr, size_t n, const double *x, size_t m) {
    if (n == 1 && m > 1) {
        for (size_t k = 0; k < m; k++) ((told *)c)->r[vr[0] + k] = x[k];
        return 0;
    }
    return set(c, vr, n, x);
}
FMI3_STEP {
    *event = *ends = *early = false;
    *last = t + h;
    return step(c, t, h);
}
#else
FMI2_INSTANTIATE {
    return make((void *)functions->log, functions->environment, logging);
}
FMI2_END
int fmi2SetDebugLogging(void *c, int on, size_t n, const char *const *names) {
    ((told *)c)->r[3] = on;
    return 0;
}
FMI2_SETUP {
    return begin(c, has_tolerance, tolerance, start, has_stop, stop);
}
FMI2_MODES
int fmi2GetReal(void *c, const unsigned *vr, size_t n, double *x) { return get(c, vr, n, x); }
int fmi2SetReal(void *c, const unsigned *vr, size_t n, const double *x) { return set(c, vr, n, x); }
int fmi2DoStep(void *c, double t, double h, int no_state) { return step(c, t, h); }
#endif
