#!/usr/bin/env bash
# Links the small programs of FFmpeg's configure: Emscripten's own linker takes half a second for each of a hundred. What
# JavaScript would have to provide is not found in this way, and not wanted.
# usage: FVV_CLANG=... FVV_SYSROOT=... linker.sh what a compiler is given to link
exec "$FVV_CLANG" -target wasm32-unknown-emscripten --sysroot="$FVV_SYSROOT" -nostdlib \
  -Wl,--no-entry,--export=main "$@" -L"$FVV_SYSROOT/lib/wasm32-emscripten" -lc -lemmalloc -lcompiler_rt -lc
