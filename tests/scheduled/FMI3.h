/* What the drivers of the Reference-FMUs' `examples` in this folder need of their FMI3.h, on Linux: each function is
   looked up in the library. The four other files are those of the commit 1258711 of Reference-FMUs, unchanged. */
#ifndef FMI3_h
#define FMI3_h

#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include "fmi3FunctionTypes.h"

#define FMI_FILE_SEPARATOR "/"
#define FMI_PLATFORM_TUPLE "x86_64-linux"
#define FMI_SHARED_LIBRARY_EXTENSION ".so"

typedef enum { FMIOK, FMIWarning, FMIDiscard, FMIError, FMIFatal, FMIPending } FMIStatus;
typedef struct FMIInstance {
    void *library;
    fmi3Instance component;
    void (*log)(struct FMIInstance *, FMIStatus, const char *, const char *);
} FMIInstance;

static void *symbol(FMIInstance *S, const char *name) {
    void *found = dlsym(S->library, name);
    if (!found) {
        fprintf(stderr, "no %s\n", name);
        exit(9);
    }
    return found;
}

static void logged(fmi3InstanceEnvironment S, fmi3Status status, fmi3String category, fmi3String message) {
    ((FMIInstance *)S)->log(S, (FMIStatus)status, category, message);
}

static FMIInstance *FMICreateInstance(const char *name, void *log, void *calls) {
    FMIInstance *S = calloc(1, sizeof *S);
    S->log = log;
    return S;
}
static void FMIFreeInstance(FMIInstance *S) { free(S); }
static FMIStatus FMILoadPlatformBinary(FMIInstance *S, const char *path) {
    S->library = dlopen(path, RTLD_NOW);
    if (!S->library) fprintf(stderr, "%s\n", dlerror());
    return S->library ? FMIOK : FMIError;
}

#define CALLED(NAME, GIVEN, PASSED) \
    static FMIStatus FMI3##NAME GIVEN { return (FMIStatus)((fmi3##NAME##TYPE *)symbol(S, "fmi3" #NAME)) PASSED; }

static FMIStatus FMI3InstantiateScheduledExecution(FMIInstance *S, fmi3String token, fmi3String resources, fmi3Boolean visible,
        fmi3Boolean logging, const fmi3ValueReference *vr, size_t n, fmi3ClockUpdateCallback update,
        fmi3LockPreemptionCallback lock, fmi3UnlockPreemptionCallback unlock) {
    fmi3InstantiateScheduledExecutionTYPE *f = symbol(S, "fmi3InstantiateScheduledExecution");
    S->component = f("instance1", token, resources, visible, logging, S, logged, update, lock, unlock);
    return S->component ? FMIOK : FMIError;
}
CALLED(EnterInitializationMode, (FMIInstance *S, fmi3Boolean a, fmi3Float64 b, fmi3Float64 c, fmi3Boolean d, fmi3Float64 e), (S->component, a, b, c, d, e))
CALLED(ExitInitializationMode, (FMIInstance *S), (S->component))
CALLED(SetDebugLogging, (FMIInstance *S, fmi3Boolean on, size_t n, const fmi3String c[]), (S->component, on, n, c))
CALLED(ActivateModelPartition, (FMIInstance *S, fmi3ValueReference vr, fmi3Float64 t), (S->component, vr, t))
CALLED(GetClock, (FMIInstance *S, const fmi3ValueReference vr[], size_t n, fmi3Clock v[]), (S->component, vr, n, v))
CALLED(GetIntervalDecimal, (FMIInstance *S, const fmi3ValueReference vr[], size_t n, fmi3Float64 v[], fmi3IntervalQualifier q[]), (S->component, vr, n, v, q))
CALLED(GetInt32, (FMIInstance *S, const fmi3ValueReference vr[], size_t n, fmi3Int32 v[], size_t m), (S->component, vr, n, v, m))
CALLED(SetInt32, (FMIInstance *S, const fmi3ValueReference vr[], size_t n, const fmi3Int32 v[], size_t m), (S->component, vr, n, v, m))
CALLED(Terminate, (FMIInstance *S), (S->component))
static void FMI3FreeInstance(FMIInstance *S) { ((fmi3FreeInstanceTYPE *)symbol(S, "fmi3FreeInstance"))(S->component); }

#endif
