/* The FMU of lag.c in FMI 3.0: with its mistakes, and with those that only FMI 3.0 can make.
 * Value references are those of lag.c; 9 is time. */
#include <stdarg.h>
#include <stdbool.h>
#include <stdint.h>

#include "lag.c"

enum { EVENT = 16, AFTER_SET = 32, EVERY = 63, TIME = 9 };
#define RUNNING (EVENT | STEPPING | AFTER_SET)

typedef void (*Logger3)(void *, int, const char *, const char *);
typedef struct {
    Callbacks callbacks; /* first: lag.c keeps a pointer to it */
    Logger3 logger;
    void *environment;
    bool logging;
} Importer;

/* The logger of FMI 2.0; nothing is told while logging is off. */
static void pass_on(void *environment, const char *name, int status, const char *category, const char *format, ...) {
    (void)name;
    const Importer *importer = environment;
    char text[200];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    if (importer->logger && (importer->logging || IS(CHATTER)))
        importer->logger(importer->environment, status, category, text);
}

#define IN(modes)                                                                                                              \
    Instance *s = c;                                                                                                           \
    if (!IS(NULL_CRASH) && !s)                                                                                                 \
        return ERROR;                                                                                                          \
    if (!(s->model.mode_3 & (modes)) && !IS(ANY_ORDER))                                                                        \
        return tell(s, ERROR, "out of order");                                                                                 \
    Model *m = &s->model;                                                                                                      \
    (void)m;

const char *fmi3GetVersion(void) { return IS(VERSION) ? "2.0" : "3.0"; }

void *fmi3InstantiateCoSimulation(const char *name, const char *token, const char *resources, bool visible, bool logging,
                                  bool events, bool early, const unsigned *intermediate, size_t n, void *environment,
                                  Logger3 logger, void *update) {
    (void)events, (void)early, (void)intermediate, (void)n, (void)update;
    Importer *importer = calloc(1, sizeof *importer);
    *importer = (Importer){{pass_on, calloc, free, NULL, importer}, logger, environment, logging};
    Instance *s = fmi2Instantiate(name, 1, token, resources, &importer->callbacks, visible, logging);
    if (!s)
        return free(importer), NULL;
    s->model.mode_3 = INSTANTIATED;
    return s;
}
void *fmi3InstantiateModelExchange(void) { return NULL; }
void *fmi3InstantiateScheduledExecution(void) { return NULL; }

void fmi3FreeInstance(void *c) {
    Instance *s = c;
    void *importer = s || IS(FREE_NULL) ? (void *)s->callbacks : NULL;
    fmi2FreeInstance(s);
    free(importer);
}
int fmi3SetDebugLogging(void *c, bool on, size_t n, const char *const *categories) {
    (void)n, (void)categories;
    IN(EVERY)
    s->logging = ((Importer *)s->callbacks)->logging = on;
    return OK;
}

#define MOVE(modes, before, call, after)                                                                                       \
    IN(modes)                                                                                                                  \
    m->mode = before;                                                                                                          \
    int status = call;                                                                                                         \
    if (status == OK)                                                                                                          \
        m->mode_3 = after;                                                                                                     \
    return status;

int fmi3EnterInitializationMode(void *c, bool has_tolerance, double tolerance, double start, bool has_stop, double stop) {
    IN(INSTANTIATED)
    m->mode = INSTANTIATED;
    int status = fmi2SetupExperiment(s, has_tolerance, tolerance, start, has_stop, stop);
    if (status == OK)
        status = fmi2EnterInitializationMode(s);
    if (status == OK)
        m->mode_3 = INITIALIZATION;
    return status;
}
int fmi3ExitInitializationMode(void *c) { MOVE(INITIALIZATION, INITIALIZATION, fmi2ExitInitializationMode(s), IS(NO_EVENTS) ? STEPPING : EVENT) }
int fmi3EnterEventMode(void *c) { MOVE(IS(NO_EVENTS) ? 0 : STEPPING | AFTER_SET, STEPPING, OK, EVENT) }
int fmi3EnterStepMode(void *c) { MOVE(EVENT, STEPPING, OK, STEPPING) }
int fmi3EvaluateDiscreteStates(void *c) { MOVE(EVENT, STEPPING, OK, EVENT) }
int fmi3Terminate(void *c) { MOVE(RUNNING, STEPPING, fmi2Terminate(s), TERMINATED) }
int fmi3Reset(void *c) { MOVE(EVERY, m->mode, fmi2Reset(s), INSTANTIATED) }
int fmi3EnterConfigurationMode(void *c) { IN(0) return OK; }
int fmi3ExitConfigurationMode(void *c) { IN(0) return OK; }
int fmi3UpdateDiscreteStates(void *c, bool *again, bool *end, bool *nominals, bool *values, bool *next, double *time) {
    IN(EVENT)
    *again = *end = *nominals = *values = *next = false;
    *time = 0;
    return OK;
}

