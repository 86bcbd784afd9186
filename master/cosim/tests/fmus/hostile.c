/* An FMU of FMI 2.0 and 3.0 that misbehaves as the variable HOSTILE of the environment says: what and where, "segv step" for example. In steps
   it does so from 0.25 s on. Otherwise y counts its steps. */
#define _GNU_SOURCE
#include <fenv.h>
#include <locale.h>
#include <pthread.h>
#include <signal.h>
#include <unistd.h>

#include "fmu.h"

typedef struct {
    double steps, u;
    callbacks with;
    logger3 log_3;
} hostile;

static const double FROM = 0.25;

static int deep(int n) {
    volatile char frame[4096];
    frame[0] = (char)n;
    return deep(n + 1) + frame[0];
}

static void say(hostile *h, const char *text) {
    if (h->log_3) h->log_3(h->with.environment, 1, "c", text);
    else h->with.log(h->with.environment, "h", 1, "c", text);
}

static void *from_a_thread(void *c) {
    say(c, "from a thread");
    return NULL;
}
static void *exits(void *c) { exit(0); }
static void *crashes(void *c) {
    *(volatile int *)8 = 1;
    return NULL;
}

static void *sleeps(void *c) {
    for (;;) pause();
    return NULL;
}

static void in_thread(void *(*run)(void *), void *c) {
    pthread_t thread;
    pthread_create(&thread, NULL, run, c);
    pthread_join(thread, NULL);
}

static void fill(char *to, size_t n, char with) {
    memset(to, with, n - 1);
    to[n - 1] = 0;
}

static void act(const char *where, hostile *h) {
    char asked[64] = "", *what, *there;
    static char large[1 << 20];
    if (getenv("HOSTILE")) strncpy(asked, getenv("HOSTILE"), sizeof asked - 1);
    what = strtok(asked, " ");
    there = strtok(NULL, " ");
    if (!there || strcmp(there, where)) return;
#define IF(name) if (!strcmp(what, #name))
    IF(segv) *(volatile int *)8 = 1;
    IF(abort) abort();
    IF(exit) exit(0);
    IF(quick_exit) quick_exit(0);
    IF(_exit) _exit(0);
    IF(hang) for (;;) pause();
    IF(eat) for (;;) memset(malloc(1 << 20), 1, 1 << 20);
    IF(leave) {
        pthread_t thread;
        pthread_create(&thread, NULL, sleeps, h);
    }
    IF(trap) __builtin_trap();
    IF(bus) raise(SIGBUS);
    IF(fpe) {
        volatile int zero = 0;
        zero = 7 / zero;
    }
    IF(stack) deep(0);
    IF(thread_exit) in_thread(exits, h);
    IF(thread_segv) in_thread(crashes, h);
    IF(unmask) feenableexcept(FE_DIVBYZERO | FE_INVALID);
    IF(round) fesetround(FE_UPWARD);
    IF(flush) {
#ifdef __x86_64__
        unsigned control;
        __asm__ volatile("stmxcsr %0" : "=m"(control));
        control |= 0x8040;
        __asm__ volatile("ldmxcsr %0" : : "m"(control));
#endif
    }
    IF(x87) {
#ifdef __x86_64__
        unsigned short word = 0x27F;
        __asm__ volatile("fldcw %0" : : "m"(word));
#endif
    }
    IF(chdir) chdir("/");
    IF(locale) setlocale(LC_ALL, "C.UTF-8");
    IF(ignore) signal(SIGTERM, SIG_IGN);
    IF(unhandled) {
        signal(SIGSEGV, SIG_DFL);
    }
    IF(block) {
        sigset_t set;
        sigemptyset(&set);
        sigaddset(&set, SIGTERM);
        pthread_sigmask(SIG_BLOCK, &set, NULL);
    }
    IF(close) for (int k = 0; k < 3; k++) close(k);
    IF(print) {
        printf("first line\n");
        fill(large, sizeof large, 'x');
        for (int k = 0; k < 4; k++) puts(large);
    }
    IF(fork) {
        if (!fork()) exit(0);
    }
    IF(thread_log) in_thread(from_a_thread, h);
    IF(flood) {
        char text[5] = "aaaa";
        for (int k = 0; k < 20000; k++) {
            text[0] = 'a' + k % 26, text[1] = 'a' + k / 26 % 26, text[2] = 'a' + k / 676 % 26;
            say(h, text);
        }
    }
    IF(long) {
        fill(large, sizeof large, 'L');
        say(h, large);
    }
    IF(forms) {
        logger2 l = h->with.log;
        void *e = h->with.environment;
        l(e, "h", 1, "c", "t = %g, n = %d, s = %s, fmi2%s", 1.5, 42, "text", "True");
        l(e, "h", 1, "c", "%lld %lu %zu %5.2f|%-4s|%*d %.3s %c %% %x", 1LL << 40, 7ul, (size_t)9, 3.14159, "ab", 5, 7, "abcdef", 'Z', 255);
        l(e, "h", 1, "c", "valve at 100%");
        l(e, "h", 1, "c", "50% load, 5 % of it, 100% done");
        l(e, "h", 1, "c", "#r0# and #r1#, #i7#, ##, a # b");
        l(e, "h", 1, "c", "%s", "an argument with 100%d");
        l(e, NULL, 1, NULL, NULL);
        l(e, "h", 1, "c", (const char *)16);
    }
    IF(s) say(h, "%s%s%s%s%s%s%s%s%s%s%s%s is none");
    IF(n) say(h, "%n%n%n%n%n%n%n%n%n%n%n%n is none");
    IF(d) say(h, "%d%f%d%f%d%f%d%f%d%f%d%f is none");
    IF(many) {
        for (size_t k = 0; k + 3 < sizeof large; k += 2) large[k] = '%', large[k + 1] = 'd';
        say(h, large);
    }
}

