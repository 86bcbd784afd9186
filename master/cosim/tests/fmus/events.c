/* An FMU of FMI 3.0 that is strict about Event Mode. It is not made without; it refuses clocked variables while their clock is not active,
   discrete inputs that change in Step Mode, gets after sets in Step Mode, and ticks at a wrong time. What its variables are is said by the
   description that a test gives it; value references:

   1, 2    clocks; 1 ticks every `period` (6) from the start on, or when the FMU says; 2 is due `delay` (7) after each change of `level`
   6, 7    period, delay; 8: time of the next early return; 9: shift of clock 1
   10      u, clocked by 1; 11: y = 2 u, clocked by 1; 12: ticks of 1; 13: ticks of 2, each clocked by its clock
   20      level, a discrete input; 21: what it was at the last event; 22: x, the integral of `rate`, which is 1 and doubles at early returns
   23      number of calls of fmi3DoStep
   30, 31  Int64 in and out; 32, 33: UInt64; 34, 35: Int32; 40, 41: String; 42, 43: Binary; 50 to 52: a temperature; 60, 61: two numbers in and out */
#include <math.h>

#include "fmu.h"

typedef struct {
    logger3 log;
    void *environment;
    enum { INITIALIZATION, EVENT, STEP } mode;
    bool active[3], was_set, returns_early, is_late, level_changed, told;
    double start, time, period, delay, early, shift, u, x, rate, celsius;
    int ticks[3], level, seen, steps, small;
    int64_t whole;
    uint64_t natural;
    char text[64];
    uint8_t bytes[64];
    size_t size;
    double pair[2];
} events;

static int refuse(events *e, const char *why) {
    char text[128];
    snprintf(text, sizeof text, "%s at %.9g s", why, e->time);
    e->log(e->environment, 3, "", text);
    return 3;
}

FMI3_INSTANTIATE {
    events *e = calloc(1, sizeof *e);
    e->log = log, e->environment = environment;
    e->returns_early = early;
    e->period = 0.25, e->delay = 0.1, e->early = 1e9, e->rate = 1;
    if (event_mode) return e;
    log(environment, 3, "", "this FMU needs Event Mode");
    free(e);
    return NULL;
}
FMI3_END
FMI3_ENTER {
    ((events *)c)->start = ((events *)c)->time = start;
    return 0;
}
int fmi3ExitInitializationMode(void *c) {
    ((events *)c)->mode = EVENT;
    return 0;
}
int fmi3GetFMUState(void *c, void **state) {
    if (!*state) *state = malloc(sizeof(events));
    memcpy(*state, c, sizeof(events));
    return 0;
}
int fmi3SetFMUState(void *c, void *state) {
    memcpy(c, state, sizeof(events));
    return 0;
}
int fmi3FreeFMUState(void *c, void **state) {
    free(*state);
    *state = NULL;
    return 0;
}
int fmi3EnterEventMode(void *c) {
    events *e = c;
    if (e->mode != STEP) return refuse(e, "Event Mode is entered twice");
    e->mode = EVENT, e->was_set = false;
    return 0;
}
int fmi3EnterStepMode(void *c) {
    events *e = c;
    if (e->mode != EVENT) return refuse(e, "Step Mode is entered twice");
    e->mode = STEP;
    return 0;
}
int fmi3SetClock(void *c, const unsigned *vr, size_t n, const bool *on) {
    events *e = c;
    if (e->mode != EVENT) return refuse(e, "a clock ticks outside of Event Mode");
    for (size_t k = 0; k < n; k++) e->active[vr[k]] = on[k];
    return 0;
}
int fmi3GetIntervalDecimal(void *c, const unsigned *vr, size_t n, double *interval, int *qualifier) {
    events *e = c;
    if (e->mode == STEP) return refuse(e, "an interval is asked for in Step Mode");
    *interval = *vr == 1 ? e->period : e->delay;
    *qualifier = *vr == 1 ? (e->mode == INITIALIZATION || e->told ? 2 : 1) : e->level_changed ? 2 : 0;
    e->level_changed = e->told = false;
    return 0;
}
int fmi3GetShiftDecimal(void *c, const unsigned *vr, size_t n, double *shift) {
    *shift = ((events *)c)->shift;
    return 0;
}
FMI3_UPDATE {
    events *e = c;
    if (e->mode != EVENT) return refuse(e, "an update outside of Event Mode");
    *again = *ends = *nominals = *values = *has_next = false;
    for (int k = 1; k < 3; k++) {
        if (e->active[k]) e->ticks[k]++;
        e->active[k] = false;
    }
    if (e->is_late) e->rate *= 2, e->is_late = false;
    if (e->seen != e->level) {
        e->seen = e->level, e->level_changed = true;
        *again = true; /* once more, for nothing */
    }
    return 0;
}
FMI3_STEP {
    events *e = c;
    double end = t + h;
    if (e->mode != STEP) return refuse(e, "a step outside of Step Mode");
    if (fabs(t - e->time) > 1e-9) return refuse(e, "a step from another time");
    e->steps++;
    *event = *ends = *early = e->is_late = e->returns_early && e->early < end - 1e-9;
    *ends = false;
    if (*early) end = e->early, e->early = 1e9;
    e->x += e->rate * (end - e->time);
    e->time = *last = end, e->was_set = false;
    return 0;
}

