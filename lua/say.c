/* lua/say.c - what the program says to its user: errors without what a script could hide in them, output whole or not at all. */

#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "command.h"
#include "state.h"

void say_error(const char *text)
{
    /* One message: at most 4,000 bytes, no control bytes but line feeds. */
    fputs("digbox: ", stderr);
    for (int i = 0; i < 4000 && text[i]; i++)
        fputc(((unsigned char)text[i] >= 0x20 && text[i] != 0x7f) || text[i] == '\n' ? text[i] : '?', stderr);
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
