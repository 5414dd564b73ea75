#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# install_check.sh pkgconfig|cmake|DOCUMENT STAGE WORK: builds a program against the tree installed below STAGE (prefix
# /usr), with nothing of the repository in sight, and runs it. DOCUMENT.md: its first ```c block, which has to print its
# first ```text block if there is one.
set -eu
how=$1 stage=$2 work=$3
root=$(pwd)
mkdir -p "$work"
stage=$(cd "$stage" && pwd)
work=$(cd "$work" && pwd)
rm -rf "${work:?}"/*
export PKG_CONFIG_SYSROOT_DIR="$stage" PKG_CONFIG_LIBDIR="$stage/usr/lib/pkgconfig"
export PKG_CONFIG_ALLOW_SYSTEM_CFLAGS=1 PKG_CONFIG_ALLOW_SYSTEM_LIBS=1
export LD_LIBRARY_PATH="$stage/usr/lib"
cc=${CC:-cc}

# program COMMAND...: it must succeed, load the staged library if it loads any, and leave a STEP file.
program()
{
    rm -f "$work/out.step"
    (cd "$work" && "$@" out.step)
    head -n 1 "$work/out.step" | grep -q 'ISO-10303-21;'
    tail -n 1 "$work/out.step" | grep -q 'END-ISO-10303-21;'
}

case $how in
pkgconfig)
    cp examples/embed/main.c "$work/"
    cd "$work"
    # shellcheck disable=SC2046
    $cc -std=c17 -Wall -Wextra -Werror main.c $(pkg-config --cflags --libs knurl) -o embed
    ldd ./embed | grep "libknurl.so.[0-9]* => $stage/usr/lib/"
    program ./embed
    # shellcheck disable=SC2046
    $cc -std=c17 main.c $(pkg-config --cflags knurl) "$stage/usr/lib/libknurl.a" \
        $(pkg-config --static --libs-only-l knurl | sed 's/-lknurl//') -o embed_static
    program ./embed_static
    ;;
cmake)
    cp examples/embed/main.c examples/embed/CMakeLists.txt "$work/"
    cmake -S "$work" -B "$work/b" -DCMAKE_C_COMPILER="$cc" -DCMAKE_PREFIX_PATH="$stage/usr"
    cmake --build "$work/b"
    program b/embed
    program b/embed_static
    ;;
*.md)
    block()
    {
        awk -v fence='```'"$1" '$0 == fence && !done { inside = 1; next } /^```/ && inside { inside = 0; done = 1 } inside' "$how"
    }
    block c >"$work/program.c"
    block text >"$work/expected"
    test -s "$work/program.c" || { echo "$how has no program"; exit 1; }
    ln -s "$root/data" "$work/data"
    cd "$work"
    # shellcheck disable=SC2046
    $cc -std=c17 -Wall -Wextra -Werror program.c $(pkg-config --cflags --libs knurl) -o program
    ./program >printed
    test ! -s expected || diff expected printed
    ;;
*)
    echo "install_check.sh: what is $how?" >&2
    exit 2
    ;;
esac
