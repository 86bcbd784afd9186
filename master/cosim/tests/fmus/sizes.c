/* An FMU of FMI 3.0 whose arrays have n elements, n from 0 to 8, 3 at first: x' = u for each element, from x0. Sizes are set in
   Configuration Mode alone, arrays are passed whole. Value references:

   1        n; 2: whether the arrays of another size are not told before they are set (structural, too)
   3        x0, 10 20 30 ... at first; 4: u, 1 2 3 ... at first; 5: x; 6: how often Configuration Mode was entered
   10..15   arrays of n Float32, Int64, Boolean, String, Binary, Int8, which give back what they were set to */
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum { OK, ERROR = 3, MOST = 8 };
enum { INSTANTIATED, CONFIGURATION, INITIALIZATION, STEP };

typedef struct {
    int mode, entered;
    uint64_t n;
    bool hides, is_resized, is_known[16];
    double x0[MOST], u[MOST], x[MOST];
    float single[MOST];
    int64_t whole[MOST];
    bool truth[MOST];
    char text[MOST][32];
    uint8_t bytes[MOST][32];
    size_t byte_count[MOST];
    int8_t small[MOST];
} sizes;

void *fmi3InstantiateCoSimulation(const char *name, const char *token, const char *resources, bool visible, bool logging, bool event_mode,
                                  bool early, const unsigned *required, size_t n, void *environment, void *log, void *update) {
    sizes *s = calloc(1, sizeof *s);
    s->n = 3;
    for (int i = 0; i < MOST; i++) s->x0[i] = 10 * (i + 1), s->u[i] = i + 1;
    return s;
}
void fmi3FreeInstance(void *c) { free(c); }
int fmi3EnterConfigurationMode(void *c) {
    sizes *s = c;
    if (s->mode != INSTANTIATED) return ERROR;
    s->mode = CONFIGURATION;
    s->entered++;
    return OK;
}
int fmi3ExitConfigurationMode(void *c) {
    sizes *s = c;
    if (s->mode != CONFIGURATION) return ERROR;
    s->mode = INSTANTIATED;
    return OK;
}
int fmi3EnterInitializationMode(void *c, bool with_tolerance, double tolerance, double start, bool with_stop, double stop) {
    ((sizes *)c)->mode = INITIALIZATION;
    return OK;
}
int fmi3ExitInitializationMode(void *c) {
    sizes *s = c;
    s->mode = STEP;
    memcpy(s->x, s->x0, sizeof s->x);
    return OK;
}
int fmi3Terminate(void *c) { return OK; }
int fmi3DoStep(void *c, double t, double h, bool no_state, bool *event, bool *ends, bool *early, double *last) {
    sizes *s = c;
    for (uint64_t i = 0; i < s->n; i++) s->x[i] += h * s->u[i];
    *event = *ends = *early = false;
    *last = t + h;
    return OK;
}
/* Whether the value reference is `vr` and all of its elements are passed; sets that they are known. */
static bool whole(sizes *s, const unsigned *vr, size_t n, unsigned wanted, size_t count, bool sets) {
    if (n != 1 || vr[0] != wanted || count != s->n || s->mode == CONFIGURATION) return false;
    if (!sets) return s->mode != INSTANTIATED || !s->hides || !s->is_resized || s->is_known[wanted];
    return s->is_known[wanted] = true;
}
int fmi3GetUInt64(void *c, const unsigned *vr, size_t n, uint64_t *values, size_t count) {
    if (n != 1 || vr[0] != 1 || count != 1) return ERROR;
    *values = ((sizes *)c)->n;
    return OK;
}
int fmi3SetUInt64(void *c, const unsigned *vr, size_t n, const uint64_t *values, size_t count) {
    sizes *s = c;
    if (s->mode != CONFIGURATION || n != 1 || vr[0] != 1 || count != 1 || *values > MOST) return ERROR;
    s->n = *values;
    s->is_resized = true;
    return OK;
}
int fmi3GetFloat64(void *c, const unsigned *vr, size_t n, double *values, size_t count) {
    sizes *s = c;
    double *arrays[] = {s->x0, s->u, s->x};
    size_t k = 0;
    for (size_t j = 0; j < n; j++) {
        if (vr[j] == 6 && k < count) {
            values[k++] = s->entered;
            continue;
        }
        if (vr[j] < 3 || vr[j] > 5 || !whole(s, vr + j, 1, vr[j], s->n, false) || k + s->n > count) return ERROR;
        memcpy(values + k, arrays[vr[j] - 3], s->n * sizeof *values);
        k += s->n;
    }
    return k == count ? OK : ERROR;
}
int fmi3SetFloat64(void *c, const unsigned *vr, size_t n, const double *values, size_t count) {
    sizes *s = c;
    size_t k = 0;
    for (size_t j = 0; j < n; j++, k += s->n) {
        if ((vr[j] != 3 && vr[j] != 4) || k + s->n > count || !whole(s, vr + j, 1, vr[j], s->n, true)) return ERROR;
        memcpy(vr[j] == 3 ? s->x0 : s->u, values + k, s->n * sizeof *values);
    }
    return k == count ? OK : ERROR;
}
#define BOTH(name, type, number, field)                                                          \
    int fmi3Get##name(void *c, const unsigned *vr, size_t n, type *values, size_t count) {       \
        sizes *s = c;                                                                            \
        if (!whole(s, vr, n, number, count, false)) return ERROR;                                \
        memcpy(values, s->field, count * sizeof *values);                                        \
        return OK;                                                                               \
    }                                                                                            \
    int fmi3Set##name(void *c, const unsigned *vr, size_t n, const type *values, size_t count) { \
        sizes *s = c;                                                                            \
        if (!whole(s, vr, n, number, count, true)) return ERROR;                                 \
        memcpy(s->field, values, count * sizeof *values);                                        \
        return OK;                                                                               \
    }
