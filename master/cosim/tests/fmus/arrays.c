/* An FMU of FMI 3.0 whose inputs and outputs are arrays: y = k G u + b (1 + t). It has directional derivatives, and refuses arrays that are
   not passed whole. Value references:

   1       k; 2: u, three numbers; 3: y, three numbers
   4       how often its directional derivatives were asked for; 5: how often u was set */
#include "fmu.h"

enum { OK, ERROR = 3 };
static const double G[3][3] = {{0.3, -0.7, 0.2}, {0.5, 0.1, -0.4}, {-0.2, 0.6, 0.8}};
static const double B[3] = {1.0, -2.0, 3.0};

typedef struct {
    double time, k, u[3], asked, sets;
} arrays;

static double row(const arrays *a, int i, const double u[3]) { return a->k * (G[i][0] * u[0] + G[i][1] * u[1] + G[i][2] * u[2]); }

FMI3_INSTANTIATE {
    arrays *a = calloc(1, sizeof *a);
    a->k = 1;
    return a;
}
FMI3_END
FMI3_ENTER {
    ((arrays *)c)->time = start;
    return OK;
}
int fmi3ExitInitializationMode(void *c) { return OK; }
FMI3_EVENTS
FMI3_UPDATE {
    *again = *ends = *nominals = *values = *has_next = false;
    return OK;
}
FMI3_STEP {
    *event = *ends = *early = false;
    ((arrays *)c)->time = *last = t + h;
    return OK;
}
int fmi3GetFloat64(void *c, const unsigned *vr, size_t n, double *values, size_t count) {
    const arrays *a = c;
    const double *end = values + count;
    for (size_t j = 0; j < n; j++) {
        if (vr[j] == 1) *values++ = a->k;
        for (int i = 0; i < 3 && vr[j] == 2; i++) *values++ = a->u[i];
        for (int i = 0; i < 3 && vr[j] == 3; i++) *values++ = row(a, i, a->u) + B[i] * (1 + a->time);
        if (vr[j] == 4) *values++ = a->asked;
        if (vr[j] == 5) *values++ = a->sets;
    }
    return values == end ? OK : ERROR;
}
int fmi3SetFloat64(void *c, const unsigned *vr, size_t n, const double *values, size_t count) {
    arrays *a = c;
    if (n == 1 && vr[0] == 1 && count == 1) {
        a->k = values[0];
        return OK;
    }
    if (n != 1 || vr[0] != 2 || count != 3) return ERROR;
    memcpy(a->u, values, sizeof a->u);
    a->sets++;
    return OK;
}
int fmi3GetDirectionalDerivative(void *c, const unsigned *unknowns, size_t n, const unsigned *knowns, size_t m, const double *seeds,
                                 size_t seed_count, double *rates, size_t rate_count) {
    arrays *a = c;
    if (n != 1 || unknowns[0] != 3 || rate_count != 3 || m != 1 || knowns[0] != 2 || seed_count != 3) return ERROR;
    for (int i = 0; i < 3; i++) rates[i] = row(a, i, seeds);
    a->asked++;
    return OK;
}
