#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# fuzz_once.sh PROGRAM FOLDER RUNS: a short, repeatable run of a fuzz target; an input that crashes stays in FOLDER.
set -eu
program=$1 folder=$2 runs=$3
name=$(basename "$program")
case $name in # an input of these is a program of calls
fuzz_bpt | fuzz_g2) ;;
fuzz_shell | fuzz_kinds | fuzz_model | fuzz_tiling) runs=$((runs / 100)) ;;
fuzz_trim) runs=$((runs / 200)) ;;
fuzz_fold) runs=$((runs / 400)) ;; # an answer takes tens of milliseconds
*) runs=$((runs / 25)) ;;
esac
seeds=$(pwd)/tests/fuzz/corpus/${name#fuzz_}
mkdir -p "$folder"
cd "$folder"
rm -f crash-input
export ASAN_OPTIONS=detect_leaks=1:allocator_may_return_null=1:handle_abort=1 UBSAN_OPTIONS=print_stacktrace=1
timeout --kill-after=5 120 "$program" "$seeds" "$runs"
