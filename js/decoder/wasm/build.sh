#!/usr/bin/env bash
# Builds the wasm modules and writes them as JavaScript modules into js/decoder/dist.
# usage: build.sh BUILD_DIRECTORY
set -euo pipefail
[[ $# -eq 1 ]] || { echo "usage: build.sh BUILD_DIRECTORY" >&2; exit 2; }
here=$(cd "$(dirname "$0")" && pwd)
mkdir -p "$1"
build=$(cd "$1" && pwd)
"$here/fetch_sources.sh" "$build/sources" draco=libdraco-dev meshoptimizer=libmeshoptimizer-dev
# Debian's emcc looks for the modules of its optimiser there.
export NODE_PATH=${NODE_PATH:-/usr/share/nodejs}
version=$(sed -n 's/^project(fvv VERSION \([0-9.]*\).*/\1/p' "$here/../../../CMakeLists.txt")
node "$here/generate_wasm_structs.mjs" --check
emcmake cmake -S "$here" -B "$build/modules" -G Ninja -DCMAKE_BUILD_TYPE=None \
  -DFVV_WASM_SOURCES="$build/sources" -DFVV_VERSION="$version" >/dev/null
cmake --build "$build/modules"

# What JavaScript calls, and nothing that only the linker's defaults export. What is left is optimised again, for
# size. Emscripten puts nothing into the first kibibyte of memory.
finish() { # module
  node -e '
    const { readFileSync, writeFileSync } = require("fs");
    const [input, graph] = process.argv.slice(1);
    const names = WebAssembly.Module.exports(new WebAssembly.Module(readFileSync(input))).map((e) => e.name);
    const wanted = names.filter((name) => /^(fvv|_initialize)/.test(name));
    writeFileSync(graph, JSON.stringify(wanted.map((name) => ({ name, root: true, export: name }))));
  ' "$build/modules/$1.wasm" "$build/$1.json"
  wasm-metadce "${features[@]}" -f "$build/$1.json" -o "$build/$1.wasm" "$build/modules/$1.wasm" >/dev/null
  # Flat code leaves the core's second pass more to find: 1 % of its bytes.
  local passes=(--one-caller-inline-max-function-size=100 -Oz --low-memory-unused)
  [[ "$1" == fvv_core ]] && passes+=(--flatten --rereloop -Oz -Oz -Oz)
  [[ "$1" == fvv_draco ]] || wasm-opt "${features[@]}" "${passes[@]}" "$build/$1.wasm" -o "$build/$1.wasm"
}

features=(--enable-exception-handling --enable-mutable-globals --enable-bulk-memory --enable-sign-ext
  --enable-nontrapping-float-to-int --enable-simd)
# Of the library that a module contains. Every page has the core, which has that of what all are linked with.
musl="$(dirname "$(readlink -f "$(command -v emcc)")")/system/lib/libc/musl/COPYRIGHT"
musl_licence() { # its first part: what follows are the names of authors
  sed '1,/^---/d;/^---/,$d' "$musl"
}
notice() { # module
  case "$1" in
    core)
      echo "This module contains parts of musl."
      echo
      musl_licence
      ;;
    draco)
      echo "This module contains Draco. Copyright 2016-2022 The Draco Authors."
      echo "Licensed under the Apache License, Version 2.0: https://www.apache.org/licenses/LICENSE-2.0"
      ;;
    fast | fast_simd)
      echo "This module contains meshoptimizer."
      echo
      cat "$build/sources/meshoptimizer/LICENSE.md"
      ;;
  esac
}

# Without files of earlier versions.
rm -rf "$here/../dist"
mkdir -p "$here/../dist"
for module in core projection environment draco fast fast_simd openexr; do
  finish "fvv_$module"
  node "$here/pack.mjs" "$build/fvv_$module.wasm" "$here/../dist/$module.wasm.js" "$(notice "$module")"
done
cp -r "$here"/../src/*.js "$here"/../src/*.d.ts "$here"/../src/media "$here"/../src/sources "$here/../dist/"
# What colours a place is one rule of players and decoder, whose package has no dependencies.
cp "$here/../../shading/src/camera_rule.js" "$here/../dist/"
cp "$here/../../../LICENSE" "$here/../dist/LICENSE"
cp "$build/sources/draco/LICENSE" "$here/../dist/LICENSE.draco"
cp "$musl" "$here/../dist/LICENSE.musl"
cp "$build/sources/meshoptimizer/LICENSE.md" "$here/../dist/LICENSE.meshoptimizer"