#define CHECK_COUNT                                                                                                            \
    if (!IS(NULL_CRASH) && n && (!vr || !value))                                                                               \
        return tell(s, ERROR, "NULL");                                                                                         \
    if (count != n && !IS(ANY_COUNT))                                                                                          \
        return tell(s, ERROR, "wrong number of values");

int fmi3GetFloat64(void *c, const unsigned *vr, size_t n, double *value, size_t count) {
    IN(INSTANTIATED | INITIALIZATION | EVENT | STEPPING | (IS(MUTE_AT_END) ? 0 : TERMINATED))
    CHECK_COUNT
    for (size_t k = 0; k < n; k++) {
        int mode = m->mode;
        m->mode = STEPPING;
        int status = vr[k] == TIME ? OK : fmi2GetReal(s, vr + k, 1, value + k);
        m->mode = mode;
        if (vr[k] == TIME)
            value[k] = m->time;
        if (status != OK)
            return status;
    }
    return OK;
}
int fmi3SetFloat64(void *c, const unsigned *vr, size_t n, const double *value, size_t count) {
    IN(INSTANTIATED | INITIALIZATION | RUNNING)
    CHECK_COUNT
    int status = fmi2SetReal(s, vr, n, value);
    if (status == OK && n && m->mode_3 == STEPPING)
        m->mode_3 = AFTER_SET;
    return status;
}
#define NO_VALUES(type, c_type)                                                                                                \
    int fmi3Get##type(void *c, const unsigned *vr, size_t n, c_type *value, size_t count) {                             \
        IN(EVERY & ~AFTER_SET)                                                                                                 \
        (void)vr, (void)value, (void)count;                                                                                    \
        return n && !IS(ANY_REFERENCE) ? tell(s, ERROR, "unknown value reference") : OK;                                       \
    }                                                                                                                          \
    int fmi3Set##type(void *c, const unsigned *vr, size_t n, const c_type *value, size_t count) {                       \
        IN(EVERY & ~TERMINATED)                                                                                                \
        (void)vr, (void)value, (void)count;                                                                                    \
        return n && !IS(ANY_REFERENCE) ? tell(s, ERROR, "unknown value reference") : OK;                                       \
    }
NO_VALUES(Float32, float) NO_VALUES(Int8, int8_t) NO_VALUES(UInt8, uint8_t) NO_VALUES(Int16, int16_t) NO_VALUES(UInt16, uint16_t)
NO_VALUES(Int32, int32_t) NO_VALUES(UInt32, uint32_t) NO_VALUES(Int64, int64_t) NO_VALUES(UInt64, uint64_t)
NO_VALUES(Boolean, bool) NO_VALUES(String, const char *)

#define NONE_OF_IT(name)                                                                                                       \
    int name(void *c, const unsigned *vr, size_t n) {                                                                   \
        IN(EVERY)                                                                                                              \
        (void)vr;                                                                                                              \
        return n ? tell(s, ERROR, "unknown value reference") : OK;                                                             \
    }
