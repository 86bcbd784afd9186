/* The FMU of lag.c in FMI 3.0, with the same mistakes, and those that only FMI 3.0 can make. No Event Mode: get, set and step take turns.
 * Value references: those of lag.c; 9 is time. */
#define MISTAKES_OF_3 , WRONG_TRANSPOSE, EARLY, WRONG_COUNT, STAYS
#include <stdint.h>

#include "lag.c"

typedef struct {
    void (*log)(void *, int, const char *, const char *);
    void *environment;
} Listener;

static void pass_on(void *environment, const char *name, int status, const char *category, const char *format, ...) {
    (void)name, (void)format;
    Listener *listener = environment;
    if (listener->log)
        listener->log(listener->environment, status, category, "told");
}

#define EXPORT __attribute__((visibility("default")))
#define SET_PRIOR_DONE 1

typedef struct {
    Instance lag;
    Callbacks callbacks;
    Listener listener;
} Instance3;
