/* The logger of FMI 2.0, whose messages are printf formats. Many FMUs pass texts in which `%` stands for itself, without arguments, and
   nobody can know how many arguments there are. So nothing is trusted: pointers are tried by the system before they are read, `%n` writes
   nothing, what is no conversion is text, and no more than MOST arguments are taken. log.rs receives the text. */
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { ROOM = 4096, MOST = 32, WIDEST = 500 };

/* Copies a C string to `to`, of which only `room` bytes; returns how many, without the zero at the end, or -1 if it cannot be read. */
long fmi_import_copy(const char *text, char *to, size_t room);
void fmi_import_receive(void *environment, int status, const char *text);

struct message {
    va_list arguments;
    int left; /* how many arguments may still be taken */
    size_t length;
    char text[ROOM], format[ROOM], argument[ROOM];
};

static void put(struct message *m, const char *text, size_t n) {
    size_t room = ROOM - 1 - m->length;
    if (n > room) n = room;
    memcpy(m->text + m->length, text, n);
    m->length += n;
}

/* Flags, width, precision and size of a conversion. */
struct conversion {
    char flags[8];
    int width, precision; /* -1: none, -2: an argument */
    char size; /* 0, h, H (hh), l, L (ll), j, z, t, D (long double) */
    char type;
};

static const char *number(const char *at, int *value) {
    if (*at == '*') {
        *value = -2;
        return at + 1;
    }
    for (*value = 0; *at >= '0' && *at <= '9'; at++) {
        if (*value < WIDEST) *value = *value * 10 + (*at - '0');
    }
    return at;
}

/* Reads a conversion, from behind its '%' on; returns its end, or NULL if it is text. */
static const char *parse(const char *at, struct conversion *c) {
    int has_space = 0;
    size_t n = 0;
    memset(c, 0, sizeof *c);
    c->width = c->precision = -1;
    for (; *at && strchr("-+ #0", *at); at++) {
        has_space |= *at == ' ';
        if (n + 1 < sizeof c->flags && !strchr(c->flags, *at)) c->flags[n++] = *at;
    }
    if (*at == '*' || (*at >= '1' && *at <= '9')) {
        at = number(at, &c->width);
        has_space = 0;
    }
    if (*at == '.') at = number(at + 1, &c->precision);
    if (!strncmp(at, "I64", 3)) {
        c->size = 'L', at += 3;
    } else if (*at && strchr("hljztL", *at)) {
        c->size = *at == 'L' ? 'D' : *at;
        at++;
        if ((c->size == 'h' || c->size == 'l') && *at == c->size) c->size = *at++ == 'h' ? 'H' : 'L';
    }
    c->type = *at;
    if (!*at || !strchr("diouxXcspneEfFgGaA", *at)) return NULL;
    at++;
    /* "100 % of it", "50 % done": a blank belongs to signed numbers only, and a word goes on with letters. */
    if (has_space && (!strchr("dieEfFgGaA", c->type) || ((*at | 32) >= 'a' && (*at | 32) <= 'z'))) return NULL;
    return at;
}

static intmax_t whole(struct message *m, char size, int is_signed) {
    switch (size) {
    case 'l': return is_signed ? va_arg(m->arguments, long) : (intmax_t)va_arg(m->arguments, unsigned long);
    case 'L': return va_arg(m->arguments, long long);
    case 'j': return va_arg(m->arguments, intmax_t);
    case 'z': return (intmax_t)va_arg(m->arguments, size_t);
    case 't': return va_arg(m->arguments, ptrdiff_t);
    }
    int value = va_arg(m->arguments, int);
    if (is_signed) return size == 'H' ? (signed char)value : size == 'h' ? (short)value : value;
    return size == 'H' ? (unsigned char)value : size == 'h' ? (unsigned short)value : (unsigned)value;
}

static int argument(struct message *m, int value) {
    if (value != -2) return value;
    value = va_arg(m->arguments, int);
    return value > WIDEST ? WIDEST : value < -WIDEST ? -WIDEST : value;
}

