/* crowd/wide16.c - the substeps, sixteen rows at a time: the text of wide.c, for registers that long. */
#define AT_ONCE 16
#include "crowd/wide.c"
