#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Shows that layers.sh, symbols.sh, api.sh, coverage.sh and tests/run.sh can fail: plants one violation at a time in a
# temporary copy.
set -eu
tools=$(cd "$(dirname "$0")" && pwd)
cc=${CC:-gcc}
temporary=$(mktemp -d)
trap 'rm -rf "$temporary"' EXIT
tests=0

wrong()
{
    echo "selftest: $1" >&2
    exit 1
}

# layer FILE TEXT: with FILE holding TEXT, layers.sh must fail and name FILE.
layer()
{
    tests=$((tests + 1))
    root=$temporary/layers
    rm -rf "$root"
    mkdir -p "$root/include/knurl" "$root/kernel" "$root/bezier" "$root/trivar" "$root/compose" "$root/io" \
        "$root/bridges/a" "$root/bridges/b" "$root/cli" "$root/examples/embed" "$root/tests/io" "$root/tests/support"
    for header in base bezier shell compose io knurl; do echo '#include <stddef.h>' >"$root/include/knurl/$header.h"; done
    for header in kernel/k bezier/z trivar/t compose/c io/i bridges/shared bridges/a/a bridges/b/b cli/l tests/support/support; do
        echo '#include <knurl/base.h>' >"$root/$header.h"
    done
    printf '#include "i.h"\n#include "compose/c.h"\n#include <math.h>\n' >"$root/io/good.c"
    printf '#include "bridges/shared.h"\n#include <iostream>\n' >"$root/bridges/a/good.cpp"
    printf '#include <knurl/shell.h>\n# include "kernel/k.h"\n' >"$root/compose/good.c"
    printf '#include "tests/support/support.h"\n#include "io/i.h"\n' >"$root/tests/io/t_good.c"
    "$tools/layers.sh" "$root" >/dev/null || wrong "layers.sh refuses a good tree"
    printf '%b\n' "$2" >"$root/$1"
    if "$tools/layers.sh" "$root" >"$temporary/out"; then wrong "layers.sh accepts $1: $2"; fi
    grep -q "^$1:" "$temporary/out" || wrong "layers.sh does not name $1"
}
layer kernel/bad.c '#include "bezier/z.h"'
layer kernel/bad.c '#include <knurl/bezier.h>'
layer bezier/bad.c 'int x;\n  #  include "io/i.h"'
layer compose/bad.c '#include "trivar/t.h"'
layer compose/bad.c '#include <knurl/knurl.h>'
layer io/bad.c '#include "bridges/a/a.h"'
layer io/bad.c '#include <jansson.h>'
layer kernel/bad.c '#include "../bezier/z.h"'
layer kernel/bad.c '#include "gone.h"'
layer bridges/a/bad.cpp '#include "bridges/b/b.h"'
layer bridges/a/bad.cpp '#include "cli/l.h"'
layer include/knurl/bezier.h '#include <knurl/shell.h>'
layer include/knurl/base.h '#include "kernel/k.h"'
layer examples/embed/main.c '#include "kernel/k.h"'

# symbol TEXT: a library made from the C code TEXT must be refused.
symbol()
{
    tests=$((tests + 1))
    printf '%b\n' "$1" >"$temporary/s.c"
    $cc -O1 -fPIC -fno-common -c -o "$temporary/s.o" "$temporary/s.c" 2>"$temporary/err" || wrong "does not compile: $1"
    rm -f "$temporary/libs.a"
    ar rcs "$temporary/libs.a" "$temporary/s.o"
    $cc -shared -o "$temporary/libs.so" "$temporary/s.o"
    "$tools/symbols.sh" "$temporary/libs.a" >/dev/null && static=0 || static=1
    "$tools/symbols.sh" "$temporary/libs.so" >/dev/null && shared=0 || shared=1
}
symbol 'const char *const kn_names[] = {"a", "b"}; static const int t[] = {1, 2}; int kn_f(int i) { return t[i]; }'
test $static$shared = 00 || wrong "symbols.sh refuses a good library ($static $shared)"
symbol 'int other(void) { return 1; }'
test $static$shared = 11 || wrong "symbols.sh accepts a foreign name ($static $shared)"
symbol 'int kn_counter; int kn_f(void) { return ++kn_counter; }'
test $static$shared = 11 || wrong "symbols.sh accepts a writable global ($static $shared)"
symbol 'int kn_f(void) { static int n = 4; return ++n; }'
test $static = 1 || wrong "symbols.sh accepts a writable static"
symbol '_Thread_local int kn_t = 3; int kn_f(void) { return ++kn_t; }'
test $static$shared = 11 || wrong "symbols.sh accepts thread-local state ($static $shared)"
symbol '#include <stdio.h>\nvoid kn_f(int n) { printf("%d", n); }'
test $static$shared = 11 || wrong "symbols.sh accepts printing ($static $shared)"
symbol '#include <stdlib.h>\nvoid kn_f(void) { exit(1); }'
test $static$shared = 11 || wrong "symbols.sh accepts exit ($static $shared)"

