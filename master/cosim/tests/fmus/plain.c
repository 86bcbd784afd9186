/* An FMU of FMI 2.0 as it is written by hand: y = 2 u, at once; it has no functions but those that it needs, prints to stdout, and hands its
   logger another environment than it was given. With -DNEEDS_HELPER it calls a function of another library, which lies beside it;
   with -DPENDING its steps go on in the background. */
#include "fmu.h"

typedef struct {
    double u;
    double last;
    logger2 log;
} plain;

#ifdef NEEDS_HELPER
double helper(double u);
#else
static double helper(double u) { return 2 * u; }
#endif

FMI2_INSTANTIATE {
    plain *p = calloc(1, sizeof *p);
    printf("plain: licensed to nobody\n");
    fflush(stdout);
    p->log = functions->log;
    return p;
}
void fmi2FreeInstance(void *c) { free(c); }
/* FMUs of 20-sim forget here what was set before. */
FMI2_SETUP {
    ((plain *)c)->u = 0;
    return 0;
}
FMI2_MODES
int fmi2Terminate(void *c) {
    printf("plain: farewell\n");
    return 0;
}
int fmi2GetReal(void *c, const unsigned *vr, size_t n, double *value) {
    for (size_t k = 0; k < n; k++) value[k] = vr[k] ? helper(((plain *)c)->u) : ((plain *)c)->u;
    return 0;
}
int fmi2SetReal(void *c, const unsigned *vr, size_t n, const double *value) {
    for (size_t k = 0; k < n; k++) ((plain *)c)->u = value[k];
    return 0;
}
int fmi2DoStep(void *c, double t, double h, int no_state) {
    plain *p = c;
#ifdef PENDING
    return 5;
#endif
    if (t + h > 1.0) {
        p->log((void *)0x10, NULL, 2, NULL, "stopped by %s at %d percent", "hand", 42);
        return 2;
    }
    p->last = t + h;
    return 0;
}
int fmi2GetRealStatus(void *c, int kind, double *value) {
    *value = ((plain *)c)->last;
    return 0;
}
