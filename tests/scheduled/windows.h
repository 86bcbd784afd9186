/* What scs_threaded.c needs of Windows, by threads of POSIX. */
#pragma once
#define time time_of_libc
#include <pthread.h>
#include <stdint.h>
#include <stdlib.h>
#include <unistd.h>
#undef time
#define __stdcall
#define GMEM_FIXED 0
typedef pthread_mutex_t *HGLOBAL;
typedef uintptr_t DWORD_PTR;
typedef void *HANDLE;
static HGLOBAL GlobalAlloc(int flags, size_t n) {
    pthread_mutexattr_t kind;
    pthread_mutexattr_init(&kind);
    pthread_mutexattr_settype(&kind, PTHREAD_MUTEX_RECURSIVE);
    HGLOBAL lock = malloc(sizeof *lock);
    pthread_mutex_init(lock, &kind);
    return lock;
}
#define GlobalLock(lock) pthread_mutex_lock(lock)
#define GlobalUnlock(lock) pthread_mutex_unlock(lock)
#define GetLastError() 0L
#define GetCurrentProcessorNumber() 0
#define SetThreadAffinityMask(thread, mask)
#define SetThreadPriority(thread, priority)
#define Sleep(ms) usleep(50 * (ms))
#define _endthreadex(status)
static uintptr_t _beginthreadex(void *s, unsigned n, unsigned (*f)(void *), void *argument, unsigned flags, unsigned *id) {
    pthread_t thread;
    return pthread_create(&thread, NULL, (void *(*)(void *))f, argument) ? 0 : (uintptr_t)thread;
}