# api DECLARED DEFINED TESTED [FUZZED [TABLE]]: 0 when api.sh is content with these functions in a header, a library, a
# test, a fuzzer and its table; without the last ones all that is declared is there.
api()
{
    tests=$((tests + 1))
    root=$temporary/api
    rm -rf "$root"
    mkdir -p "$root/include/knurl" "$root/tests/io" "$root/tests/fuzz"
    for name in $1; do printf '// KN_API int kn_old(void);\nKN_API KN_CHECKED int *\n%s(int a,\n    int b);\n' "$name"; done \
        >"$root/include/knurl/x.h"
    for name in $2; do echo "int *$name(int a, int b) { return (void)a, (void)b, (int *)0; }"; done >"$root/x.c"
    for name in $3; do echo "$name(1, 2);"; done >"$root/tests/io/t_x.c"
    for name in ${4-$1}; do echo "$name(1, 2);"; done >"$root/tests/fuzz/fuzz_x.c"
    echo "| fuzz_x | ${5-${4-$1}} |" >"$root/tests/fuzz/README.md"
    $cc -shared -fPIC -o "$root/x.so" "$root/x.c"
    (cd "$root" && "$tools/api.sh" x.so >"$temporary/out") && status=0 || status=1
}
api 'kn_a kn_b' 'kn_b kn_a' 'kn_a kn_b kn_c'
test $status = 0 || wrong "api.sh refuses what is in order"
api 'kn_a kn_b' 'kn_a' 'kn_a kn_b'
test $status = 1 || wrong "api.sh accepts what is declared and not exported"
api 'kn_a' 'kn_a kn_b' 'kn_a kn_b'
test $status = 1 || wrong "api.sh accepts what is exported and not declared"
api 'kn_a kn_b' 'kn_a kn_b' 'kn_a kn_bb'
test $status = 1 || wrong "api.sh accepts what no test uses"
api 'kn_a kn_b' 'kn_a kn_b' 'kn_a kn_b' 'kn_b'
test $status = 1 || wrong "api.sh accepts what no fuzzer reaches"
api 'kn_a kn_b' 'kn_a kn_b' 'kn_a kn_b' 'kn_a kn_b' 'kn_a'
test $status = 1 || wrong "api.sh accepts a table that lacks a function"
api 'kn_a kn_b' 'kn_a kn_b' 'kn_a kn_b' 'kn_a kn_b' 'kn_a kn_b kn_c'
test $status = 1 || wrong "api.sh accepts a table that promises too much"

# cover KERNEL SPLINE: coverage.sh on three modules, of which kernel/ and spline/ run in full (1) or in part (0).
cover()
{
    tests=$((tests + 1))
    root=$temporary/coverage
    rm -rf "$root"
    for module in kernel bezier spline; do
        mkdir -p "$root/$module" "$root/obj/$module"
        printf 'int %s(int a);\nint %s(int a)\n{\n    if (a)\n        return 1;\n    return 0;\n}\n' $module $module \
            >"$root/$module/x.c"
        (cd "$root" && gcc --coverage -c -o "obj/$module/x.c.o" "$module/x.c")
    done
    printf 'int %s(int a);\n' kernel bezier spline >"$root/main.c"
    echo "int main(void) { return kernel($1) + bezier(1) + bezier(0) + spline($2) + (kernel(0) + spline(0)) * 0 - 3; }" \
        >>"$root/main.c"
    (cd "$root" && gcc --coverage -o main main.c obj/*/x.c.o && ./main >/dev/null) || true
    (cd "$root" && "$tools/coverage.sh" . kernel/x.c bezier/x.c spline/x.c >"$temporary/out") && status=0 || status=1
}
cover 1 1
test $status = 0 || wrong "coverage.sh refuses what ran in full"
cover 0 1
test $status = 1 || wrong "coverage.sh accepts a kernel/ that ran in part"
cover 1 0
test $status = 1 || wrong "coverage.sh accepts a spline/ that ran in part"

# program NAME BODY EXPECTED: tests/run.sh on a program of three tests, the last with BODY, counts EXPECTED.
program()
{
    tests=$((tests + 1))
    printf '%b\n' '#include <stdarg.h>\n#include <stddef.h>\n#include <stdint.h>\n#include <setjmp.h>\n#include <cmocka.h>' \
        '#include <signal.h>\n#include <stdlib.h>\n#include <stdio.h>\n' \
        'static void a(void **s) { (void)s; printf("no end of line"); }\nstatic void b(void **s) { (void)s; skip(); }' \
        "static void c(void **s) { (void)s; $2 }" \
        'int main(void) { const struct CMUnitTest t[] = {cmocka_unit_test(a), cmocka_unit_test(b), cmocka_unit_test(c)};' \
        'return cmocka_run_group_tests_name("x/y", t, NULL, NULL); }' >"$temporary/t_$1.c"
    $cc -o "$temporary/t_$1" "$temporary/t_$1.c" -lcmocka
    KN_TEST_TIMEOUT=1 "$tools/../tests/run.sh" "$temporary/run" 1 "$temporary/t_$1" >"$temporary/out" && status=0 || status=1
    test "$(cat "$temporary/run/counts")" = "$3" || wrong "tests/run.sh counts $(cat "$temporary/run/counts") for $1"
    test "$status" = "$(echo "$3" | awk '{ print ($2 > 0) }')" || wrong "tests/run.sh answers $status for $1"
}
program passes '' '2 0 1'
program fails 'assert_int_equal(1, 2);' '1 1 1'
program crashes '*(volatile int *)0 = 1;' '1 1 1'
program aborts 'signal(6, SIG_DFL), abort();' '1 1 1'
program leaves 'exit(0);' '1 1 1'
program hangs 'for (;;) {}' '1 1 1'
"$tools/../tests/run.sh" "$temporary/run" 1 >/dev/null && wrong "tests/run.sh is content with no tests"
"$tools/../tests/run.sh" "$temporary/run" 1 "$temporary/gone" >/dev/null && wrong "tests/run.sh is content with a missing program"

echo "selftest: $tests planted cases behave"
