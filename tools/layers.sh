#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# layers.sh [ROOT]: fails unless every #include points downwards in this table, and the core includes only standard
# and POSIX headers from outside.
#
#   0 kernel                     base.h
#   1 bezier                     bezier.h
#   2 spline                     spline.h
#   3 fit construct solve        fit.h construct.h solve.h
#   4 trivar cells fold trim mesh field tile compose  shell.h cells.h fold.h trim.h mesh.h field.h tile.h compose.h
#   5 job slice implicit levelset subdiv  job.h slice.h
#   6 io                         io.h
#   7 cad step iges write        cad.h step.h iges.h write.h knurl.h
#   8 bridges/*
#   9 cli examples bench tests
#
# Within a layer, folders see each other's public headers only. Bridges share the headers that lie in bridges/ itself,
# tests share tests/support, and examples see <knurl/...> alone.
set -eu
cd "${1:-.}"

files=$(find kernel bezier spline fit construct solve trivar cells fold trim mesh field tile compose job slice implicit levelset subdiv io cad step iges write bridges cli examples bench tests include \
    -type f \( -name '*.[ch]' -o -name '*.cpp' -o -name '*.hpp' \) 2>/dev/null | LC_ALL=C sort)
# shellcheck disable=SC2086
LC_ALL=C awk '
BEGIN {
    split("base 0 bezier 1 spline 2 fit 3 construct 3 solve 3 shell 4 fold 4 cells 4 trim 4 mesh 4 field 4 tile 4 compose 4 job 5 slice 5 io 6 cad 7 step 7 iges 7 write 7 knurl 7", word, " ")
    for (i = 1; i in word; i += 2) public_level["include/knurl/" word[i] ".h"] = word[i + 1]
    split("kernel 0 bezier 1 spline 2 fit 3 construct 3 solve 3 trivar 4 cells 4 fold 4 trim 4 mesh 4 field 4 tile 4 compose 4 job 5 slice 5 implicit 5" \
          " levelset 5 subdiv 5 io 6 cad 7 step 7 iges 7 write 7 bridges 8 cli 9 examples 9 bench 9 tests 9", word, " ")
    for (i = 1; i in word; i += 2) folder_level[word[i]] = word[i + 1]
    split("assert complex ctype errno fenv float inttypes iso646 limits locale math setjmp signal stdalign stdarg" \
          " stdatomic stdbool stddef stdint stdio stdlib stdnoreturn string tgmath threads time uchar wchar wctype" \
          " pthread sched unistd fcntl sys/types sys/stat immintrin cpuid", word, " ")
    for (i = 1; i in word; i++) allowed["<" word[i] ".h>"] = 1
    for (i = 1; i < ARGC; i++) exists[ARGV[i]] = 1
}
function folder(path,   part) { # bridges/occt and tests/io count as one folder each
    split(path, part, "/")
    return part[1] == "bridges" || part[1] == "tests" || part[1] == "examples" ? part[1] "/" part[2] : part[1]
}
function level(path,   part) {
    if (path in public_level) return public_level[path]
    split(path, part, "/")
    return part[1] in folder_level ? folder_level[part[1]] : -1
}
function bad(why) { printf "%s:%d: %s\n", FILENAME, FNR, why; errors++ }
function check_project(target) {
    if (level(FILENAME) < 0) return bad("a file outside the layer table")
    if (level(target) < 0) return bad("includes " target ", which is in no layer")
    if (level(target) > level(FILENAME)) return bad("includes " target ", which lies above")
    if (target in public_level) return
    if (FILENAME ~ /^include\//) return bad("a public header includes the internal " target)
    if (FILENAME ~ /^examples\//) return bad("an example includes the internal " target)
    if (level(target) == level(FILENAME) && folder(target) != folder(FILENAME) &&
        target !~ /^(tests\/support\/.*|bridges\/[^\/]*)$/)
        return bad("includes " target ", internal to another folder of its layer")
}
/^[ \t]*#[ \t]*include[ \t]*[<"]/ {
    match($0, /[<"][^>"]*[>"]/)
    name = substr($0, RSTART, RLENGTH)
    bare = substr(name, 2, length(name) - 2)
    if (bare ~ /(^|\/)\.\.?\//) { bad("a path with dots: " bare); next }
    here = FILENAME
    sub(/[^\/]*$/, "", here)
    if (name ~ /^<knurl\//) { if (("include/" bare) in exists) check_project("include/" bare); else bad("no " name) }
    else if (name ~ /^"/ && (here bare) in exists) check_project(here bare)
    else if (name ~ /^"/ && bare in exists) check_project(bare)
    else if (name ~ /^"/) bad("no such file in the project: " bare)
    else if (level(FILENAME) >= 0 && level(FILENAME) <= 7 && !(name in allowed)) bad("the core includes " name)
}
END { exit errors > 0 }
' $files
