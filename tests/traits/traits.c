/* An FMU of FMI 2.0 and of 3.0 that misbehaves where its parameters say so: the integral x of its input u, and the outputs y = k x + d u, the
   mean of k x over the last step, z = x, m = n + number of steps. From the step on that reaches the time `at` it is of the `kind` of TRAITS. */
#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum { U = 1, Y, Y_MEAN, X, K, D, AT, Z, KIND = 10, N, M };
enum { GOOD, NOT_A_NUMBER, FAILS, DISCARDS, TERMINATES, EXITS, ABORTS, CRASHES, INFINITE, Z_NOT_A_NUMBER, DESTROYS };
enum { OK, WARNING, DISCARD, ERROR, FATAL };

typedef struct {
    double u, slope, mean, x, k, d, at, last;
    int kind, n, steps;
    bool is_late, is_over;
} traits;

static traits *made(void) {
    traits *t = calloc(1, sizeof *t);
    t->k = 1, t->at = 1e9;
    return t;
}

static int step(traits *t, double time, double h) {
    t->last = time;
    t->is_late |= time + h >= t->at - 1e-9;
    if (t->is_late) switch (t->kind) {
        case FAILS: return ERROR;
        case DESTROYS: return FATAL;
        case DISCARDS: return DISCARD;
        case TERMINATES: t->is_over = true; return DISCARD;
        case EXITS: exit(0);
        case ABORTS: abort();
        case CRASHES: *(volatile int *)8 = 1;
    }
    double before = t->x;
    t->x += h * (t->u + 0.5 * h * t->slope);
    t->mean = 0.5 * (before + t->x);
    t->steps++;
    t->last = time + h;
    return OK;
}

static int get(traits *t, unsigned reference, double *value) {
    bool is_nan = t->is_late && (t->kind == NOT_A_NUMBER || (t->kind == Z_NOT_A_NUMBER && reference == Z));
    switch (reference) {
        case U: *value = t->u; return OK;
        case Y: *value = is_nan ? NAN : t->is_late && t->kind == INFINITE ? INFINITY : t->k * t->x + t->d * t->u; return OK;
        case Y_MEAN: *value = t->k * t->mean; return OK;
        case X: *value = t->x; return OK;
        case K: *value = t->k; return OK;
        case D: *value = t->d; return OK;
        case AT: *value = t->at; return OK;
        case Z: *value = is_nan && t->kind == Z_NOT_A_NUMBER ? NAN : t->x; return OK;
        default: return ERROR;
    }
}

static int set(traits *t, unsigned reference, double value) {
    switch (reference) {
        case U: t->u = value; return OK;
        case X: t->x = value; return OK;
        case K: t->k = value; return OK;
        case D: t->d = value; return OK;
        case AT: t->at = value; return OK;
        default: return ERROR;
    }
}

static int get_whole(traits *t, unsigned reference, int *value) {
    *value = reference == KIND ? t->kind : reference == N ? t->n : t->n + t->steps;
    return reference < KIND ? ERROR : OK;
}

static int set_whole(traits *t, unsigned reference, int value) {
    if (reference == KIND) t->kind = value;
    else if (reference == N) t->n = value;
    else return ERROR;
    return OK;
}

/* Input derivatives of the first order. */
static int slope(traits *t, const unsigned *reference, size_t n, const int *order, const double *value) {
    for (size_t i = 0; i < n; i++) {
        if (reference[i] != U || order[i] != 1) return ERROR;
        t->slope = value[i];
    }
    return OK;
}

/* dy/dt = k u at communication points, as far as u does not change at once. */
static int output_slope(traits *t, const unsigned *reference, size_t n, const int *order, double *value) {
    for (size_t i = 0; i < n; i++) {
        if (reference[i] != Y || order[i] != 1) return ERROR;
        value[i] = t->k * t->u;
    }
    return OK;
}

