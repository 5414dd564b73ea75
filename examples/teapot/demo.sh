#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# The Utah teapot in chain mail, in scales and in diamond knurling: STEP, GLB, STL and a picture of each, and one table;
# and a picture of how high a texture may be where.
# usage: demo.sh KNURL OUT      KNURL: the command; OUT: the folder for the results
set -eu

knurl=$1
out=$2
base=$(dirname "$0")/../../data/teapot.bpt
mkdir -p "$out"

# One value of the report on standard input: a number behind "key": (the first one), degrees as "a,b".
field() {
    awk -v key="\"$1\":" '
        $1 == key && $2 == "[" { getline a; getline b; gsub(/[ ,]/, "", a); gsub(/ /, "", b); print a "," b; exit }
        $1 == key { sub(/,$/, "", $2); print $2; exit }'
}

megabytes() {
    awk -v bytes="$(wc -c <"$1")" 'BEGIN { printf "%.1f", bytes / 1e6 }'
}

row() { # name: one line of the table from its report and files
    report=$out/teapot-$1.json
    printf '%-7s %6s %8s %7s %11s %12s %9s %8s %8s %8s %9s %9s\n' "$1" "$(field cells <"$report")" \
        "$(field patches <"$report")" "$(field degree <"$report")" "$(field control_points <"$report")" \
        "$(field length_error <"$report" | awk '{ printf "%.1e", $1 }')" \
        "$(field angle_error_rad <"$report" | awk '{ printf "%.1e", $1 }')" \
        "$(megabytes "$out/teapot-$1.step")" "$(megabytes "$out/teapot-$1.glb")" "$(megabytes "$out/teapot-$1.stl")" \
        "$(field total <"$report" | awk '{ printf "%.1f", $1 }')" "$2"
}

texture() { # name, then options of apply
    name=$1
    shift
    echo "teapot in $name ..." >&2
    "$knurl" apply "$base" --tile "$name" --unit cm --json "$@" -o "$out/teapot-$name.step" \
        -o "$out/teapot-$name.glb" -o "$out/teapot-$name.stl" >"$out/teapot-$name.json"
    began=$(date +%s.%N)
    "$knurl" render "$out/teapot-$name.glb" --width 1280 --height 960 -o "$out/teapot-$name.png"
    row "$name" "$(date +%s.%N | awk -v b="$began" '{ printf "%.1f", $1 - b }')" >>"$out/table.txt"
}

printf '%-7s %6s %8s %7s %11s %12s %9s %8s %8s %8s %9s %9s\n' tile cells patches degree "ctrl points" "length err <" \
    "angle <" "STEP MB" "GLB MB" "STL MB" "apply s" "render s" >"$out/table.txt"
texture chain --size 0.42 --normal-tol 1e-4 --tol 0.008
texture scale --size 0.36 --normal-tol 1e-4
texture knurl --size 0.22 --normal-tol 1e-4
echo "teapot, checked for a texture of height 0.2 ..." >&2
"$knurl" check "$base" --height 0.2 --unit cm -q -o "$out/teapot-heat.png" || test $? = 4 # it folds at its foot
cat "$out/table.txt"
echo "pictures and files: $out"
