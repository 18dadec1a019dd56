#!/usr/bin/env bash
# Installs what building longspan and its C samples takes besides Rust, on Debian and Ubuntu: a C and a C++ compiler.
# With --ci also what the full set of checks uses: valgrind, pkg-config, cmake and make; with --hosts what the hosts with a window
# do: SDL 2, OpenGL, Irrlicht and a virtual display; with --viewer what the viewer's window and its check do: OpenGL in software, a
# virtual display, and xdotool, which presses keys on it.
set -euo pipefail

packages=(gcc g++ libc6-dev)
case "${1:-}" in
    "") ;;
    --ci) packages+=(clang valgrind pkg-config cmake make) ;;
    --hosts) packages+=(libsdl2-dev libgl1-mesa-dev libgl1-mesa-dri libirrlicht-dev xvfb xauth) ;;
    --viewer) packages+=(libgl1-mesa-dri libgl1 libx11-6 libxi6 libxkbcommon0 xvfb xauth xdotool iproute2) ;;
    *) echo "usage: setup/install.sh [--ci | --hosts | --viewer]" >&2; exit 2 ;;
esac

if ! command -v apt-get >/dev/null; then
    echo "setup/install.sh knows apt-get only; install by hand: ${packages[*]}" >&2
    exit 1
fi

missing=()
for package in "${packages[@]}"; do
    dpkg-query --show --showformat='${db:Status-Status}' "$package" 2>/dev/null | grep -qx installed || missing+=("$package")
done
if [ ${#missing[@]} -eq 0 ]; then
    echo "installed already: ${packages[*]}"
    exit 0
fi

as_root=()
if [ "$(id -u)" -ne 0 ]; then
    as_root=(sudo)
fi
echo "installing with apt-get: ${missing[*]}"
"${as_root[@]}" apt-get update -qq
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install --yes --no-install-recommends "${missing[@]}"
