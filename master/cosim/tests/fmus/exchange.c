/* FMUs for Model Exchange, of FMI 2.0 and with -DFMI3 of FMI 3.0, one for each KIND, with a parameter P, start
   values X and a FAULT. They refuse every call that the state machine of the
   standard does not allow. Real variables: states from 0 on, derivatives from 2000 on, 5000 the input u, 5001 the parameter p, 6000 the output
   u + x[0], 6001 time of the last event, 6002 time. Integers: 7000 kind, 7001 number of events, 7002 the discrete input n, 7003 what was seen of
   it, 7004 a fault. FOLLOW has the input 5003, the derivative of u, and 6004, which ought to be the mean of y over a step; ROD with -DMATRIX the
   size 8000 of the second dimension of its states, of which there are 2 in the first. */
#include "fmu.h"
#include <math.h>

enum { BALL, BELT, VAN_DER_POL, ROD, CHATTER, TICKS, DECAY, STEPPED, FOLLOW };
enum { NONE, ERROR_RATE, NAN_RATE, ENDLESS, NAN_STATE, END_STEP, END_EVENT, DISCARD_RATE,
       NAN_INDICATOR, INF_NOMINAL, NAN_NOMINAL, PAST_EVENT, ENDLESS_START, MOVED_STATE, BAD_COMPLETED, END_START, MANY_RATES, FEW_RATES,
       MANY_INDICATORS, NO_INDICATOR, OTHER_STATES, OTHER_INDICATORS, BAD_STATES, BAD_TIME, BAD_INDICATOR, BAD_EVENT, BAD_NOMINAL, NAN_START,
       BAD_UPDATE, INF_RATE, BAD_CONTINUOUS };
enum { INSTANTIATED, INITIALIZATION, EVENT, CONTINUOUS, OVER };
#ifndef N
#define N 2
#endif
#ifndef Z
#define Z 1
#endif
typedef struct {
    double t, x[N + 1], u, p, last, next, u_dot;
    int kind, count, n, seen, fault, mode, sticks, side, used;
} model;

