#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Installs what building and testing knurl needs on Debian 12, if it is missing; silent when nothing is.
# Without root (or sudo without a password) it names the missing packages and stops. KNURL_NO_SETUP=1 skips it.
set -eu

# compilers and tools
packages='gcc g++ clang libclang-rt-14-dev clang-format clang-tidy cppcheck cmake pkg-config'
# the command: recipes and reports, glTF (with the headers that its own includes), pictures and their legends
packages="$packages libjansson-dev libtinygltf-dev nlohmann-json3-dev libstb-dev libembree-dev libpng-dev
 libcairo2-dev fonts-dejavu-core"
# expressions; meshes as tiles
packages="$packages libmuparser-dev libopenmesh-dev lib3mf-dev"
# compressed STEP files
packages="$packages zlib1g-dev"
# reading STEP back in tests
packages="$packages libocct-data-exchange-dev libocct-ocaf-dev libocct-modeling-algorithms-dev
 libocct-modeling-data-dev libocct-foundation-dev"
# the test framework, a checker of STL files, a mesher that reads STEP, the library that benchmarks compare with
packages="$packages libcmocka-dev admesh gmsh libsisl-dev"
# pictures of the scenes that knurl writes, in tests (VTK, python3-vtk9, is used where it is there; it is large)
packages="$packages povray"
# exact arithmetic, the oracle of the tests
packages="$packages libflint-dev libflint-arb-dev"

if [ "${1-}" = --list ]; then
    printf '%s\n' $packages
    exit 0
fi
test -z "${KNURL_NO_SETUP-}" || exit 0

installed()
{
    dpkg-query -W -f='${db:Status-Status}' "$1" 2>/dev/null | grep -qx installed
}

if ! command -v dpkg-query >/dev/null; then
    echo "setup: no dpkg here. knurl needs the counterparts of these Debian packages:" >&2
    echo "setup:" $packages >&2
    echo "setup: if they are all there, run make with KNURL_NO_SETUP=1" >&2
    exit 1
fi
missing=
for package in $packages; do
    installed "$package" || missing="$missing $package"
done
test -n "$missing" || exit 0

give_up()
{
    echo "setup: $1; as root, run" >&2
    echo "    apt-get install$missing" >&2
    exit 1
}
command -v apt-get >/dev/null || give_up "packages are missing and there is no apt-get"
as_root=
if [ "$(id -u)" != 0 ]; then
    as_root='sudo -n'
    $as_root true 2>/dev/null || give_up "packages are missing and this user is not root"
fi

log=$(mktemp)
trap 'rm -f "$log"' EXIT
echo "setup: installing$missing" >&2
{
    $as_root apt-get -qq update &&
        $as_root env DEBIAN_FRONTEND=noninteractive apt-get -qq -y --no-install-recommends install $missing
} >"$log" 2>&1 </dev/null || {
    tail -n 20 "$log" >&2
    give_up "apt-get failed"
}
