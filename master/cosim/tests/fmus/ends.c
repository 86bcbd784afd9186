/* An FMU of FMI 2.0 and 3.0 that does not come to the end: y is its time, z = u at once. By `kind`, in the step over 0.45 s: 1 it makes the step
   and asks to end the simulation (FMI 2.0: it discards the step); 2 it stops at 0.45 s and asks; 3 it fails. 4: each step takes 1 ms; 5: for ever. */
#include <unistd.h>

#include "fmu.h"

typedef struct {
    double y, kind, u;
} ending;

static double *variable(ending *e, unsigned vr) { return vr == 0 ? &e->y : vr == 1 ? &e->kind : &e->u; }
static int pass(ending *e, const unsigned *vr, size_t n, double *get, const double *set) {
    for (size_t k = 0; k < n; k++) get ? (get[k] = *variable(e, vr[k])) : (*variable(e, vr[k]) = set[k]);
    return 0;
}
/* 0: made, 1: made and asks to end, 2: stops early and asks, 3: failed. */
static int step(ending *e, double t, double h) {
    double end = t + h;
    if (e->kind == 4) usleep(1000);
    while (e->kind == 5) usleep(1000);
    int kind = e->kind < 4 && t < 0.449 && end > 0.451 ? (int)e->kind : 0;
    if (kind != 3) e->y = kind == 2 ? 0.45 : end;
    return kind;
}

FMI2_INSTANTIATE {
    return calloc(1, sizeof(ending));
}
FMI2_END
FMI2_SETUP { return 0; }
FMI2_MODES
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
    *value = ((ending *)c)->y;
    return 0;
}

FMI3_INSTANTIATE {
    return calloc(1, sizeof(ending));
}
FMI3_END
FMI3_ENTER { return 0; }
int fmi3ExitInitializationMode(void *c) { return 0; }
int fmi3GetFloat64(void *c, const unsigned *vr, size_t n, double *value, size_t m) { return pass(c, vr, n, value, NULL); }
int fmi3SetFloat64(void *c, const unsigned *vr, size_t n, const double *value, size_t m) { return pass(c, vr, n, NULL, value); }
FMI3_STEP {
    int kind = step(c, t, h);
    *event = false, *ends = kind == 1 || kind == 2, *early = kind == 2, *last = ((ending *)c)->y;
    return kind == 3 ? 3 : 0;
}