#define EACH(function) \
    int status = OK; \
    for (size_t i = 0; i < n && status == OK; i++) status = function(c, reference[i], function##_ARGUMENT(value[i])); \
    return status;
#define get_ARGUMENT(v) &v
#define get_whole_ARGUMENT(v) &v
#define set_ARGUMENT(v) v
#define set_whole_ARGUMENT(v) v

static int save(void *c, void **state) {
    if (!*state) *state = malloc(sizeof(traits));
    memcpy(*state, c, sizeof(traits));
    return OK;
}
static int restore(void *c, void *state) { memcpy(c, state, sizeof(traits)); return OK; }
static int drop(void **state) { free(*state); *state = NULL; return OK; }
static int size(size_t *n) { *n = sizeof(traits); return OK; }
static int bytes(void *state, void *to) { memcpy(to, state, sizeof(traits)); return OK; }
static int from_bytes(const void *from, size_t n, void **state) { return n == sizeof(traits) ? save((void *)from, state) : ERROR; }

void *fmi2Instantiate(const char *name, int type, const char *guid, const char *resources, const void *functions, int visible, int logging) {
    return made();
}
void fmi2FreeInstance(void *c) { free(c); }
int fmi2SetupExperiment(void *c, int has_tolerance, double tolerance, double start, int has_stop, double stop) { return OK; }
int fmi2EnterInitializationMode(void *c) { return OK; }
int fmi2ExitInitializationMode(void *c) { return OK; }
int fmi2Terminate(void *c) { return OK; }
int fmi2GetReal(void *c, const unsigned *reference, size_t n, double *value) { EACH(get) }
int fmi2SetReal(void *c, const unsigned *reference, size_t n, const double *value) { EACH(set) }
int fmi2GetInteger(void *c, const unsigned *reference, size_t n, int *value) { EACH(get_whole) }
int fmi2SetInteger(void *c, const unsigned *reference, size_t n, const int *value) { EACH(set_whole) }
int fmi2DoStep(void *c, double t, double h, int no_state) { return step(c, t, h); }
int fmi2GetRealStatus(void *c, int kind, double *value) { *value = ((traits *)c)->last; return OK; }
int fmi2GetBooleanStatus(void *c, int kind, int *value) { *value = ((traits *)c)->is_over; return OK; }
int fmi2SetRealInputDerivatives(void *c, const unsigned *reference, size_t n, const int *order, const double *value) {
    return slope(c, reference, n, order, value);
}
int fmi2GetRealOutputDerivatives(void *c, const unsigned *reference, size_t n, const int *order, double *value) {
    return output_slope(c, reference, n, order, value);
}
int fmi2GetFMUstate(void *c, void **state) { return save(c, state); }
int fmi2SetFMUstate(void *c, void *state) { return restore(c, state); }
int fmi2FreeFMUstate(void *c, void **state) { return drop(state); }
int fmi2SerializedFMUstateSize(void *c, void *state, size_t *n) { return size(n); }
int fmi2SerializeFMUstate(void *c, void *state, char *to, size_t n) { return bytes(state, to); }
int fmi2DeSerializeFMUstate(void *c, const char *from, size_t n, void **state) { return from_bytes(from, n, state); }

void *fmi3InstantiateCoSimulation(const char *name, const char *token, const char *resources, bool visible, bool logging, bool event_mode,
                                  bool early, const unsigned *required, size_t n, void *environment, void *log, void *update) {
    return made();
}
void fmi3FreeInstance(void *c) { free(c); }
int fmi3EnterInitializationMode(void *c, bool has_tolerance, double tolerance, double start, bool has_stop, double stop) { return OK; }
int fmi3ExitInitializationMode(void *c) { return OK; }
int fmi3Terminate(void *c) { return OK; }
int fmi3GetFloat64(void *c, const unsigned *reference, size_t n, double *value, size_t count) { EACH(get) }
int fmi3SetFloat64(void *c, const unsigned *reference, size_t n, const double *value, size_t count) { EACH(set) }
int fmi3GetInt32(void *c, const unsigned *reference, size_t n, int32_t *value, size_t count) { EACH(get_whole) }
int fmi3SetInt32(void *c, const unsigned *reference, size_t n, const int32_t *value, size_t count) { EACH(set_whole) }
int fmi3DoStep(void *c, double t, double h, bool no_state, bool *event, bool *over, bool *early, double *last) {
    int status = step(c, t, h);
    *event = *early = false, *over = ((traits *)c)->is_over, *last = ((traits *)c)->last;
    return *over ? OK : status;
}
int fmi3GetOutputDerivatives(void *c, const unsigned *reference, size_t n, const int32_t *order, double *value, size_t count) {
    return output_slope(c, reference, n, order, value);
}
int fmi3GetFMUState(void *c, void **state) { return save(c, state); }
int fmi3SetFMUState(void *c, void *state) { return restore(c, state); }
int fmi3FreeFMUState(void *c, void **state) { return drop(state); }
int fmi3SerializedFMUStateSize(void *c, void *state, size_t *n) { return size(n); }
int fmi3SerializeFMUState(void *c, void *state, uint8_t *to, size_t n) { return bytes(state, to); }
int fmi3DeserializeFMUState(void *c, const uint8_t *from, size_t n, void **state) { return from_bytes(from, n, state); }
