/* FMI 2.0 co-simulation FMU of a first-order lag, T dy/dt = u - y, and z = k u; by the book, unless it is compiled with one of the
 * mistakes that `cargo fmu check` must find: -DMISTAKE=NAN_OUTPUT and so on.
 * Value references: Real 0 u (input), 1 T (fixed parameter), 2 k (tunable parameter), 3 y, 4 z (outputs). */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum {
    NONE, VERSION, ANY_GUID, PLAIN_PATHS, FREE_NULL, CRASH, NAN_OUTPUT, EXACT_GRID, START_AT_0, NO_STOP, ONE_SIZE, MUTE_AT_END,
    OTHER_START, ROUNDED, FEEDTHROUGH, GLOBAL, SHARED, FEW, ONE_THREAD, HALF_RESET, HALF_STATE, HALF_BYTES, NO_CHECKSUM,
    WRONG_SLOPE, NO_DERIVATIVE, NO_INPUT_DERIVATIVE, ANY_REFERENCE, ANY_NUMBER, WRITABLE, ANY_STEP, NULL_CRASH, ANY_ORDER,
    CATEGORY, CHATTER, PRINT, OTHER_ENVIRONMENT, NOWHERE, NO_STRINGS, NO_INSTANCE, HANG,
    ENDS_AT_STOP, ENDS_AT_ERROR, WILD_REFERENCE, CRASH_AT_Z,
    /* no mistakes: FMI 2.0 (4.2.4) lets no other values be read in Initialization Mode, and none between a set and a step */
    STRICT_START, STRICT_ORDER,
    /* of lag3.c */
    WRONG_TRANSPOSE, UNASKED_RETURN, WRONG_TIME, ANY_COUNT, HIDDEN_DEPENDENCY, ANY_ELEMENT,
    NO_EVENTS /* no mistake, if the description says so */
};
#ifndef MISTAKE
#define MISTAKE NONE
#endif
#define IS(mistake) (MISTAKE == mistake)

enum { OK, WARNING, DISCARD, ERROR };
enum { INSTANTIATED = 1, INITIALIZATION = 2, STEPPING = 4, TERMINATED = 8 };
enum { U, T, K, Y, Z, COUNT };
#define GUID "{7b1f0c52-8f0e-4b7c-9a57-5d1e0f6a2c11}"

typedef void (*Logger)(void *, const char *, int, const char *, const char *, ...);
typedef struct {
    Logger logger;
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void *finished, *environment;
} Callbacks;

typedef struct {
    double value[COUNT], time, stop, h;
    int mode, has_stop, is_set;
    int mode_3; /* of lag3.c */
} Model;

typedef struct {
    Model model;
    const Callbacks *callbacks;
    char name[64];
    int logging;
} Instance;

typedef struct {
    Model model;
    unsigned sum;
} State;

static int instances, steps;
static double shared_u;

static void begin(Model *m) {
    double y = m->value[Y];
    memset(m, 0, sizeof *m);
    m->value[T] = IS(OTHER_START) ? 0.6 : 0.5;
    m->value[K] = 2;
    if (IS(HALF_RESET))
        m->value[Y] = y;
    m->mode = INSTANTIATED;
}

static int tell(Instance *s, int status, const char *text) {
    const char *category = IS(CATEGORY) ? "trouble" : status == OK ? "logEvents" : "logStatusError";
    void *environment = IS(OTHER_ENVIRONMENT) ? s : s->callbacks->environment;
    if (IS(NOWHERE))
        category = (const char *)8;
    if (status != OK || s->logging || IS(CHATTER))
        s->callbacks->logger(environment, s->name, status, category, "%s", text);
    return status;
}

#define FROM(modes)                                                                                                            \
    Instance *s = c;                                                                                                           \
    if (!IS(NULL_CRASH) && !s)                                                                                                 \
        return ERROR;                                                                                                          \
    if (!(s->model.mode & (modes)) && !IS(ANY_ORDER))                                                                          \
        return tell(s, ERROR, "out of order");

