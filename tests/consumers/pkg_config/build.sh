#!/bin/sh
# Builds and runs the consumer with what pkg-config says: build.sh FOLDER, with PKG_CONFIG_PATH set.
set -eu
cd "$1"
source="$(dirname "$0")/../main.c"
flags="-std=c99 -Wall -Wextra -pedantic -Werror $(pkg-config --cflags longspan)"
lib="$(pkg-config --variable=libdir longspan)"
cc $flags "$source" $(pkg-config --libs longspan) "-Wl,-rpath,$lib" -o shared
./shared
cc $flags "$source" $(pkg-config --libs longspan-static) -o static
if ldd static | grep longspan; then echo "longspan-static links the shared library"; exit 1; fi
./static