#ifndef X
#define X {sin(3.141592653589793 * (i + 1) / (m->used + 1.0))}
#endif
#define AFTER(f, at) if (m->fault == f && m->t > at) return 3;
static void start(model *m, int used) {
    m->used = used;
    for (int i = 0; i < used; i++) {
        double x[] = X;
        m->x[i] = x[sizeof x > sizeof *x ? i : 0];
    }
}
static void *make(void) {
    model *m = calloc(1, sizeof *m);
    m->kind = KIND;
    m->fault = FAULT;
    m->p = P;
    start(m, N);
    return m;
}
static double mass_force(model *m) { return m->p; }
static void rates(model *m, double *dx) {
    switch (m->kind) {
    case BALL: dx[0] = m->x[1], dx[1] = -9.81; break;
    /* On a belt of 0.1 m/s: spring 4 N/m, 1 kg; kinetic friction p, static friction 1.5 p. */
    case BELT: dx[0] = m->sticks ? 0.1 : m->x[1], dx[1] = m->sticks ? 0 : mass_force(m) - 4 * m->x[0]; break;
    case VAN_DER_POL: dx[0] = m->x[1], dx[1] = m->p * (1 - m->x[0] * m->x[0]) * m->x[1] - m->x[0]; break;
    case ROD:
        for (int i = 0, n = m->used; i < n; i++) {
            double left = i ? m->x[i - 1] : m->u, right = i < n - 1 ? m->x[i + 1] : 0;
            dx[i] = (left - 2 * m->x[i] + right) * (n + 1.0) * (n + 1.0);
        }
        break;
    case CHATTER: dx[0] = m->side ? -1 : 1; break;
    case TICKS: dx[0] = m->p; break;
    case DECAY: dx[0] = m->u - m->x[0], dx[1] = -m->x[1]; break;
    case STEPPED: dx[0] = m->side; break;
    case FOLLOW: dx[0] = m->u; break;
    }
}
static void indicators(model *m, double *z) {
    switch (m->kind) {
    case BELT: z[0] = m->sticks ? 1.5 * m->p - 4 * m->x[0] : 0.1 - m->x[1]; break;
    case STEPPED: z[0] = m->u - 0.5; break;
    default: z[0] = m->x[0];
    }
    if (m->fault == NAN_INDICATOR && m->t > 0.3) z[0] = NAN;
}
/* One pass of the iteration; whether there must be another. */
static int event(model *m) {
    if (m->fault == ENDLESS && m->t > 0 || m->fault == ENDLESS_START) return 1;
    if (m->fault == NAN_START) m->x[0] = NAN;
    double z[1];
    indicators(m, z);
    int before = m->count;
    if (m->kind == BALL && m->x[0] <= 0 && m->x[1] < 0) m->x[0] = 0x1p-1022, m->x[1] *= -m->p, m->count++;
    if (m->kind == BELT && m->sticks && z[0] <= 0) m->sticks = 0, m->x[1] = 0.1, m->count++;
    else if (m->kind == BELT && !m->sticks && z[0] <= 0) m->sticks = 1, m->count++;
    if (m->kind == CHATTER && m->side != (z[0] > 0)) m->side = z[0] > 0, m->count++;
    if (m->kind == STEPPED && m->side != (z[0] > 0)) m->side = z[0] > 0, m->count++;
    if (m->kind == TICKS && m->t >= m->next) m->x[0] = 0, m->count++, m->next = m->fault == PAST_EVENT ? 0.05 : 0.25 * m->count + 0.1;
    if (m->count > before) m->last = m->t;
    if (m->fault == NAN_STATE && m->count > before) m->x[0] = NAN;
    m->seen = m->n;
    return 0;
}
#define IN(modes) if (!((modes) >> m->mode & 1)) return 3;
enum { I = 1, J = 2, E = 4, C = 8, O = 16 };
static int get(model *m, const unsigned *vr, size_t n, double *v) {
    double dx[N + 1];
    rates(m, dx);
    for (size_t k = 0; k < n; k++) {
        unsigned r = vr[k];
        v[k] = r < 2000 ? m->x[r] : r < 4000 ? dx[r - 2000] : r == 5000 ? m->u : r == 5001 ? m->p : r == 6000 ? m->u + m->x[0] : r == 6001 ? m->last : r == 5003 ? m->u_dot : r == 6004 ? m->u + m->x[0] : m->t;
    }
    return 0;
}
static int set(model *m, const unsigned *vr, size_t n, const double *v) {
    for (size_t k = 0; k < n; k++) {
        IN(vr[k] == 5000 || vr[k] == 5003 ? I | J | E | C : I | J)
        if (vr[k] == 5000) m->u = v[k];
        else if (vr[k] == 5003) m->u_dot = v[k];
        else if (vr[k] == 5001) m->p = v[k];
        else if (vr[k] < N) m->x[vr[k]] = v[k];
        else return 3;
    }
    return 0;
}
static int *whole(model *m, unsigned r) {
    return r == 7000 ? &m->kind : r == 7001 ? &m->count : r == 7002 ? &m->n : r == 7003 ? &m->seen : &m->fault;
}
static int set_whole(model *m, const unsigned *vr, size_t n, const int *v) {
    for (size_t k = 0; k < n; k++) {
        IN(vr[k] == 7002 ? I | J | E : I)
        *whole(m, vr[k]) = v[k];
    }
    return 0;
}
static int get_rates(model *m, double *dx) {
    IN(J | E | C)
    double all[N + 1] = {0};
    if (m->fault == MOVED_STATE) m->x[0] += 1;
    rates(m, all);
    memcpy(dx, all, (m->used + (m->fault == MANY_RATES) - (m->fault == FEW_RATES)) * sizeof *dx);
    if (m->t > 0.3) {
        if (m->fault == INF_RATE) dx[1] = INFINITY;
        if (m->fault == ERROR_RATE) return 3;
        if (m->fault == NAN_RATE) dx[0] = NAN;
        if (m->fault == DISCARD_RATE) return 2;
    }
    return 0;
}
static int go(model *m, int from, int to) {
    IN(from)
    if (m->fault == BAD_EVENT && from == C || m->fault == BAD_CONTINUOUS && to == CONTINUOUS && m->t > 0) return 3;
    if (to == EVENT && m->kind == BELT && m->mode == INITIALIZATION) m->sticks = 1;
    if (to == EVENT && m->kind == TICKS && m->mode == INITIALIZATION) m->next = 0.1;
    m->mode = to;
    return 0;
}
static int completed(model *m, int *enter, int *ends) {
    IN(C)
    AFTER(BAD_COMPLETED, 0.35)
    *enter = 0;
    *ends = m->fault == END_STEP && m->t >= 0.35;
    return 0;
}
static int set_states(model *m, const double *x, size_t n) {
    IN(C)
    AFTER(BAD_STATES, 0.3)
    memcpy(m->x, x, n * sizeof *x);
    return (int)n == m->used ? 0 : 3;
}
static int set_time(model *m, double t) {
    IN(E | C)
    AFTER(BAD_TIME, 0.3)
    m->t = t;
    return 0;
}
static int directional(model *m, const unsigned *y, size_t ny, const unsigned *u, size_t nu, const double *seed, double *out) {
    IN(J | E | C)
    if (m->kind != VAN_DER_POL || ny != 2 || nu != 2) return 3;
    out[0] = seed[1];
    out[1] = -(2 * m->p * m->x[0] * m->x[1] + 1) * seed[0] + m->p * (1 - m->x[0] * m->x[0]) * seed[1];
    return 0;
}
static int save(model *m, void **s) {
    if (!*s) *s = malloc(sizeof *m);
    memcpy(*s, m, sizeof *m);
    return 0;
}
static int restore(model *m, void *s) {
    memcpy(m, s, sizeof *m);
    return 0;
}

