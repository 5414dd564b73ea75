#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# symbols.sh LIBRARY...: fails unless every global symbol starts with kn_, nothing is writable, and nothing prints,
# exits or keeps hidden state in libc. Static (.a) and shared (.so) libraries.
set -eu

for library in "$@"; do
    case $library in
    *.a) nm -A -f sysv "$library" ;;
    *) nm -A -D -f sysv "$library" ;;
    esac | LC_ALL=C awk -F'|' -v library="$library" '
    BEGIN {
        shared = library ~ /\.so/
        split("printf vprintf puts putchar putc fputs perror stdout stderr stdin exit _exit _Exit quick_exit abort atexit" \
              " rand srand random srandom drand48 setlocale strtok localtime gmtime asctime ctime getenv system tmpnam" \
              " __printf_chk __vprintf_chk putc_unlocked psignal", word, " ")
        for (i = 1; i in word; i++) forbidden[word[i]] = 1
    }
    function bad(why) { printf "%s: %s: %s\n", library, name, why; errors++ }
    NF >= 7 {
        name = $1
        sub(/^.*:/, "", name)
        gsub(/ /, "", name)
        sub(/@.*/, "", name)
        class = $3
        type = $4
        section = $7
        gsub(/ /, "", class)
        gsub(/ /, "", section)
        symbols++
        if (class == "U") {
            if (name in forbidden) bad("a library must not call or use this")
            next
        }
        if (class ~ /[A-Zuvwi]/ && class != "w" && class != "v" && name !~ /^kn_/) bad("global, and does not start with kn_")
        if (type ~ /OBJECT|TLS/ && section ~ /^(\.t?data|\.t?bss|\.l?data|\.l?bss|\*COM\*)/ && section !~ /^\.data\.rel\.ro/)
            bad("writable, in " section)
    }
    END {
        if (!symbols) { print library ": no symbols"; errors++ }
        exit errors > 0
    }'
done
