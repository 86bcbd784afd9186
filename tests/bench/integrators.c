/* FMI 2.0 co-simulation FMU "x_dot = u in four places", written by hand: what a step of an FMU costs in C.
 * The same variables and the same checks as kit/fmu-export/examples/integrators.rs; only the functions
 * that overhead.c calls. Value references: 0..3 inputs u, 4..7 outputs x. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { OK, WARNING, DISCARD, ERROR };
enum { INSTANTIATED = 1, INITIALIZATION = 2, STEP_COMPLETE = 4, TERMINATED = 8 };
enum { N = 4 };

typedef struct {
    double u[N], x[N], time;
    int mode;
} Instance;

void *fmi2Instantiate(const char *name, int kind, const char *guid, const char *resources, const void *functions,
                      int visible, int logging) {
    (void)resources, (void)visible, (void)logging;
    if (!name || !*name || kind != 1 || !guid || !functions)
        return NULL;
    Instance *s = calloc(1, sizeof *s);
    if (s)
        s->mode = INSTANTIATED;
    return s;
}

void fmi2FreeInstance(void *c) { free(c); }

static int change(void *c, int allowed, int next) {
    Instance *s = c;
    if (!s || !(s->mode & allowed))
        return ERROR;
    s->mode = next;
    return OK;
}

int fmi2EnterInitializationMode(void *c) { return change(c, INSTANTIATED, INITIALIZATION); }
int fmi2ExitInitializationMode(void *c) { return change(c, INITIALIZATION, STEP_COMPLETE); }

int fmi2Reset(void *c) {
    Instance *s = c;
    if (!s)
        return ERROR;
    memset(s, 0, sizeof *s);
    s->mode = INSTANTIATED;
    return OK;
}

int fmi2SetReal(void *c, const unsigned *vr, size_t n, const double *value) {
    Instance *s = c;
    if (!s || !(s->mode & (INSTANTIATED | INITIALIZATION | STEP_COMPLETE)) || (n && (!vr || !value)))
        return ERROR;
    for (size_t k = 0; k < n; k++)
        if (vr[k] >= N || !isfinite(value[k]) || value[k] < -1e9 || value[k] > 1e9)
            return ERROR;
    for (size_t k = 0; k < n; k++)
        s->u[vr[k]] = value[k];
    return OK;
}

int fmi2GetReal(void *c, const unsigned *vr, size_t n, double *value) {
    Instance *s = c;
    if (!s || !(s->mode & (INITIALIZATION | STEP_COMPLETE | TERMINATED)) || (n && (!vr || !value)))
        return ERROR;
    for (size_t k = 0; k < n; k++) {
        if (vr[k] >= 2 * N)
            return ERROR;
        double v = vr[k] < N ? s->u[vr[k]] : s->x[vr[k] - N];
        if (!isfinite(v))
            return ERROR;
        value[k] = v;
    }
    return OK;
}

int fmi2DoStep(void *c, double t, double h, int no_set_prior) {
    (void)no_set_prior;
    Instance *s = c;
    if (!s || s->mode != STEP_COMPLETE || !(isfinite(h) && h > 0) || !(fabs(t - s->time) <= 1e-6 * h) || !(t + h > t))
        return ERROR;
    for (int i = 0; i < N; i++)
        s->x[i] += h * s->u[i];
    s->time = t + h;
    return OK;
}