#ifdef FMI3
#define F(name) fmi3##name
void *fmi3InstantiateModelExchange(const char *name, const char *token, const char *resources, bool visible, bool logging, void *environment, logger3 log) {
    return make();
}
FMI3_END
FMI3_ENTER {
    ((model *)c)->t = start;
    return go(c, I, INITIALIZATION);
}
/* States and derivatives are arrays: as many values from the reference on. */
static int each(model *m, const unsigned *vr, size_t n, double *v, bool sets) {
    for (size_t i = 0; i < n; i++) {
        for (unsigned r = vr[i], end = r + (r == 0 || r == 2000 ? m->used : 1); r < end; r++, v++) {
            if (sets ? set(m, &r, 1, v) : get(m, &r, 1, v)) return 3;
        }
    }
    return 0;
}
int fmi3GetFloat64(model *m, const unsigned *vr, size_t n, double *v, size_t k) { return each(m, vr, n, v, false); }
int fmi3SetFloat64(model *m, const unsigned *vr, size_t n, const double *v, size_t k) { return each(m, vr, n, (double *)v, true); }
int fmi3SetInt32(model *m, const unsigned *vr, size_t n, const int *v, size_t k) { return set_whole(m, vr, n, v); }
int fmi3GetInt32(model *m, const unsigned *vr, size_t n, int *v, size_t k) { for (size_t i = 0; i < n; i++) v[i] = *whole(m, vr[i]); return 0; }
int fmi3UpdateDiscreteStates(model *m, bool *again, bool *ends, bool *nominals, bool *values, bool *has_next, double *next) {
    IN(E)
    *again = event(m);
    AFTER(BAD_UPDATE, 0)
    *ends = m->fault == END_EVENT && m->count > 1 || m->fault == END_START;
    *nominals = *values = false;
    *has_next = m->kind == TICKS;
    *next = m->next;
    return 0;
}
int fmi3CompletedIntegratorStep(model *m, bool no_prior, bool *enter, bool *ends) {
    int told[2];
    int status = completed(m, told, told + 1);
    *enter = told[0];
    *ends = told[1];
    return status;
}
int fmi3GetContinuousStateDerivatives(model *m, double *dx, size_t n) { return get_rates(m, dx); }
int fmi3GetNumberOfContinuousStates(model *m, size_t *n) { *n = m->used + (m->fault == OTHER_STATES); return 0; }
int fmi3GetNumberOfEventIndicators(model *m, size_t *n) {
    *n = (m->kind == BALL || m->kind == BELT || m->kind == CHATTER || m->kind == STEPPED) + (m->fault == OTHER_INDICATORS);
    return 0;
}
int fmi3EnterConfigurationMode(model *m) { return 0; }
int fmi3ExitConfigurationMode(model *m) { return 0; }
int fmi3SetUInt64(model *m, const unsigned *vr, size_t n, const uint64_t *v, size_t k) {
    if (2 * *v > N) return 3;
    start(m, 2 * *v);
    return 0;
}
int fmi3GetUInt64(model *m, const unsigned *vr, size_t n, uint64_t *v, size_t k) { *v = m->used / 2; return 0; }
int fmi3GetDirectionalDerivative(model *m, const unsigned *y, size_t ny, const unsigned *u, size_t nu, const double *seed, size_t ns, double *out, size_t no) {
    return directional(m, y, no, u, ns, seed, out);
}
int fmi3GetFMUState(model *m, void **s) { return save(m, s); }
int fmi3SetFMUState(model *m, void *s) { return restore(m, s); }
int fmi3FreeFMUState(model *m, void **s) { free(*s); *s = NULL; return 0; }
int fmi3SerializedFMUStateSize(model *m, void *s, size_t *n) { *n = sizeof *m; return 0; }
int fmi3SerializeFMUState(model *m, void *s, char *b, size_t n) { memcpy(b, s, n); return 0; }
int fmi3DeserializeFMUState(model *m, const char *b, size_t n, void **s) { *s = malloc(n); memcpy(*s, b, n); return 0; }
#else
#define F(name) fmi2##name
FMI2_INSTANTIATE {
    return type == 0 ? make() : NULL;
}
FMI2_END
FMI2_SETUP {
    ((model *)c)->t = start;
    return 0;
}
int fmi2EnterInitializationMode(model *m) { return go(m, I, INITIALIZATION); }
int fmi2GetReal(model *m, const unsigned *vr, size_t n, double *v) { return get(m, vr, n, v); }
int fmi2SetReal(model *m, const unsigned *vr, size_t n, const double *v) { return set(m, vr, n, v); }
int fmi2SetInteger(model *m, const unsigned *vr, size_t n, const int *v) { return set_whole(m, vr, n, v); }
int fmi2GetInteger(model *m, const unsigned *vr, size_t n, int *v) { for (size_t i = 0; i < n; i++) v[i] = *whole(m, vr[i]); return 0; }
typedef struct { int again, ends, nominals, values, has_next; double next; } info;
int fmi2NewDiscreteStates(model *m, info *i) {
    IN(E)
    i->again = event(m);
    AFTER(BAD_UPDATE, 0)
    i->ends = m->fault == END_EVENT && m->count > 1 || m->fault == END_START;
    i->nominals = i->values = 0;
    i->has_next = m->kind == TICKS;
    i->next = m->next;
    return 0;
}
int fmi2CompletedIntegratorStep(model *m, int no_prior, int *enter, int *ends) { return completed(m, enter, ends); }
#ifndef LACKS_RATES
int fmi2GetDerivatives(model *m, double *dx, size_t n) { return get_rates(m, dx); }
#endif
int fmi2GetDirectionalDerivative(model *m, const unsigned *y, size_t ny, const unsigned *u, size_t nu, const double *seed, double *out) {
    return directional(m, y, ny, u, nu, seed, out);
}
int fmi2GetFMUstate(model *m, void **s) { return save(m, s); }
int fmi2SetFMUstate(model *m, void *s) { return restore(m, s); }
int fmi2FreeFMUstate(model *m, void **s) { free(*s); *s = NULL; return 0; }
int fmi2SerializedFMUstateSize(model *m, void *s, size_t *n) { *n = sizeof *m; return 0; }
int fmi2SerializeFMUstate(model *m, void *s, char *b, size_t n) { memcpy(b, s, n); return 0; }
int fmi2DeSerializeFMUstate(model *m, const char *b, size_t n, void **s) { *s = malloc(n); memcpy(*s, b, n); return 0; }
#endif
int F(ExitInitializationMode)(model *m) { return go(m, J, EVENT); }
int F(EnterEventMode)(model *m) { return go(m, C, EVENT); }
int F(EnterContinuousTimeMode)(model *m) { return go(m, E, CONTINUOUS); }
int F(SetTime)(model *m, double t) { return set_time(m, t); }
int F(SetContinuousStates)(model *m, const double *x, size_t n) { return set_states(m, x, n); }
int F(GetContinuousStates)(model *m, double *x, size_t n) { memcpy(x, m->x, n * sizeof *x); return 0; }
int F(GetEventIndicators)(model *m, double *z, size_t n) {
    IN(J | E | C)
    AFTER(BAD_INDICATOR, 0.3)
    if (m->fault != NO_INDICATOR) indicators(m, z);
    if (m->fault == MANY_INDICATORS) z[1] = 0;
    return 0;
}
int F(GetNominalsOfContinuousStates)(model *m, double *x, size_t n) {
    for (size_t i = 0; i < n; i++) x[i] = i || m->fault < INF_NOMINAL || m->fault > NAN_NOMINAL ? 1 : m->fault == INF_NOMINAL ? INFINITY : NAN;
    return m->fault == BAD_NOMINAL ? 3 : 0;
}
