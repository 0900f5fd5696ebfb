#!/bin/sh
# windows_test.sh PREFIX SOURCE: compiles each public C header of PREFIX (an include folder) and the C sources of libfvv for
# Windows: with MinGW-w64 and with clang, whichever are here. Exit code 77: neither is.
set -eu
include=$1
source=$2
warnings="-Wall -Wextra -Wpedantic -Werror"
tried=0
failed=0

# compiles WHAT COMMAND...: prints WHAT with ok, or what the compiler said.
compiles() {
  what=$1
  shift
  if found=$("$@" 2>&1); then return 0; fi
  echo "$what: does not compile: $found"
  failed=1
}

# headers NAME COMPILER...: once for each way to link, in C and in C++.
headers() {
  name=$1
  shift
  tried=1
  for header in "$include"/fvv/*.h; do
    for way in -DFVV_STATIC -DFVV_BUILDING_DLL -DFVV_IMPORTED; do
      # $warnings is a list.
      compiles "$name, C, $header, $way" "$@" -x c -std=c99 $warnings $way -I "$include" -fsyntax-only "$header"
      compiles "$name, C++, $header, $way" "$@" -x c++ -std=c++17 -Wall -Werror $way -I "$include" -fsyntax-only "$header"
    done
  done
  echo "$name: public headers: $([ $failed -eq 0 ] && echo ok || echo failed)"
}

if command -v clang >/dev/null; then clang=clang; else clang=clang-14; fi
if command -v "$clang" >/dev/null; then
  # Without a C library for Windows: the headers need those of the compiler alone.
  headers "clang for Windows" "$clang" --target=x86_64-w64-windows-gnu -ffreestanding
else
  echo "clang for Windows: skipped: there is no clang"
fi

mingw=x86_64-w64-mingw32-gcc
if command -v $mingw >/dev/null; then
  headers "MinGW-w64" $mingw
  for file in "$source"/src/*/*.c; do
    compiles "MinGW-w64, $file" $mingw -std=c11 $warnings -DFVV_BUILDING_DLL -D__USE_MINGW_ANSI_STDIO=1 -DFVV_LIBRARY_VERSION='"0"' \
      -I "$include" -I "$source/src" -fsyntax-only "$file"
  done
  echo "MinGW-w64: C sources: $([ $failed -eq 0 ] && echo ok || echo failed)"
else
  echo "MinGW-w64: skipped: there is no $mingw (Debian: gcc-mingw-w64-x86-64)"
fi

[ $tried -eq 1 ] || exit 77
exit $failed
