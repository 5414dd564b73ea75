#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# run.sh FOLDER JOBS PROGRAM...: runs cmocka programs JOBS at a time, each with its log in FOLDER, shows the logs of
# those that fail, and writes "passed failed skipped" to FOLDER/counts. Fails if anything failed or nothing ran.
# A program that crashes, hangs, loses tests or has none counts as one failure more. FOLDER/times holds the processor
# seconds of each program; with such a file of an earlier run in KN_TEST_TIMES the slowest start first.
set -u
folder=$1 jobs=$2
shift 2
earlier=$(sort -rn "${KN_TEST_TIMES:-/dev/null}" 2>/dev/null)
rm -rf "$folder"
mkdir -p "$folder/tmp"

run_one()
{
    log=$1/$(basename "$(dirname "$2")").$(basename "$2").log
    KN_TEST_TMP=$1/tmp CMOCKA_MESSAGE_OUTPUT=TAP timeout --kill-after=5 "${KN_TEST_TIMEOUT:-180}" "$2" >"$log" 2>&1 &
    group=$! # timeout leads a process group
    wait $group
    printf '\nrun.sh: exit %d\n' $? >>"$log"
    kill -KILL -- -$group 2>/dev/null # what a program that was stopped left running
    times >"$log.times"
    awk -v program="$(basename "$(dirname "$2")")/$(basename "$2")" -F '[ms ]+' \
        'NR == 2 { printf "%.2f %s\n", 60 * ($1 + $3) + $2 + $4, program }' "$log.times" >>"$1/times"
    rm -f "$log.times"
}
export -f run_one
folder=$(cd "$folder" && pwd)
export ASAN_OPTIONS=detect_leaks=1:allocator_may_return_null=1:handle_abort=1${ASAN_OPTIONS:+:$ASAN_OPTIONS}
export UBSAN_OPTIONS=print_stacktrace=1
export LSAN_OPTIONS=suppressions=$PWD/tests/lsan.supp:print_suppressions=0

# in_order PROGRAM...: those of earlier times first, the slowest of all at the head.
in_order()
{
    { awk '{ print "first", $2 }' <<<"$earlier"; printf 'all %s\n' "$@"; } | awk '
        $1 == "first" { place[$2] = ++known; next }
        { n = split($2, part, "/"); at = place[part[n - 1] "/" part[n]]; print at ? at : known + 1, $2 }' |
        sort -s -n -k 1,1 | sed 's/^[0-9]* //'
}
test $# = 0 || in_order "$@" | tr '\n' '\0' | xargs -0 -n 1 -P "$jobs" bash -c 'run_one "$0" "$1"' "$folder"

passed=0 failed=0 skipped=0
for program in "$@"; do
    name=$(basename "$(dirname "$program")")/$(basename "$program")
    log=$folder/$(basename "$(dirname "$program")").$(basename "$program").log
    results=$(grep -aoE '(not )?ok [0-9]+ (- |# SKIP)' "$log")
    planned=$(grep -aoE '^1\.\.[0-9]+$' "$log" | sed 's/^1\.\.//' | awk '{ n += $1 } END { print n + 0 }')
    p=$(grep -cE '^ok [0-9]+ - ' <<<"$results")
    f=$(grep -cE '^not ok [0-9]+ - ' <<<"$results")
    s=$(grep -cE 'ok [0-9]+ # SKIP' <<<"$results")
    status=$(tail -n 1 "$log" | sed -n 's/^run.sh: exit //p')
    if [ $((p + f + s)) != "${planned:-0}" ] || [ $((p + f + s)) = 0 ] || { [ "$status" != 0 ] && [ "$f" = 0 ]; }; then
        f=$((f + 1))
        echo "FAILED $name: exit ${status:-unknown}, $((p + f + s - 1)) of ${planned:-0} tests reported"
    elif [ "$f" != 0 ]; then
        echo "FAILED $name: $f of $planned tests"
    fi
    test "$f" = 0 || sed 's/^/    /' "$log" | tail -n 60
    passed=$((passed + p)) failed=$((failed + f)) skipped=$((skipped + s))
done
rm -rf "$folder/tmp"
if [ $((passed + failed)) = 0 ]; then
    echo "FAILED: no test ran"
    failed=1
fi
echo "$passed $failed $skipped" >"$folder/counts"
echo "$passed passed, $failed failed, $skipped skipped"
test "$failed" = 0