const char *fmi2GetVersion(void) { return IS(VERSION) ? "1.0" : "2.0"; }
const char *fmi2GetTypesPlatform(void) { return "default"; }

void *fmi2Instantiate(const char *name, int kind, const char *guid, const char *resources, const Callbacks *callbacks,
                      int visible, int logging) {
    (void)visible;
    if (kind != 1 || (strcmp(guid, GUID) && !IS(ANY_GUID)) || (IS(PLAIN_PATHS) && strpbrk(resources, "% ")))
        return NULL;
    if (IS(NO_INSTANCE) || (IS(FEW) && instances >= 4))
        return NULL;
    Instance *s = callbacks->allocate(1, sizeof *s);
    begin(&s->model);
    s->callbacks = callbacks;
    s->logging = logging;
    strncpy(s->name, name, sizeof s->name - 1);
    instances++;
    tell(s, OK, "made");
    if (IS(PRINT))
        puts("made");
    return s;
}

void fmi2FreeInstance(void *c) {
    Instance *s = c;
    if (!s && !IS(FREE_NULL))
        return;
    instances--;
    s->callbacks->release(s);
}

int fmi2SetDebugLogging(void *c, int on, size_t n, const char *const *categories) {
    (void)n, (void)categories;
    FROM(15)
    s->logging = on;
    return OK;
}

int fmi2SetupExperiment(void *c, int has_tolerance, double tolerance, double start, int has_stop, double stop) {
    (void)has_tolerance, (void)tolerance;
    FROM(INSTANTIATED)
    if (IS(START_AT_0) && start != 0)
        return tell(s, ERROR, "starts at 0 only");
    s->model.time = start;
    s->model.has_stop = has_stop && !IS(NO_STOP);
    s->model.stop = stop;
    return OK;
}

int fmi2EnterInitializationMode(void *c) {
    FROM(INSTANTIATED)
    s->model.mode = INITIALIZATION;
    return OK;
}
int fmi2ExitInitializationMode(void *c) {
    FROM(INITIALIZATION)
    s->model.mode = STEPPING;
    return OK;
}
int fmi2Terminate(void *c) {
    FROM(STEPPING)
    s->model.mode = TERMINATED;
    return OK;
}
int fmi2Reset(void *c) {
    FROM(15)
    begin(&s->model);
    return OK;
}

int fmi2GetReal(void *c, const unsigned *vr, size_t n, double *value) {
    FROM(INITIALIZATION | STEPPING | (IS(MUTE_AT_END) ? 0 : TERMINATED))
    if (!IS(NULL_CRASH) && n && (!vr || !value))
        return tell(s, ERROR, "NULL");
    Model *m = &s->model;
    if (IS(STRICT_ORDER) && m->mode == STEPPING && m->is_set)
        return tell(s, ERROR, "get after set");
    for (size_t k = 0; k < n; k++)
        if (IS(WILD_REFERENCE) && vr[k] >= COUNT)
            *(volatile int *)8 = 0;
        else if (IS(CRASH_AT_Z) && vr[k] == Z)
            *(volatile int *)8 = 0;
        else if (IS(STRICT_START) && m->mode == INITIALIZATION && vr[k] < Y)
            return tell(s, ERROR, "no unknown of the initialization");
    for (size_t k = 0; k < n; k++)
        if (vr[k] >= COUNT && !IS(ANY_REFERENCE))
            return tell(s, ERROR, "unknown value reference");
    for (size_t k = 0; k < n; k++) {
        value[k] = vr[k] >= COUNT ? 0 : vr[k] == Z ? m->value[K] * m->value[U] : m->value[vr[k]];
        if (IS(FEEDTHROUGH) && vr[k] == Y)
            value[k] += m->value[U];
        if (IS(NAN_OUTPUT) && vr[k] == Y && m->time > 0.3)
            value[k] = NAN;
    }
    return OK;
}