BOTH(Float32, float, 10, single)
BOTH(Int64, int64_t, 11, whole)
BOTH(Int8, int8_t, 15, small)
int fmi3GetBoolean(void *c, const unsigned *vr, size_t n, bool *values, size_t count) {
    sizes *s = c;
    if (n == 1 && vr[0] == 2 && count == 1) {
        *values = s->hides;
        return OK;
    }
    if (!whole(s, vr, n, 12, count, false)) return ERROR;
    memcpy(values, s->truth, count);
    return OK;
}
int fmi3SetBoolean(void *c, const unsigned *vr, size_t n, const bool *values, size_t count) {
    sizes *s = c;
    if (n == 1 && vr[0] == 2 && count == 1 && s->mode == CONFIGURATION) {
        s->hides = *values;
        return OK;
    }
    if (!whole(s, vr, n, 12, count, true)) return ERROR;
    memcpy(s->truth, values, count);
    return OK;
}
int fmi3GetString(void *c, const unsigned *vr, size_t n, const char **values, size_t count) {
    sizes *s = c;
    if (!whole(s, vr, n, 13, count, false)) return ERROR;
    for (size_t i = 0; i < count; i++) values[i] = s->text[i];
    return OK;
}
int fmi3SetString(void *c, const unsigned *vr, size_t n, const char *const *values, size_t count) {
    sizes *s = c;
    if (!whole(s, vr, n, 13, count, true)) return ERROR;
    for (size_t i = 0; i < count; i++) strncpy(s->text[i], values[i], 31);
    return OK;
}
int fmi3GetBinary(void *c, const unsigned *vr, size_t n, size_t *counts, const uint8_t **values, size_t count) {
    sizes *s = c;
    if (!whole(s, vr, n, 14, count, false)) return ERROR;
    for (size_t i = 0; i < count; i++) counts[i] = s->byte_count[i], values[i] = s->bytes[i];
    return OK;
}
int fmi3SetBinary(void *c, const unsigned *vr, size_t n, const size_t *counts, const uint8_t *const *values, size_t count) {
    sizes *s = c;
    if (!whole(s, vr, n, 14, count, true)) return ERROR;
    for (size_t i = 0; i < count; i++) {
        s->byte_count[i] = counts[i] < 32 ? counts[i] : 32;
        memcpy(s->bytes[i], values[i], s->byte_count[i]);
    }
    return OK;
}
int fmi3GetFMUState(void *c, void **state) {
    sizes *copy = *state ? *state : malloc(sizeof(sizes));
    *copy = *(sizes *)c;
    *state = copy;
    return OK;
}
int fmi3SetFMUState(void *c, void *state) {
    *(sizes *)c = *(sizes *)state;
    return OK;
}
int fmi3FreeFMUState(void *c, void **state) {
    free(*state);
    *state = NULL;
    return OK;
}
int fmi3SerializedFMUStateSize(void *c, void *state, size_t *size) {
    *size = sizeof(sizes);
    return OK;
}
int fmi3SerializeFMUState(void *c, void *state, uint8_t *bytes, size_t size) {
    memcpy(bytes, state, sizeof(sizes));
    return OK;
}
int fmi3DeserializeFMUState(void *c, const uint8_t *bytes, size_t size, void **state) {
    *state = malloc(sizeof(sizes));
    memcpy(*state, bytes, sizeof(sizes));
    return OK;
}