__attribute__((constructor)) static void loaded(void) { act("load", NULL); }
__attribute__((destructor)) static void unloaded(void) { act("unload", NULL); }

static hostile *made(callbacks with, logger3 log_3) {
    hostile *h = calloc(1, sizeof *h);
    h->with = with;
    h->log_3 = log_3;
    act("instantiate", h);
    return h;
}
static int step(hostile *h, double t) {
    if (t > FROM) act("step", h);
    h->steps += 1;
    return 0;
}
static int get(hostile *h, const unsigned *vr, size_t n, double *value) {
    act("get", h);
    for (size_t k = 0; k < n; k++) value[k] = vr[k] ? h->steps : h->u;
    return 0;
}
static int set(hostile *h, const double *value, size_t n) {
    act("set", h);
    if (n) h->u = value[0];
    return 0;
}
static int at(const char *where, hostile *h) {
    act(where, h);
    return 0;
}
static void freed(hostile *h) {
    act("free", h);
    free(h);
}
static size_t size(void) {
    const char *bytes = getenv("STATE");
    return bytes ? strtoull(bytes, NULL, 10) : 8;
}

FMI2_INSTANTIATE {
    return made(*functions, NULL);
}
void fmi2FreeInstance(void *c) { freed(c); }
FMI2_SETUP { return 0; }
int fmi2EnterInitializationMode(void *c) { return at("enter", c); }
int fmi2ExitInitializationMode(void *c) { return at("exit", c); }
int fmi2Terminate(void *c) { return at("terminate", c); }
int fmi2GetReal(void *c, const unsigned *vr, size_t n, double *value) { return get(c, vr, n, value); }
int fmi2SetReal(void *c, const unsigned *vr, size_t n, const double *value) { return set(c, value, n); }
int fmi2DoStep(void *c, double t, double h, int no_state) { return step(c, t); }
int fmi2GetFMUstate(void *c, void **state) { return *state = malloc(8), 0; }
int fmi2FreeFMUstate(void *c, void **state) { return free(*state), *state = NULL, 0; }
int fmi2SerializedFMUstateSize(void *c, void *state, size_t *n) { return *n = size(), 0; }
int fmi2SerializeFMUstate(void *c, void *state, char *bytes, size_t n) { return memset(bytes, 0, n), 0; }

FMI3_INSTANTIATE {
    callbacks with = {.environment = environment};
    return made(with, log);
}
void fmi3FreeInstance(void *c) { freed(c); }
FMI3_ENTER {
    return at("enter", c);
}
int fmi3ExitInitializationMode(void *c) { return at("exit", c); }
int fmi3Terminate(void *c) { return at("terminate", c); }
int fmi3GetFloat64(void *c, const unsigned *vr, size_t n, double *value, size_t m) { return get(c, vr, n, value); }
int fmi3SetFloat64(void *c, const unsigned *vr, size_t n, const double *value, size_t m) { return set(c, value, m); }
FMI3_STEP {
    *event = *ends = *early = 0;
    *last = t + h;
    return step(c, t);
}
/* Bytes of which only a few are there. */
int fmi3GetBinary(void *c, const unsigned *vr, size_t n, size_t *sizes, const uint8_t **values, size_t m) {
    static const uint8_t bytes[3] = {1, 2, 3};
    const char *said = getenv("BYTES");
    for (size_t k = 0; k < m; k++) {
        sizes[k] = said ? strtoull(said, NULL, 10) : 3;
        values[k] = bytes;
    }
    return 0;
}
int fmi3GetString(void *c, const unsigned *vr, size_t n, const char **values, size_t m) {
    for (size_t k = 0; k < m; k++) values[k] = getenv("BYTES") ? (const char *)16 : "text";
    return 0;
}
