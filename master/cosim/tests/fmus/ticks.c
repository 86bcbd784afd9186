/* An FMU of FMI 3.0 with clocks that are triggered from outside and that trigger others. It is strict: it refuses clocked variables while
   their clock is not active, a clock that is set outside of Event Mode, and gets after sets in Step Mode; and it tells of a tick of its output
   clock once, and wants to be asked for it in each instant if it ever is. What its variables are is said by the description that a test gives it; value references:

   1       input clock; 2: output clock, which ticks with 1 or 3, as `mode` says; 3: clock that follows time
   10      u, clocked by 1; 11: y, clocked by 2: u + 1, or the number of its ticks if 1 is not active
   12      ticks of 1; 13: sum of u at these ticks; 14: ticks of 3; 15: ticks of 2; 16: updates of discrete states
   20      mode: 0: 2 ticks in the same instant as 1 or 3; 1: in the next one; 2: at an event that a step finds (30) only
   30      time of an event within a step, which is reported at its end, or at once where that is allowed
   31      level, a discrete input: a change is an event
   40      bytes, clocked by 1; 41: bytes, clocked by 2: as many as the ticks of 2 modulo 7, each their number */
#include <math.h>

#include "fmu.h"

typedef struct {
    logger3 log;
    void *environment;
    enum { INITIALIZATION, EVENT, STEP } mode;
    bool in, out, own, told, asked, was_set, found, early;
    double time, u, event;
    int64_t sum;
    int behaviour, ins, outs, owns, updates, level, seen;
    uint8_t received[256], sent[256];
    size_t size;
} ticks;

static int refuse(ticks *e, const char *why) {
    char text[128];
    snprintf(text, sizeof text, "%s at %.9g s", why, e->time);
    e->log(e->environment, 3, "", text);
    return 3;
}
#define REFUSED(when, why)                 \
    do {                                   \
        if (when) return refuse(c, (why)); \
    } while (0)

FMI3_INSTANTIATE {
    ticks *e = calloc(1, sizeof *e);
    e->log = log, e->environment = environment, e->event = 1e9, e->early = early;
    return e;
}
FMI3_END
FMI3_ENTER {
    ((ticks *)c)->time = start;
    return 0;
}
int fmi3ExitInitializationMode(void *c) {
    ((ticks *)c)->mode = EVENT;
    return 0;
}
int fmi3GetFMUState(void *c, void **state) {
    if (!*state) *state = malloc(sizeof(ticks));
    memcpy(*state, c, sizeof(ticks));
    return 0;
}
int fmi3SetFMUState(void *c, void *state) {
    memcpy(c, state, sizeof(ticks));
    return 0;
}
int fmi3FreeFMUState(void *c, void **state) {
    free(*state);
    *state = NULL;
    return 0;
}
int fmi3SerializedFMUStateSize(void *c, void *state, size_t *size) {
    *size = sizeof(ticks);
    return 0;
}
int fmi3SerializeFMUState(void *c, void *state, uint8_t *bytes, size_t size) {
    memcpy(bytes, state, size);
    return 0;
}
int fmi3DeserializeFMUState(void *c, const uint8_t *bytes, size_t size, void **state) {
    if (!*state) *state = malloc(sizeof(ticks));
    memcpy(*state, bytes, size);
    logger3 log = ((ticks *)c)->log;
    ((ticks *)*state)->log = log, ((ticks *)*state)->environment = ((ticks *)c)->environment;
    return 0;
}
int fmi3EnterEventMode(void *c) {
    ticks *e = c;
    REFUSED(e->mode != STEP, "Event Mode is entered twice");
    e->mode = EVENT, e->was_set = false;
    return 0;
}
int fmi3EnterStepMode(void *c) {
    ticks *e = c;
    REFUSED(e->mode != EVENT, "Step Mode is entered twice");
    e->mode = STEP;
    return 0;
}
/* Ticks the output clock in this instant. */
static void tick(ticks *e) {
    if (e->out) return;
    e->out = true, e->told = false;
    e->outs++;
    memset(e->sent, e->outs % 256, e->outs % 7);
}
int fmi3SetClock(void *c, const unsigned *vr, size_t n, const bool *on) {
    ticks *e = c;
    REFUSED(e->mode != EVENT, "a clock ticks outside of Event Mode");
    REFUSED(*vr == 1 && e->in, "a clock ticks twice in one instant");
    *(*vr == 1 ? &e->in : &e->own) = *on;
    if (e->behaviour == 0) tick(e);
    return 0;
}
int fmi3GetClock(void *c, const unsigned *vr, size_t n, bool *on) {
    ticks *e = c;
    REFUSED(e->mode != EVENT, "a clock is asked for outside of Event Mode");
    *on = e->out && !e->told;
    e->told = e->out, e->asked = true;
    return 0;
}
FMI3_UPDATE {
    ticks *e = c;
    REFUSED(e->mode != EVENT, "an update outside of Event Mode");
    REFUSED(e->asked && e->out && !e->told, "an update before the tick was told");
    *again = *ends = *nominals = *values = *has_next = false;
    bool had_input = e->in || e->own;
    e->updates++;
    if (e->in) e->ins++, e->sum += (int64_t)e->u;
    e->owns += e->own;
    e->in = e->out = e->own = false;
    if (e->found || (e->behaviour == 1 && had_input)) tick(e), *again = true;
    e->found = false, e->seen = e->level;
    return 0;
}
FMI3_STEP {
    ticks *e = c;
    double end = t + h;
    REFUSED(e->mode != STEP, "a step outside of Step Mode");
    REFUSED(fabs(t - e->time) > 1e-9, "a step from another time");
    *ends = *early = *event = false;
    if (e->event <= end + 1e-9) {
        *event = e->found = true;
        *early = e->early && e->event < end - 1e-9;
        if (*early) end = e->event;
        e->event = 1e9;
    }
    e->time = *last = end, e->was_set = false;
    return 0;
}

