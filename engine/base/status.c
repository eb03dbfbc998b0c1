/* base/status.c - the names of the status codes. */
#include "base/base.h"

const char *dig_status_name(dig_status s)
{
    static const char *const names[DIG_STATUS_COUNT] = {
        [DIG_OK] = "ok",         [DIG_E_ARG] = "bad argument",   [DIG_E_DEAD] = "removed",
        [DIG_E_KIND] = "wrong kind", [DIG_E_FULL] = "limit reached", [DIG_E_MEMORY] = "not enough memory",
        [DIG_E_FINITE] = "non-finite number", [DIG_E_BUSY] = "busy", [DIG_E_FILE] = "file error", [DIG_E_FORMAT] = "bad file",
    };
    return (unsigned)s < DIG_STATUS_COUNT ? names[s] : "unknown status";
}
