#!/usr/bin/env bash
# tests/lint/globals.sh - the libraries keep no state of their own and never take the host down.
#
# Sections .data, .bss and their kin are empty in every object (tables of pointers that are const lie
# in .data.rel.ro), and nothing calls what prints, ends the process or depends on hidden state.
# Judged on the plain build: sanitizers and assertions add their own.
set -u
bad=0
libraries=()
for library in "${BUILD:-build}"/libdigbox.a "${BUILD:-build}"/libdigbox_render.a; do
    [ -e "$library" ] && libraries+=("$library")
done
[ "${#libraries[@]}" -gt 0 ] || { echo "no library in ${BUILD:-build}: run make first"; exit 1; }

# Section sizes say whether, symbols say what.
size -A "${libraries[@]}" | awk '
    / \(ex / { object = $1 }
    $1 ~ /^\.(data|bss|tdata|tbss|ldata|lbss)/ && $1 !~ /^\.data\.rel\.ro/ && $2 > 0 {
        print object ": " $2 " bytes that can change in " $1; n++ }
    END { exit n > 0 }' || bad=1
if [ $bad -ne 0 ]; then
    objdump -t "${libraries[@]}" | awk '
        /file format/ { object = $1 }
        $0 ~ /[ \t](\.(data|bss|tdata|tbss)[^ \t]*|\*COM\*)[ \t]/ && $0 !~ /\.data\.rel\.ro/ && $0 ~ / O / { print object " " $NF }'
fi

banned='printf|vprintf|fprintf|vfprintf|puts|putchar|perror|exit|_exit|_Exit|quick_exit|abort|__assert_fail'
banned="$banned|(__)?(v?f?printf)_chk|stdout|stderr|system|rand|srand|random|srandom|drand48|strtok|localtime|gmtime|setlocale|signal"
nm -A "${libraries[@]}" | awk -v banned="^(${banned})\$" '
    NF > 2 && $(NF - 1) == "U" && $NF ~ banned { print $1 " calls " $NF; n++ }
    END { exit n > 0 }' || bad=1
exit $bad
