/* An FMU of FMI 2.0 and 3.0 that does not come to the end: y is its time, z = u at once. By `kind`, in the step over 0.45 s: 1 it makes the step
   and asks to end the simulation (FMI 2.0: it discards the step); 2 it stops at 0.45 s and asks; 3 it fails. 4: each step takes 1 ms; 5: for ever. */
#include <stdbool.h>
#include <stdlib.h>
#include <unistd.h>

typedef struct {
    double y, kind, u;
} ends;

static double *variable(ends *e, unsigned vr) { return vr == 0 ? &e->y : vr == 1 ? &e->kind : &e->u; }
static int pass(ends *e, const unsigned *vr, size_t n, double *get, const double *set) {
    for (size_t k = 0; k < n; k++) get ? (get[k] = *variable(e, vr[k])) : (*variable(e, vr[k]) = set[k]);
    return 0;
}
/* 0: made, 1: made and asks to end, 2: stops early and asks, 3: failed. */
static int step(ends *e, double t, double h) {
    double end = t + h;
    if (e->kind == 4) usleep(1000);
    while (e->kind == 5) usleep(1000);
    int kind = e->kind < 4 && t < 0.449 && end > 0.451 ? (int)e->kind : 0;
    if (kind != 3) e->y = kind == 2 ? 0.45 : end;
    return kind;
}

void *fmi2Instantiate(const char *name, int type, const char *guid, const char *resources, const void *functions, int visible, int logging) {
    return calloc(1, sizeof(ends));
}
void fmi2FreeInstance(void *c) { free(c); }
int fmi2SetupExperiment(void *c, int has_tolerance, double tolerance, double start, int has_stop, double stop) { return 0; }
int fmi2EnterInitializationMode(void *c) { return 0; }
int fmi2ExitInitializationMode(void *c) { return 0; }
int fmi2Terminate(void *c) { return 0; }
int fmi2GetReal(void *c, const unsigned *vr, size_t n, double *value) { return pass(c, vr, n, value, NULL); }
int fmi2SetReal(void *c, const unsigned *vr, size_t n, const double *value) { return pass(c, vr, n, NULL, value); }
int fmi2DoStep(void *c, double t, double h, int no_state) {
    int kind = step(c, t, h);
    return kind == 3 ? 3 : kind ? 2 : 0;
}
int fmi2GetBooleanStatus(void *c, int what, int *value) {
    *value = 1;
    return 0;
}
int fmi2GetRealStatus(void *c, int what, double *value) {
    *value = ((ends *)c)->y;
    return 0;
}

void *fmi3InstantiateCoSimulation(const char *name, const char *token, const char *resources, bool visible, bool logging, bool event_mode,
                                  bool early, const unsigned *required, size_t n, void *environment, void *log, void *update) {
    return calloc(1, sizeof(ends));
}
void fmi3FreeInstance(void *c) { free(c); }
int fmi3EnterInitializationMode(void *c, bool with_tolerance, double tolerance, double start, bool with_stop, double stop) { return 0; }
int fmi3ExitInitializationMode(void *c) { return 0; }
int fmi3Terminate(void *c) { return 0; }
int fmi3GetFloat64(void *c, const unsigned *vr, size_t n, double *value, size_t m) { return pass(c, vr, n, value, NULL); }
int fmi3SetFloat64(void *c, const unsigned *vr, size_t n, const double *value, size_t m) { return pass(c, vr, n, NULL, value); }
int fmi3DoStep(void *c, double t, double h, bool no_state, bool *event, bool *terminates, bool *early, double *last) {
    int kind = step(c, t, h);
    *event = false, *terminates = kind == 1 || kind == 2, *early = kind == 2, *last = ((ends *)c)->y;
    return kind == 3 ? 3 : 0;
}
