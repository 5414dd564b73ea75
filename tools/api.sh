#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# api.sh LIBRARY.so: fails unless what include/knurl declares with KN_API is what the library exports, every such
# function is used by some test program and by some fuzzer, and the table of tests/fuzz/README.md says by which.
set -eu
library=$1
temporary=$(mktemp -d)
trap 'rm -rf "$temporary"' EXIT

cat include/knurl/*.h | sed 's|//.*||; /^ *#/d' | tr '\n' ' ' | tr ';{}' '\n\n\n' | sed -n 's/.*\bKN_API\b *\([^(]*\)(.*/\1/p' |
    sed 's/.*[ *]\(kn_[a-z0-9_]*\) *$/\1/' | LC_ALL=C sort >"$temporary/declared"
nm -D --defined-only "$library" | awk '{ print $NF }' | LC_ALL=C sort >"$temporary/exported"
words()
{
    tr -cs 'A-Za-z0-9_' '\n' | grep '^kn_' | LC_ALL=C sort -u
}
for file in tests/*/*.c; do case $file in tests/fuzz/*) ;; *) cat "$file" ;; esac; done | words >"$temporary/tested"
for file in tests/fuzz/fuzz_*.c tests/fuzz/feed.h; do
    test -e "$file" || continue
    words <"$file" | LC_ALL=C comm -12 - "$temporary/declared" | sed "s|^|$(basename "$file" .c) |"
done | LC_ALL=C sort >"$temporary/fuzzing"
sed 's/.* //' "$temporary/fuzzing" | LC_ALL=C sort -u >"$temporary/fuzzed"
# Rows "| fuzzer | kn_a kn_b |" of the table, one pair a line.
sed -n 's/^| \(f[a-z0-9_.]*\) | \(kn_.*\) |$/\1 \2/p' tests/fuzz/README.md |
    awk '{ for (i = 2; i <= NF; i++) print $1, $i }' | LC_ALL=C sort >"$temporary/table"

status=0
say()
{
    LC_ALL=C comm "$1" "$temporary/$2" "$temporary/$3" >"$temporary/odd"
    test -s "$temporary/odd" || return 0
    sed "s|^|$4: |" "$temporary/odd"
    status=1
}
say -23 declared exported 'declared, not exported'
say -13 declared exported 'exported, not declared'
say -23 declared tested 'not in any test'
say -23 declared fuzzed 'not in any fuzzer'
say -23 fuzzing table 'not in tests/fuzz/README.md'
say -13 fuzzing table 'in tests/fuzz/README.md, not so'
test "$(wc -l <"$temporary/declared")" -gt 0
exit $status