int fmi2SetReal(void *c, const unsigned *vr, size_t n, const double *value) {
    FROM(INSTANTIATED | INITIALIZATION | STEPPING)
    if (!IS(NULL_CRASH) && n && (!vr || !value))
        return tell(s, ERROR, "NULL");
    for (size_t k = 0; k < n; k++) {
        int is_settable = vr[k] == U || vr[k] == K || (vr[k] == T && s->model.mode != STEPPING);
        if (vr[k] >= COUNT ? !IS(ANY_REFERENCE) && !IS(WILD_REFERENCE) : !is_settable && !IS(WRITABLE))
            return tell(s, ERROR, "cannot be set");
        if (!isfinite(value[k]) && !IS(ANY_NUMBER))
            return tell(s, ERROR, "no number");
    }
    for (size_t k = 0; k < n; k++)
        if (vr[k] < COUNT)
            s->model.value[vr[k]] = IS(ROUNDED) ? (float)value[k] : value[k];
    if (IS(WILD_REFERENCE) && n && vr[0] >= COUNT)
        *(volatile int *)8 = 0;
    s->model.is_set = 1;
    if (n)
        shared_u = s->model.value[U];
    return OK;
}

#define NOTHING_OF_THIS_TYPE(get, set, type)                                                                                   \
    int get(void *c, const unsigned *vr, size_t n, type *value) {                                                              \
        (void)vr, (void)value;                                                                                                 \
        FROM(INITIALIZATION | STEPPING | TERMINATED)                                                                           \
        return (n && !IS(ANY_REFERENCE)) || IS(NO_STRINGS) ? tell(s, ERROR, "unknown value reference") : OK;                   \
    }                                                                                                                          \
    int set(void *c, const unsigned *vr, size_t n, const type *value) {                                                        \
        (void)vr, (void)value;                                                                                                 \
        FROM(INSTANTIATED | INITIALIZATION | STEPPING)                                                                         \
        return n && !IS(ANY_REFERENCE) ? tell(s, ERROR, "unknown value reference") : OK;                                       \
    }
NOTHING_OF_THIS_TYPE(fmi2GetInteger, fmi2SetInteger, int)
NOTHING_OF_THIS_TYPE(fmi2GetBoolean, fmi2SetBoolean, int)
#ifndef WITHOUT_STRINGS
NOTHING_OF_THIS_TYPE(fmi2GetString, fmi2SetString, const char *)
#endif

int fmi2DoStep(void *c, double t, double h, int no_set_prior) {
    (void)no_set_prior;
    static volatile int inside;
    FROM(STEPPING)
    Model *m = &s->model;
    double tolerance = IS(EXACT_GRID) ? 0 : 1e-6 * h;
    if (!IS(ANY_STEP) && (!(isfinite(h) && h > 0) || !(fabs(t - m->time) <= tolerance)))
        return tell(s, ERROR, "wrong step");
    if (m->has_stop && t + h > m->stop + 1e-6 * h)
        return tell(s, ERROR, "beyond the stop time");
    if (IS(ONE_SIZE) && m->h != 0 && fabs(h - m->h) > 1e-9)
        return tell(s, ERROR, "steps of one size only");
    if (IS(CRASH))
        *(volatile int *)8 = 0;
    if (IS(ENDS_AT_STOP) && t + h > 0.2 + 1e-6)
        return tell(s, ERROR, "no data for later times");
    while (IS(HANG))
        sleep(1);
    if (IS(ONE_THREAD)) {
        if (inside)
            return tell(s, ERROR, "one thread only");
        inside = 1;
        usleep(2000);
        inside = 0;
    }
    double u = IS(SHARED) ? shared_u : m->value[U];
    if (IS(GLOBAL))
        u += 1e-3 * steps++;
    m->value[Y] = u + (m->value[Y] - u) * exp(-h / m->value[T]);
    m->h = h;
    m->is_set = 0;
    m->time = IS(EXACT_GRID) ? m->time + h : t + h;
    return OK;
}

