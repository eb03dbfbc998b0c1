/* lua/say.c - what the program says to its user: errors without what a script could hide in them, output whole or not at all. */

#define _POSIX_C_SOURCE 200809L     /* open_memstream, lstat */

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "base/file.h"
#include "base/text.h"
#include "command.h"
#include "state.h"

int exit_code_of_reading(dig_status status)
{
    return status == DIG_OK ? EXIT_FINE : status == DIG_E_MEMORY ? EXIT_MEMORY : EXIT_FORMAT;
}

void say_text(FILE *f, const char *text, size_t size, const char *kept)
{
    size_t written = 0;
    for (size_t at = 0, n; at < size; at += n) {
        if (text_next(text + at, size - at, &n) == TEXT_PLAIN || (text[at] && strchr(kept, text[at])))
            continue;
        fwrite(text + written, 1, at - written, f);
        fputc('?', f);
        written = at + n;
    }
    fwrite(text + written, 1, size - written, f);
}

void say_error(const char *text)
{
    enum { MOST = 4000 };
    fputs("digbox: ", stderr);
    say_text(stderr, text, strnlen(text, MOST), "\n");
    fputc('\n', stderr);
}

/* Results that cannot be written are a failure, but for a reader who went away. */
int flush_output(int code)
{
    errno = 0;
    bool failed = fflush(stdout) != 0 || ferror(stdout);
    if (!failed || errno == EPIPE)
        return code;
    fprintf(stderr, "digbox: standard output: %s\n", errno ? strerror(errno) : "cannot be written");
    return EXIT_OUTPUT;
}

/* ---- texts that become files ------------------------------------------------------ */

static int refuse(const char *path, int error)
{
    fprintf(stderr, "digbox: %s: %s\n", path, error ? strerror(error) : "cannot be written");
    return error == ENOMEM ? EXIT_MEMORY : EXIT_OUTPUT;
}

bool text_begin(TextFile *t, const char *path)
{
    *t = (TextFile){0};
    t->text = open_memstream(&t->data, &t->size);
    return t->text || refuse(path, errno) == EXIT_FINE;
}

static int write_as_it_is(const TextFile *t, const char *path)
{
    FILE *f = fopen(path, "w");
    bool fine = f && fwrite(t->data, 1, t->size, f) == t->size;
    int error = fine ? 0 : errno;
    if (f && fclose(f) != 0 && fine)
        return refuse(path, errno);
    return fine ? EXIT_FINE : refuse(path, error);
}

int text_place(TextFile *t, const char *path)
{
    struct stat info;
    char why[1400];
    int code = EXIT_FINE;
    bool whole = !ferror(t->text);
    whole = fclose(t->text) == 0 && whole;
    if (!whole) {
        code = refuse(path, ENOMEM);
    } else if (lstat(path, &info) == 0 && !S_ISREG(info.st_mode)) {
        code = write_as_it_is(t, path);
    } else if (file_replace(path, t->data, t->size, FILE_FLUSHED, why, sizeof why) != DIG_OK) {
        say_error(why);
        code = EXIT_OUTPUT;
    }
    free(t->data);
    *t = (TextFile){0};
    return code;
}
