/* An FMU of FMI 2.0 and 3.0 whose outputs are 1 until the time `at`, from then on what `kind` says: 1: NaN, 2: infinity, 3: minus infinity,
   4: 1e300, 5: their derivatives alone are NaN. Value references:

   0       u, any number; 1: y; 2: at; 3: kind; 4: how many numbers that are not finite it was given
   5       ahead: 1: the next event is always announced one ulp ahead, 2: steps return early by one ulp, 3: events that never end,
           4: events at 0.5 + k·0.1, compared with the time that steps add up to, 5: an update ends the run
   10, 11  three numbers in and out, of which the second is y; 12, 13: Float32 in and out; 14: q = u, at once; 15: 1/u, at once */
#include <math.h>

#include "fmu.h"

typedef struct {
    double time, u, at, kind, given, ahead, v[3];
    float w;
} numbers;

static double y(const numbers *n) {
    if (n->time < n->at - 1e-9) return 1;
    return n->kind == 1 ? NAN : n->kind == 2 ? INFINITY : n->kind == 3 ? -INFINITY : n->kind == 4 ? 1e300 : 1;
}
static void *made(void) {
    numbers *n = calloc(1, sizeof *n);
    n->at = 1e9, n->u = 1;
    return n;
}
static double *place(numbers *n, unsigned vr) {
    return vr == 0 ? &n->u : vr == 2 ? &n->at : vr == 3 ? &n->kind : vr == 4 ? &n->given : vr == 5 ? &n->ahead : n->v;
}
static int get(const numbers *n, const unsigned *vr, size_t count, double *values) {
    for (size_t k = 0; k < count; k++) {
        if (vr[k] == 10) memcpy(values, n->v, sizeof n->v), values += 3;
        else if (vr[k] == 11) values[0] = 1, values[1] = y(n), values[2] = 3, values += 3;
        else if (vr[k] == 14) *values++ = n->u;
        else if (vr[k] == 15) *values++ = 1 / n->u;
        else *values++ = vr[k] == 1 ? y(n) : *place((numbers *)n, vr[k]);
    }
    return 0;
}
static int set(numbers *n, const unsigned *vr, size_t count, const double *values) {
    for (size_t k = 0; k < count; k++)
        for (int i = 0; i < (vr[k] == 10 ? 3 : 1); i++) {
            n->given += !isfinite(*values);
            place(n, vr[k])[i] = *values++;
        }
    return 0;
}

FMI2_INSTANTIATE {
    return made();
}
FMI2_END
FMI2_SETUP {
    ((numbers *)c)->time = start;
    return 0;
}
FMI2_MODES
int fmi2GetReal(void *c, const unsigned *vr, size_t n, double *values) { return get(c, vr, n, values); }
int fmi2SetReal(void *c, const unsigned *vr, size_t n, const double *values) { return set(c, vr, n, values); }
int fmi2DoStep(void *c, double t, double h, int no_state) {
    ((numbers *)c)->time = t + h;
    return 0;
}
int fmi2GetRealOutputDerivatives(void *c, const unsigned *vr, size_t n, const int *order, double *values) {
    const numbers *of = c;
    for (size_t k = 0; k < n; k++) values[k] = of->kind == 5 && of->time >= of->at - 1e-9 ? NAN : 0;
    return 0;
}
int fmi2SetRealInputDerivatives(void *c, const unsigned *vr, size_t n, const int *order, const double *values) { return 0; }
int fmi2GetFMUstate(void *c, void **state) {
    if (!*state) *state = malloc(sizeof(numbers));
    memcpy(*state, c, sizeof(numbers));
    return 0;
}
int fmi2SetFMUstate(void *c, void *state) {
    memcpy(c, state, sizeof(numbers));
    return 0;
}
int fmi2FreeFMUstate(void *c, void **state) {
    free(*state);
    *state = NULL;
    return 0;
}

FMI3_INSTANTIATE {
    return made();
}
FMI3_END
FMI3_ENTER {
    ((numbers *)c)->time = start;
    return 0;
}
int fmi3ExitInitializationMode(void *c) { return 0; }
FMI3_EVENTS
FMI3_UPDATE {
    const numbers *n = c;
    *nominals = *values = false;
    *ends = n->ahead == 5 && n->time >= n->at - 1e-9;
    *again = n->ahead == 3 && n->time >= n->at - 1e-9;
    *has_next = n->ahead == 1 && n->time >= n->at - 1e-9;
    *next = nextafter(n->time, INFINITY);
    if (n->ahead == 4) {
        double k = round((n->time - 0.5) / 0.1);
        *has_next = true, *next = 0.5 + k * 0.1;
        if (*next <= n->time) *next = 0.5 + (k + 1) * 0.1;
    }
    return 0;
}
FMI3_STEP {
    numbers *n = c;
    if (!(h > 0)) return 3;
    *event = *ends = false;
    *early = n->ahead == 2 && t >= n->at - 1e-9;
    n->time = *last = *early ? nextafter(t, INFINITY) : t + h;
    return 0;
}
int fmi3GetFloat64(void *c, const unsigned *vr, size_t n, double *values, size_t count) { return get(c, vr, n, values); }
int fmi3SetFloat64(void *c, const unsigned *vr, size_t n, const double *values, size_t count) { return set(c, vr, n, values); }
int fmi3GetFloat32(void *c, const unsigned *vr, size_t n, float *values, size_t count) {
    for (size_t k = 0; k < n; k++) values[k] = vr[k] == 12 ? ((numbers *)c)->w : (float)y(c);
    return 0;
}
int fmi3SetFloat32(void *c, const unsigned *vr, size_t n, const float *values, size_t count) {
    numbers *of = c;
    of->given += !isfinite(*values);
    of->w = *values;
    return 0;
}
