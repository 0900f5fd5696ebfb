#!/usr/bin/env bash
# Builds the wasm modules and writes them as JavaScript modules into js/decoder/dist.
# usage: build.sh BUILD_DIRECTORY
set -euo pipefail
[[ $# -eq 1 ]] || { echo "usage: build.sh BUILD_DIRECTORY" >&2; exit 2; }
here=$(cd "$(dirname "$0")" && pwd)
mkdir -p "$1"
build=$(cd "$1" && pwd)
"$here/fetch_sources.sh" "$build/sources"
# Debian's emcc looks for the modules of its optimiser there.
export NODE_PATH=${NODE_PATH:-/usr/share/nodejs}
version=$(sed -n 's/^project(fvv VERSION \([0-9.]*\).*/\1/p' "$here/../../../CMakeLists.txt")
emcmake cmake -S "$here" -B "$build/modules" -G Ninja -DCMAKE_BUILD_TYPE=None \
  -DFVV_WASM_SOURCES="$build/sources" -DFVV_VERSION="$version" >/dev/null
cmake --build "$build/modules"
mkdir -p "$here/../dist"
for module in core draco; do
  node "$here/pack.mjs" "$build/modules/fvv_$module.wasm" "$here/../dist/$module.wasm.js"
done
cp "$here"/../src/*.js "$here"/../src/*.d.ts "$here/../dist/" 2>/dev/null || cp "$here"/../src/*.js "$here/../dist/"
