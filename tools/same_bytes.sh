#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# same_bytes.sh FOLDER KNURL...: fails unless every build of the command, with one thread and with three, writes the
# same files bit for bit. The builds differ in compiler and optimisation.
set -eu
folder=$1
shift
test $# -gt 1
rm -rf "$folder"
mkdir -p "$folder"
export ASAN_OPTIONS=detect_leaks=0:allocator_may_return_null=1 # leaks are looked for in the tests
base=$folder/base.bpt # two patches of the teapot: a part of its rim
{ echo 2; sed -n 2,35p data/teapot.bpt; } >"$base"
for tile in chain knurl bump; do
    reference=
    for knurl in "$@"; do
        for threads in 1 3; do
            now=$folder/now
            mkdir -p "$now"
            "$knurl" apply "$base" --tile $tile --count 2,1 --normal-tol 1e-3 --threads $threads --quiet \
                -o "$now/a.step" -o "$now/a.stl" -o "$now/a.obj"
            for file in a.step a.stl a.obj; do test -s "$now/$file"; done
            if [ -z "$reference" ]; then
                reference=$folder/$tile
                mv "$now" "$reference"
            else
                diff -rq "$reference" "$now" || { echo "$tile: $knurl, $threads threads: not the same bytes"; exit 1; }
            fi
        done
    done
done
