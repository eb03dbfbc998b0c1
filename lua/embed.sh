#!/bin/sh
# lua/embed.sh - turns the Lua files of digbox into one C file, so that they travel inside the program.
#
#   lua/embed.sh lua/digbox/*.lua > build/embedded.c
#
# The name of an entry is the file's base name without .lua.
set -eu
echo '/* Made by lua/embed.sh; do not edit. */'
echo '#include <stddef.h>'
echo
echo 'struct digbox_source { const char *name; const char *text; size_t size; };'
echo 'extern const struct digbox_source digbox_embedded[];'
n=0
for file in "$@"; do
    echo
    echo "static const unsigned char text_$n[] = {"
    od -An -v -tu1 "$file" | sed 's/  */,/g; s/^,//; s/$/,/'
    echo '0};'
    n=$((n + 1))
done
echo
echo 'const struct digbox_source digbox_embedded[] = {'
n=0
for file in "$@"; do
    name=$(basename "$file" .lua)
    echo "    {\"$name\", (const char *)text_$n, sizeof text_$n - 1},"
    n=$((n + 1))
done
echo '    {NULL, NULL, 0}'
echo '};'
