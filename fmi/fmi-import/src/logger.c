/* The logger of FMI 2.0: formats a message as printf does and hands it to the master, `cosim_receive` in messages.rs. */
#include <stdarg.h>
#include <stdio.h>

void cosim_receive(void *environment, const char *instance, int status, const char *text);

void cosim_logger(void *environment, const char *instance, int status, const char *category, const char *message, ...) {
    char text[4096];
    va_list arguments;
    (void)category;
    if (!message) {
        return;
    }
    va_start(arguments, message);
    if (vsnprintf(text, sizeof text, message, arguments) > 0) {
        cosim_receive(environment, instance, status, text);
    }
    va_end(arguments);
}