static int check(ticks *c, unsigned vr, bool sets) {
    bool is_in = vr == 10 || vr == 40, is_out = vr == 11 || vr == 41;
    if (c->mode != INITIALIZATION) REFUSED((is_in && !c->in) || (is_out && !c->out), "a variable of a clock that is not active");
    if (sets && c->mode == STEP) c->was_set = true;
    REFUSED(!sets && c->was_set, "a get after a set in Step Mode");
    return 0;
}
#define CHECKED(vr, sets)                       \
    do {                                        \
        int status = check(c, vr, sets);        \
        if (status) return status;              \
    } while (0)

int fmi3GetFloat64(void *c, const unsigned *vr, size_t n, double *value, size_t count) {
    ticks *e = c;
    for (size_t k = 0; k < n; k++) {
        CHECKED(vr[k], false);
        value[k] = vr[k] == 11 ? (e->in ? e->u + 1 : e->outs) : vr[k] == 10 ? e->u : e->event;
    }
    return 0;
}
int fmi3SetFloat64(void *c, const unsigned *vr, size_t n, const double *value, size_t count) {
    ticks *e = c;
    for (size_t k = 0; k < n; k++) {
        CHECKED(vr[k], true);
        *(vr[k] == 10 ? &e->u : &e->event) = value[k];
    }
    return 0;
}
int fmi3GetInt32(void *c, const unsigned *vr, size_t n, int32_t *value, size_t count) {
    ticks *e = c;
    for (size_t k = 0; k < n; k++) {
        CHECKED(vr[k], false);
        switch (vr[k]) {
            case 12: value[k] = e->ins; break;
            case 13: value[k] = e->sum; break;
            case 14: value[k] = e->owns; break;
            case 15: value[k] = e->outs; break;
            case 16: value[k] = e->updates; break;
            case 31: value[k] = e->level; break;
            default: value[k] = e->behaviour;
        }
    }
    return 0;
}
int fmi3SetInt32(void *c, const unsigned *vr, size_t n, const int32_t *value, size_t count) {
    ticks *e = c;
    for (size_t k = 0; k < n; k++) {
        CHECKED(vr[k], true);
        REFUSED(e->mode == STEP && e->level != value[k], "a discrete input changes in Step Mode");
        *(vr[k] == 31 ? &e->level : &e->behaviour) = value[k];
    }
    return 0;
}
int fmi3GetBinary(void *c, const unsigned *vr, size_t n, size_t *size, const uint8_t **value, size_t count) {
    ticks *e = c;
    CHECKED(*vr, false);
    *value = *vr == 41 ? e->sent : e->received;
    *size = *vr == 41 ? (size_t)(e->outs % 7) : e->size;
    return 0;
}
int fmi3SetBinary(void *c, const unsigned *vr, size_t n, const size_t *size, const uint8_t *const *value, size_t count) {
    ticks *e = c;
    CHECKED(*vr, true);
    e->size = *size < 256 ? *size : 256;
    memcpy(e->received, *value, e->size);
    return 0;
}
