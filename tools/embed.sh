#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# embed.sh ROOT FILE... > embedded.c: the files as constant bytes, named by their paths below ROOT (io/embedded.h).
set -eu
root=$1
shift

echo '// Made by tools/embed.sh; do not edit.'
echo '#include "io/embedded.h"'
n=0
for file in "$@"; do
    echo "static const unsigned char file_$n[] = {"
    od -An -v -tu1 "$file" | sed 's/^ *//; s/  */,/g; s/$/,/'
    echo '0};'
    n=$((n + 1))
done
echo 'const kn_embedded_file kn_embedded_files[] = {'
n=0
for file in "$@"; do
    echo "    {\"${file#"$root"/}\", (const char *)file_$n, sizeof file_$n - 1},"
    n=$((n + 1))
done
echo '    {0, 0, 0},'
echo '};'
echo "const size_t kn_embedded_file_count = $n;"
