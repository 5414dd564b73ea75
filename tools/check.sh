#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# check.sh O JOBS: all that `make check` does after set-up. One line for each step with its seconds and its processor
# seconds, the log of each failure, and at the end "N passed, N failed, N skipped": every cmocka test counts, and so
# does every step. Steps that need one core run JOBS at a time and are reported in their order.
set -u
out=$1 jobs=$2
make=${MAKE:-make}
unset CC CXX CFLAGS CXXFLAGS LDFLAGS config O
mkdir -p "$out/check"
out=$(cd "$out" && pwd)
logs=$out/check
stage=$out/stage
passed=0 failed=0 skipped=0 failures=
begin=$SECONDS
trap 'trap - INT; kill -TERM 0' INT # what runs in the background does not hear it by itself

# line NAME RESULT SECONDS PROCESSOR_SECONDS
line()
{
    printf '%-28s %-44s %4d s %5.0f s of work\n' "$@"
}

# work FILE: the processor seconds of finished children, from what `times` wrote.
work()
{
    awk -F '[ms ]+' 'NR == 2 { print 60 * ($1 + $3) + $2 + $4 }' "$1"
}

# alone NAME COMMAND...: runs it in a shell of its own and notes "ok|FAILED seconds".
alone()
{
    local name=$1 result=FAILED start=$SECONDS
    shift
    if "$@" >"$logs/$name.log" 2>&1; then result=ok; fi
    times >"$logs/$name.times"
    echo "$result $((SECONDS - start))" >"$logs/$name.result"
}

# start NAME COMMAND...: one test, beside those started before it, at most JOBS at a time. settle reports them.
started=()
start()
{
    while [ "$(jobs -rp | wc -l)" -ge "$jobs" ]; do wait -n; done
    rm -f "$logs/$1.result"
    alone "$@" &
    started+=("$1:$!")
}

# settle: waits for what was started and reports it in the order of starting.
settle()
{
    local each name result seconds
    for each in "${started[@]}"; do
        name=${each%:*} result=FAILED seconds=0
        wait "${each##*:}"
        if [ -f "$logs/$name.result" ]; then read -r result seconds <"$logs/$name.result"; fi
        line "$name" "$result" "$seconds" "$(work "$logs/$name.times")"
        if [ "$result" = ok ]; then
            passed=$((passed + 1))
        else
            failed=$((failed + 1)) failures="$failures $name"
            sed 's/^/    /' "$logs/$name.log" | grep -avE '^      [A-Z]+ +[^ ]*$|Nothing to be done' | tail -n 40
        fi
    done
    started=()
}

# step NAME COMMAND...: one test, by itself.
step()
{
    start "$@"
    settle
}

# suite NAME CONFIG WHAT ARGUMENTS...: builds WHAT of a configuration (one test), then runs its tests, the slowest of the
# first suite first.
suite()
{
    local name=$1 config=$2 what=$3 root=$out argument
    shift 3
    for argument in "$@"; do case $argument in O=*) root=${argument#O=} ;; esac; done
    step "$name-build" "$make" -k config="$config" O="$root" "$@" $what
    local folder=$root/$config/test-logs p=0 f=1 s=0 seconds
    rm -f "$folder/counts"
    KN_TEST_TIMES=$out/release/test-logs/times start "$name" "$make" config="$config" O="$root" "$@" test-built
    wait
    started=()
    read -r _ seconds <"$logs/$name.result"
    if [ -f "$folder/counts" ]; then read -r p f s <"$folder/counts"; fi
    passed=$((passed + p)) failed=$((failed + f)) skipped=$((skipped + s))
    line "$name" "$p passed, $f failed, $s skipped" "$seconds" "$(work "$logs/$name.times")"
    if [ "$f" != 0 ]; then
        failures="$failures $name"
        sed 's/^/    /' "$logs/$name.log" | tail -n 200
    fi
}

suite release release 'all tests fuzzers benches'
start cppcheck "$make" O="$out" cppcheck
start selftest "$make" O="$out" selftest
start layers "$make" O="$out" layers
start symbols "$make" O="$out" symbols
start api "$make" O="$out" api
if command -v python3 >/dev/null; then
    start tiles "$make" O="$out" tiles-check
else
    skipped=$((skipped + 1))
fi
start headers "$make" O="$out" headers
start format "$make" O="$out" format
settle
step install "$make" O="$out" install DESTDIR="$stage" PREFIX=/usr
start install-pkgconfig tools/install_check.sh pkgconfig "$stage" "$out/embed-pkgconfig"
start install-cmake tools/install_check.sh cmake "$stage" "$out/embed-cmake"
start readme tools/install_check.sh README.md "$stage" "$out/embed-readme"
start algebra tools/install_check.sh docs/algebra.md "$stage" "$out/embed-algebra"
settle
step uninstall bash -c "test -d '$stage/usr/include/knurl' && \"$make\" O='$out' uninstall DESTDIR='$stage' PREFIX=/usr && test -z \"\$(find '$stage' ! -type d)\""
# No fuzzers and benches: the suite runs none of them, and clang's warnings of them are among those of tidy.
suite clang release 'all tests' CC=clang O="$out/clang"
# No benches: nothing runs them here. Of random cases a quarter: the sanitizers look at the paths, the other suites at
# the values, and instrumented code takes four times as long.
KN_TEST_SCALE=${KN_TEST_SCALE:-0.25} suite sanitize sanitize 'all tests fuzzers'
for target in tests/fuzz/fuzz_*.c; do
    test -e "$target" || continue
    name=$(basename "$target" .c)
    start "$name" tools/fuzz_once.sh "$out/sanitize/tests/fuzz/$name" "$logs/$name" "${FUZZ_RUNS:-100000}"
done
start same-bytes tools/same_bytes.sh "$out/same-bytes" "$out/release/knurl" "$out/clang/release/knurl" "$out/sanitize/knurl"
start tidy "$make" O="$out" -k tidy
settle

echo "$((SECONDS - begin)) s; logs in ${logs#"$PWD"/}${failures:+; failed:$failures}"
echo "$passed passed, $failed failed, $skipped skipped"
test "$failed" = 0 && test "$passed" -gt 0
