#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# coverage.sh BUILD SOURCE...: lines of the sources that ran, by file where it is below 90 %, and by module. Fails when
# kernel/, bezier/ or spline/ is below 95 %.
set -eu
build=$1
shift
for source in "$@"; do
    gcov -n -o "$build/obj/$(dirname "$source")" "$build/obj/$source.o" 2>/dev/null |
        awk -v wanted="$source" '/^File/ { here = $0 ~ "\047" wanted "\047" }
            here && /^Lines executed/ { split($0, part, /[:% ]+/); print wanted, part[3], part[5]; exit }'
done | awk '
    { split($1, path, "/"); ran = $2 / 100 * $3; lines[path[1]] += $3; covered[path[1]] += ran; all += $3; hit += ran
      if ($2 < 90) printf "%6.1f %% of %5d  %s\n", $2, $3, $1 }
    END { for (m in lines) printf "%6.1f %% of %5d  %s/\n", 100 * covered[m] / lines[m], lines[m], m
          if (!all) { print "no coverage data"; exit 1 }
          printf "%6.1f %% of %5d  in all\n", 100 * hit / all, all
          split("kernel bezier spline", floor, " ")
          for (k in floor) {
              m = floor[k]
              if (lines[m] && 100 * covered[m] / lines[m] >= 95) continue
              printf "%s/ is below 95 %%\n", m
              bad = 1
          }
          exit bad }'
