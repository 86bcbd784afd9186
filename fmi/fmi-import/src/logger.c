/* The logger of FMI 2.0: formats a message as printf does and hands it to `fmi_import_receive` in log.rs. */
#include <stdarg.h>
#include <stdio.h>

void fmi_import_receive(void *environment, int status, const char *text);

void fmi_import_logger(void *environment, const char *instance, int status, const char *category, const char *message, ...) {
    char text[4096];
    va_list arguments;
    (void)instance;
    (void)category;
    if (!message) {
        return;
    }
    va_start(arguments, message);
    if (vsnprintf(text, sizeof text, message, arguments) > 0) {
        fmi_import_receive(environment, status, text);
    }
    va_end(arguments);
}
