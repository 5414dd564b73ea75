#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# api.sh LIBRARY.so: fails unless what include/knurl declares with KN_API is what the library exports, and every such
# function is used by some test program.
set -eu
library=$1
temporary=$(mktemp -d)
trap 'rm -rf "$temporary"' EXIT

cat include/knurl/*.h | sed 's|//.*||; /^ *#/d' | tr '\n' ' ' | tr ';{}' '\n\n\n' | sed -n 's/.*\bKN_API\b *\([^(]*\)(.*/\1/p' |
    sed 's/.*[ *]\(kn_[a-z0-9_]*\) *$/\1/' | LC_ALL=C sort >"$temporary/declared"
nm -D --defined-only "$library" | awk '{ print $NF }' | LC_ALL=C sort >"$temporary/exported"
cat tests/*/*.c | tr -cs 'A-Za-z0-9_' '\n' | grep '^kn_' | LC_ALL=C sort -u >"$temporary/tested"

status=0
say()
{
    LC_ALL=C comm "$1" "$temporary/$2" "$temporary/$3" >"$temporary/odd"
    test -s "$temporary/odd" || return 0
    sed "s/^/$4: /" "$temporary/odd"
    status=1
}
say -23 declared exported 'declared, not exported'
say -13 declared exported 'exported, not declared'
say -23 declared tested 'not in any test'
test "$(wc -l <"$temporary/declared")" -gt 0
exit $status
