#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# fuzz_table.sh: rewrites the table of tests/fuzz/README.md, which public function which fuzzer reaches.
set -eu
readme=tests/fuzz/README.md
temporary=$(mktemp -d)
trap 'rm -rf "$temporary"' EXIT
cat include/knurl/*.h | sed 's|//.*||; /^ *#/d' | tr '\n' ' ' | tr ';{}' '\n\n\n' | sed -n 's/.*\bKN_API\b *\([^(]*\)(.*/\1/p' |
    sed 's/.*[ *]\(kn_[a-z0-9_]*\) *$/\1/' | LC_ALL=C sort >"$temporary/declared"
sed '/^| f[a-z0-9_.]* | kn_/d' "$readme" >"$temporary/readme"
for file in tests/fuzz/fuzz_*.c tests/fuzz/feed.h; do
    names=$(tr -cs 'A-Za-z0-9_' '\n' <"$file" | grep '^kn_' | LC_ALL=C sort -u | LC_ALL=C comm -12 - "$temporary/declared")
    echo "| $(basename "$file" .c) |" $names '|'
done >>"$temporary/readme"
cp "$temporary/readme" "$readme"
