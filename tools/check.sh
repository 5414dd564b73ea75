#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# check.sh O JOBS: all that `make check` does after set-up. One line for each step, the log of each failure, and at
# the end "N passed, N failed, N skipped": every cmocka test counts, and so does every step.
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

line()
{
    printf '%-28s %-44s %4d s\n' "$1" "$2" $((SECONDS - start))
}

# step NAME COMMAND...: one test.
step()
{
    local name=$1
    start=$SECONDS
    shift
    if "$@" >"$logs/$name.log" 2>&1; then
        passed=$((passed + 1))
        line "$name" ok
    else
        failed=$((failed + 1)) failures="$failures $name"
        line "$name" FAILED
        sed 's/^/    /' "$logs/$name.log" | grep -avE '^      [A-Z]+ +[^ ]*$|Nothing to be done' | tail -n 40
    fi
}

# suite NAME CONFIG ARGUMENTS...: builds the tests of a configuration (one test), then runs them.
suite()
{
    local name=$1 config=$2 root=$out argument
    shift 2
    for argument in "$@"; do case $argument in O=*) root=${argument#O=} ;; esac; done
    step "$name-build" "$make" -k config="$config" O="$root" "$@" all tests fuzzers benches
    start=$SECONDS
    local folder=$root/$config/test-logs p=0 f=1 s=0
    rm -f "$folder/counts"
    "$make" config="$config" O="$root" "$@" test-built >"$logs/$name.log" 2>&1
    if [ -f "$folder/counts" ]; then read -r p f s <"$folder/counts"; fi
    passed=$((passed + p)) failed=$((failed + f)) skipped=$((skipped + s))
    line "$name" "$p passed, $f failed, $s skipped"
    if [ "$f" != 0 ]; then
        failures="$failures $name"
        sed 's/^/    /' "$logs/$name.log" | tail -n 200
    fi
}

suite release release
step layers "$make" O="$out" layers
step symbols "$make" O="$out" symbols
step api "$make" O="$out" api
step selftest "$make" O="$out" selftest
if command -v python3 >/dev/null; then
    step tiles "$make" O="$out" tiles-check
else
    skipped=$((skipped + 1))
fi
step headers "$make" O="$out" headers
step format "$make" O="$out" format
step install "$make" O="$out" install DESTDIR="$stage" PREFIX=/usr
step install-pkgconfig tools/install_check.sh pkgconfig "$stage" "$out/embed-pkgconfig"
step install-cmake tools/install_check.sh cmake "$stage" "$out/embed-cmake"
step readme tools/install_check.sh README.md "$stage" "$out/embed-readme"
step algebra tools/install_check.sh docs/algebra.md "$stage" "$out/embed-algebra"
step uninstall bash -c "test -d '$stage/usr/include/knurl' && \"$make\" O='$out' uninstall DESTDIR='$stage' PREFIX=/usr && test -z \"\$(find '$stage' ! -type d)\""
suite clang release CC=clang O="$out/clang"
suite sanitize sanitize
for target in tests/fuzz/fuzz_*.c; do
    test -e "$target" || continue
    name=$(basename "$target" .c)
    step "$name" tools/fuzz_once.sh "$out/sanitize/tests/fuzz/$name" "$logs/$name" "${FUZZ_RUNS:-100000}"
done
step same-bytes tools/same_bytes.sh "$out/same-bytes" "$out/release/knurl" "$out/clang/release/knurl" "$out/sanitize/knurl"
step tidy "$make" O="$out" -k tidy
step cppcheck "$make" O="$out" cppcheck

echo "$((SECONDS - begin)) s; logs in ${logs#"$PWD"/}${failures:+; failed:$failures}"
echo "$passed passed, $failed failed, $skipped skipped"
test "$failed" = 0 && test "$passed" -gt 0
