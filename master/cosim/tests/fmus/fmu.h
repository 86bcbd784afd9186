/* What the test FMUs begin with: types, the heads of functions with many arguments, and functions that do no more than they must. */
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef void (*logger2)(void *, const char *, int, const char *, const char *, ...);
typedef void (*logger3)(void *, int, const char *, const char *);
typedef struct {
    logger2 log;
    void *allocate, *release, *finished, *environment;
} callbacks;

#define FMI2_INSTANTIATE \
    void *fmi2Instantiate(const char *name, int type, const char *guid, const char *resources, const callbacks *functions, int visible, int logging)
#define FMI2_SETUP int fmi2SetupExperiment(void *c, int has_tolerance, double tolerance, double start, int has_stop, double stop)
#define FMI3_INSTANTIATE \
    void *fmi3InstantiateCoSimulation(const char *name, const char *token, const char *resources, bool visible, bool logging, bool event_mode, \
                                      bool early, const unsigned *required, size_t n, void *environment, logger3 log, void *update)
#define FMI3_ENTER int fmi3EnterInitializationMode(void *c, bool has_tolerance, double tolerance, double start, bool has_stop, double stop)
#define FMI3_UPDATE \
    int fmi3UpdateDiscreteStates(void *c, bool *again, bool *ends, bool *nominals, bool *values, bool *has_next, double *next)
#define FMI3_STEP int fmi3DoStep(void *c, double t, double h, bool no_state, bool *event, bool *ends, bool *early, double *last)

#define FMI2_MODES int fmi2EnterInitializationMode(void *c) { return 0; } int fmi2ExitInitializationMode(void *c) { return 0; }
#define FMI2_END void fmi2FreeInstance(void *c) { free(c); } int fmi2Terminate(void *c) { return 0; }
#define FMI3_END void fmi3FreeInstance(void *c) { free(c); } int fmi3Terminate(void *c) { return 0; }
#define FMI3_EVENTS int fmi3EnterEventMode(void *c) { return 0; } int fmi3EnterStepMode(void *c) { return 0; }