static int check(events *e, unsigned vr, bool sets) {
    int clock = vr == 13 ? 2 : vr >= 10 && vr <= 12 ? 1 : 0;
    if (clock && e->mode != INITIALIZATION && !e->active[clock]) return refuse(e, "a variable of a clock that is not active");
    if (sets && e->mode == STEP) e->was_set = true;
    if (!sets && e->was_set) return refuse(e, "a get after a set in Step Mode");
    return 0;
}
#define CHECKED(vr, sets)                                                                          \
    do {                                                                                           \
        int status = check(e, vr, sets);                                                           \
        if (status) return status;                                                                 \
    } while (0)

static double *real(events *e, unsigned vr) {
    switch (vr) {
        case 6: return &e->period;
        case 7: return &e->delay;
        case 8: return &e->early;
        case 9: return &e->shift;
        case 10: return &e->u;
        case 50: case 51: case 52: return &e->celsius;
        default: return &e->x;
    }
}
int fmi3GetFloat64(void *c, const unsigned *vr, size_t n, double *value, size_t count) {
    events *e = c;
    for (size_t k = 0; k < n; k++) {
        CHECKED(vr[k], false);
        if (vr[k] == 61) memcpy(value, e->pair, sizeof e->pair), value += 2;
        else *value++ = vr[k] == 11 ? 2 * e->u : *real(e, vr[k]);
    }
    return 0;
}
int fmi3SetFloat64(void *c, const unsigned *vr, size_t n, const double *value, size_t count) {
    events *e = c;
    for (size_t k = 0; k < n; k++) {
        CHECKED(vr[k], true);
        if (vr[k] == 60) memcpy(e->pair, value, sizeof e->pair), value += 2;
        else *real(e, vr[k]) = *value++;
    }
    return 0;
}
int fmi3GetInt32(void *c, const unsigned *vr, size_t n, int32_t *value, size_t count) {
    events *e = c;
    for (size_t k = 0; k < n; k++) {
        unsigned r = vr[k];
        CHECKED(r, false);
        value[k] = r == 12 ? e->ticks[1] + e->active[1] : r == 13 ? e->ticks[2] + e->active[2] : r == 20 ? e->level : r == 21 ? e->seen
                 : r == 23 ? e->steps : e->small;
    }
    return 0;
}
int fmi3SetInt32(void *c, const unsigned *vr, size_t n, const int32_t *value, size_t count) {
    events *e = c;
    for (size_t k = 0; k < n; k++) {
        CHECKED(vr[k], true);
        int *into = vr[k] == 20 ? &e->level : &e->small;
        if (e->mode == STEP && *into != value[k]) return refuse(e, "a discrete input changes in Step Mode");
        *into = value[k];
    }
    return 0;
}
int fmi3GetInt64(void *c, const unsigned *vr, size_t n, int64_t *value, size_t count) {
    *value = ((events *)c)->whole;
    return 0;
}
int fmi3SetInt64(void *c, const unsigned *vr, size_t n, const int64_t *value, size_t count) {
    events *e = c;
    if (e->mode == STEP && e->whole != *value) return refuse(e, "a discrete input changes in Step Mode");
    e->whole = *value;
    return 0;
}
int fmi3GetUInt64(void *c, const unsigned *vr, size_t n, uint64_t *value, size_t count) {
    *value = ((events *)c)->natural;
    return 0;
}
int fmi3SetUInt64(void *c, const unsigned *vr, size_t n, const uint64_t *value, size_t count) {
    ((events *)c)->natural = *value;
    return 0;
}
int fmi3GetString(void *c, const unsigned *vr, size_t n, const char **value, size_t count) {
    *value = ((events *)c)->text;
    return 0;
}
int fmi3SetString(void *c, const unsigned *vr, size_t n, const char *const *value, size_t count) {
    events *e = c;
    if (e->mode == STEP && strcmp(e->text, *value)) return refuse(e, "a discrete input changes in Step Mode");
    strncpy(e->text, *value, 63);
    return 0;
}
int fmi3GetBinary(void *c, const unsigned *vr, size_t n, size_t *size, const uint8_t **value, size_t count) {
    *size = ((events *)c)->size, *value = ((events *)c)->bytes;
    return 0;
}
int fmi3SetBinary(void *c, const unsigned *vr, size_t n, const size_t *size, const uint8_t *const *value, size_t count) {
    events *e = c;
    e->size = *size < 64 ? *size : 64;
    memcpy(e->bytes, *value, e->size);
    return 0;
}
