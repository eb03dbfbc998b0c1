#!/bin/sh
# .ci/install.sh - installs the packages of .ci/packages.txt that are missing.
#
#   sh .ci/install.sh build [test]
#
# Says nothing and never calls apt-get when nothing is missing. On a system
# without dpkg it cannot tell; it then names the list once and goes on.
set -eu
list=$(dirname "$0")/packages.txt
log=$(mktemp)
trap 'rm -f "$log"' EXIT

wanted=$(for group in "$@"; do awk -v group="$group" '!/^#/ && $2 == group { print $1 }' "$list"; done)

if ! command -v dpkg-query >/dev/null 2>&1; then
    echo "digbox: no dpkg here; if the build misses something, install what matches $list" >&2
    exit 0
fi

# What an installed package provides counts as well: some builds of nodejs bring npm along.
present=$(dpkg-query -W -f '${db:Status-Status} ${Package} ${Provides}\n' 2>/dev/null | sed -n 's/^installed //p' |
    sed 's/([^)]*)//g' | tr ', ' '\n\n')
missing=
for package in $wanted; do
    echo "$present" | grep -qx "$package" || missing="$missing $package"
done
[ -n "$missing" ] || exit 0

fail() {
    echo "digbox: $1" >&2
    echo "digbox: these packages are missing; install them and try again:$missing" >&2
    exit 1
}

command -v apt-get >/dev/null 2>&1 || fail "there is no apt-get on this system"
root=
if [ "$(id -u)" != 0 ]; then
    command -v sudo >/dev/null 2>&1 || fail "apt-get needs root, and there is no sudo"
    root="sudo"
fi

apt() {
    $root env DEBIAN_FRONTEND=noninteractive apt-get -q -y -o DPkg::Lock::Timeout=300 "$@" >>"$log" 2>&1
}

echo "installing$missing"
apt update || echo "digbox: apt-get update had errors; trying with the lists that are here" >&2
# shellcheck disable=SC2086  # a list of names, none with spaces
if ! apt install --no-install-recommends $missing; then
    tail -n 15 "$log" >&2
    fail "apt-get install failed (its last lines are above)"
fi