/* Copies a text argument of fewer than `room` bytes; 0 if it cannot be read or holds what no text does: there was no argument then. */
static int copy(struct message *m, const char *from, size_t room) {
    if (fmi_import_copy(from, m->argument, room) < 0) return 0;
    for (const char *at = m->argument; *at; at++) {
        if ((unsigned char)*at < ' ' && !strchr("\t\n\r\v\f\b\a\33", *at)) return 0;
    }
    return 1;
}

/* Writes an argument as its conversion says; a text that cannot be read as the conversion itself. */
static void convert(struct message *m, const struct conversion *c, const char *from, const char *end) {
    char format[32], out[ROOM];
    int width = argument(m, c->width), precision = argument(m, c->precision), n = -1;
    const char *bare = width == -1 ? "" : "*";
    if (precision < 0) precision = -1;
    if (width == -1) width = 0;
    snprintf(format, sizeof format, "%%%s%s%s%s%c", c->flags, bare, ".*", c->size == 'D' ? "L" : strchr("diouxX", c->type) ? "j" : "", c->type);
#define PRINT(value) (*bare ? snprintf(out, sizeof out, format, width, precision, value) : snprintf(out, sizeof out, format, precision, value))
    if (strchr("di", c->type)) n = PRINT(whole(m, c->size, 1));
    else if (strchr("ouxX", c->type)) n = PRINT((uintmax_t)whole(m, c->size, 0));
    else if (strchr("eEfFgGaA", c->type)) n = c->size == 'D' ? PRINT(va_arg(m->arguments, long double)) : PRINT(va_arg(m->arguments, double));
    else if (c->type == 'c') {
        char letter[2] = {(char)va_arg(m->arguments, int), 0};
        snprintf(format, sizeof format, "%%%s%ss", c->flags, bare);
        n = *bare ? snprintf(out, sizeof out, format, width, letter) : snprintf(out, sizeof out, format, letter);
    } else {
        const void *pointer = va_arg(m->arguments, const void *);
        size_t room = precision >= 0 && precision < ROOM - 1 ? (size_t)precision + 1 : ROOM;
        if (c->type == 'p') n = snprintf(out, sizeof out, "%p", pointer);
        else if (c->type == 's' && !c->size && !pointer) n = snprintf(out, sizeof out, "(null)");
        else if (c->type == 's' && !c->size && copy(m, pointer, room)) n = PRINT(m->argument);
    }
    if (n < 0) put(m, from, (size_t)(end - from));
    else put(m, out, (size_t)n < sizeof out ? (size_t)n : sizeof out - 1);
}

static void write_all(struct message *m) {
    const char *at = m->format;
    while (*at) {
        size_t plain = strcspn(at, "%");
        put(m, at, plain);
        at += plain;
        if (!*at) break;
        if (at[1] == '%') {
            put(m, "%", 1);
            at += 2;
            continue;
        }
        struct conversion c;
        const char *end = parse(at + 1, &c);
        int count = end ? 1 + (c.width == -2) + (c.precision == -2) : 0;
        if (!end || count > m->left) {
            put(m, "%", 1);
            at++;
        } else {
            m->left -= count;
            convert(m, &c, at, end);
            at = end;
        }
    }
}

void fmi_import_logger(void *environment, const char *instance, int status, const char *category, const char *message, ...) {
    struct message *m = message ? malloc(sizeof *m) : NULL;
    (void)instance;
    (void)category;
    if (!m) return;
    m->length = 0;
    m->left = MOST;
    if (fmi_import_copy(message, m->format, ROOM) < 0) {
        strcpy(m->text, "(a message that cannot be read)");
    } else {
        va_start(m->arguments, message);
        write_all(m);
        va_end(m->arguments);
        m->text[m->length] = 0;
    }
    fmi_import_receive(environment, status, m->text);
    free(m);
}