int fmi2GetFMUstate(void *c, void **state) {
    FROM(15)
    if (!*state)
        *state = calloc(1, sizeof(State));
    ((State *)*state)->model = s->model;
    return OK;
}
int fmi2SetFMUstate(void *c, void *state) {
    FROM(15)
    double y = s->model.value[Y];
    s->model = ((State *)state)->model;
    if (IS(HALF_STATE))
        s->model.value[Y] = y;
    return OK;
}
int fmi2FreeFMUstate(void *c, void **state) {
    FROM(15)
    free(*state);
    *state = NULL;
    return OK;
}
int fmi2SerializedFMUstateSize(void *c, void *state, size_t *size) {
    (void)state;
    FROM(15)
    *size = sizeof(State);
    return OK;
}
static unsigned sum(const Model *m) {
    unsigned total = 1;
    for (size_t k = 0; k < sizeof *m; k++)
        total = total * 31 + ((const unsigned char *)m)[k];
    return total;
}
int fmi2SerializeFMUstate(void *c, void *state, char *bytes, size_t size) {
    FROM(15)
    State copy = *(State *)state;
    if (size != sizeof copy)
        return tell(s, ERROR, "size");
    if (IS(HALF_BYTES))
        copy.model.value[Y] = 0;
    copy.sum = sum(&copy.model);
    memcpy(bytes, &copy, size);
    return OK;
}
int fmi2DeSerializeFMUstate(void *c, const char *bytes, size_t size, void **state) {
    FROM(15)
    State copy;
    if (size != sizeof copy)
        return tell(s, ERROR, "size");
    memcpy(&copy, bytes, size);
    if (copy.sum != sum(&copy.model) && !IS(NO_CHECKSUM)) {
        if (IS(ENDS_AT_ERROR))
            s->model.mode = TERMINATED;
        return tell(s, ERROR, "damaged");
    }
    *state = calloc(1, sizeof copy);
    memcpy(*state, &copy, size);
    return OK;
}

int fmi2GetDirectionalDerivative(void *c, const unsigned *unknown, size_t n, const unsigned *known, size_t m, const double *seed,
                                 double *result) {
    FROM(INITIALIZATION | STEPPING | TERMINATED)
    for (size_t k = 0; k < n; k++) {
        result[k] = 0;
        for (size_t j = 0; j < m; j++)
            if (unknown[k] == Z && known[j] == U)
                result[k] += (IS(WRONG_SLOPE) ? 1.1 : 1) * s->model.value[K] * seed[j];
    }
    return OK;
}
int fmi2SetRealInputDerivatives(void *c, const unsigned *vr, size_t n, const int *order, const double *value) {
    (void)vr, (void)n, (void)order, (void)value;
    FROM(INSTANTIATED | INITIALIZATION | STEPPING)
    return IS(NO_INPUT_DERIVATIVE) ? tell(s, ERROR, "not here") : OK;
}
int fmi2GetRealOutputDerivatives(void *c, const unsigned *vr, size_t n, const int *order, double *value) {
    (void)order;
    FROM(STEPPING | TERMINATED)
    const double *v = s->model.value;
    for (size_t k = 0; k < n; k++)
        value[k] = vr[k] == Y ? (v[U] - v[Y]) / v[T] : 0;
    return IS(NO_DERIVATIVE) ? tell(s, ERROR, "not here") : OK;
}

int fmi2CancelStep(void *c) {
    FROM(STEPPING)
    return tell(s, ERROR, "steps are never pending");
}
#define NO_STATUS(name, type)                                                                                                  \
    int name(void *c, int kind, type *value) {                                                                                 \
        (void)kind, (void)value;                                                                                               \
        FROM(STEPPING | TERMINATED)                                                                                            \
        return DISCARD;                                                                                                        \
    }
NO_STATUS(fmi2GetStatus, int)
NO_STATUS(fmi2GetRealStatus, double)
NO_STATUS(fmi2GetIntegerStatus, int)
NO_STATUS(fmi2GetBooleanStatus, int)
NO_STATUS(fmi2GetStringStatus, const char *)