NONE_OF_IT(fmi3GetBinary) NONE_OF_IT(fmi3SetBinary) NONE_OF_IT(fmi3GetClock) NONE_OF_IT(fmi3SetClock)
NONE_OF_IT(fmi3GetIntervalDecimal) NONE_OF_IT(fmi3GetIntervalFraction) NONE_OF_IT(fmi3GetShiftDecimal)
NONE_OF_IT(fmi3GetShiftFraction) NONE_OF_IT(fmi3SetIntervalDecimal) NONE_OF_IT(fmi3SetIntervalFraction)
NONE_OF_IT(fmi3SetShiftDecimal) NONE_OF_IT(fmi3SetShiftFraction)

/* z depends on u and k; nothing else on anything at once. */
static const unsigned Z_DEPENDS[] = {U, K, T};
int fmi3GetNumberOfVariableDependencies(void *c, unsigned vr, size_t *n) {
    IN(EVERY)
    if (vr >= COUNT)
        return tell(s, ERROR, "unknown value reference");
    *n = vr != Z ? 0 : IS(HIDDEN_DEPENDENCY) ? 3 : 2;
    return OK;
}
int fmi3GetVariableDependencies(void *c, unsigned vr, size_t *of, unsigned *on, size_t *elements, int *kinds, size_t n) {
    IN(EVERY)
    (void)vr;
    for (size_t k = 0; k < n; k++) /* elements count from 1; 0 is all of them */
        of[k] = IS(ANY_ELEMENT) ? 2 : 1, elements[k] = 0, on[k] = Z_DEPENDS[k], kinds[k] = 1;
    return OK;
}

int fmi3GetFMUState(void *c, void **state) { IN(EVERY) return fmi2GetFMUstate(s, state); }
int fmi3SetFMUState(void *c, void *state) { IN(EVERY) return fmi2SetFMUstate(s, state); }
int fmi3FreeFMUState(void *c, void **state) { IN(EVERY) return fmi2FreeFMUstate(s, state); }
int fmi3SerializedFMUStateSize(void *c, void *state, size_t *size) {
    IN(EVERY)
    return fmi2SerializedFMUstateSize(s, state, size);
}
int fmi3SerializeFMUState(void *c, void *state, char *bytes, size_t size) {
    IN(EVERY)
    return fmi2SerializeFMUstate(s, state, bytes, size);
}
int fmi3DeserializeFMUState(void *c, const char *bytes, size_t size, void **state) {
    IN(EVERY)
    return fmi2DeSerializeFMUstate(s, bytes, size, state);
}

int fmi3GetDirectionalDerivative(void *c, const unsigned *unknown, size_t n, const unsigned *known, size_t m_known,
                                 const double *seed, size_t n_seed, double *result, size_t n_result) {
    IN(INITIALIZATION | RUNNING | TERMINATED)
    (void)n_seed, (void)n_result;
    return fmi2GetDirectionalDerivative(s, unknown, n, known, m_known, seed, result);
}
int fmi3GetAdjointDerivative(void *c, const unsigned *unknown, size_t n, const unsigned *known, size_t m_known,
                             const double *seed, size_t n_seed, double *result, size_t n_result) {
    IN(INITIALIZATION | RUNNING | TERMINATED)
    (void)n_seed, (void)n_result;
    for (size_t j = 0; j < m_known; j++) {
        result[j] = 0;
        for (size_t k = 0; k < n; k++)
            if (unknown[k] == Z && known[j] == U)
                result[j] += (IS(WRONG_TRANSPOSE) ? 1.1 : 1) * m->value[K] * seed[k];
    }
    return OK;
}
int fmi3GetOutputDerivatives(void *c, const unsigned *vr, size_t n, const int *order, double *value, size_t count) {
    IN(STEPPING | TERMINATED)
    (void)count;
    return fmi2GetRealOutputDerivatives(s, vr, n, order, value);
}

int fmi3DoStep(void *c, double t, double h, bool no_set_prior, bool *event, bool *end, bool *early, double *last) {
    IN(STEPPING | AFTER_SET)
    int status = fmi2DoStep(s, t, h, no_set_prior);
    if (status != OK)
        return status;
    m->mode_3 = STEPPING;
    *event = *end = false;
    *early = IS(UNASKED_RETURN);
    *last = IS(WRONG_TIME) ? t : m->time;
    return OK;
}
