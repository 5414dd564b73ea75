#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# coverage.sh BUILD SOURCE...: lines of the sources and of the headers beside them that ran, by file where it is below
# 90 %, and by module. A line counts once, wherever it is compiled. Fails when kernel/, bezier/ or spline/ is below 95 %.
set -eu
build=$1
shift
for source in "$@"; do
    gcov -t -o "$build/obj/$(dirname "$source")" "$build/obj/$source.o" 2>/dev/null
done | awk -F: '
    $2 == 0 { if ($3 == "Source") file = $4; next }
    file ~ /^\// || $1 ~ /- *$/ || NF < 3 { next }
    { key = file ":" $2 + 0; seen[key] = 1 }
    $1 !~ /[#=]/ { ran[key] = 1 }
    END { for (key in seen) {
              split(key, part, ":")
              split(part[1], path, "/")
              lines[part[1]]++; lines[path[1] "/"]++; all++
              if (key in ran) { hit[part[1]]++; hit[path[1] "/"]++; all_hit++ }
          }
          if (!all) { print "no coverage data"; exit 1 }
          for (f in lines) {
              percent = 100 * hit[f] / lines[f]
              if (f ~ /\/$/ || percent < 90) printf "%6.1f %% of %5d  %s\n", percent, lines[f], f | "LC_ALL=C sort -k5"
          }
          close("LC_ALL=C sort -k5")
          printf "%6.1f %% of %5d  in all\n", 100 * all_hit / all, all
          split("kernel/ bezier/ spline/", floor, " ")
          for (k in floor) {
              m = floor[k]
              if (lines[m] && hit[m] >= 0.95 * lines[m]) continue
              printf "%s is below 95 %%\n", m
              bad = 1
          }
          exit bad }'
