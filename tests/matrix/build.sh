#!/usr/bin/env bash
# Builds libfvv and its conformance adapter for one machine, compiler and level of optimisation, all in BUILD/NAME; the
# adapter is BUILD/NAME/adapter. usage: build.sh BUILD NAME C_COMPILER CXX_COMPILER PROCESSOR FLAGS
# PROCESSOR: native (with the Draco and meshoptimizer that are installed), or another one: with both from the sources of
# Debian's packages, and linked statically.
set -euo pipefail
[[ $# -eq 6 ]] || { echo "usage: build.sh BUILD NAME C_COMPILER CXX_COMPILER PROCESSOR FLAGS" >&2; exit 2; }
root=$(cd "$(dirname "$0")/../.." && pwd)
mkdir -p "$1/$2"
all=$(cd "$1" && pwd)
name=$2 cc=$3 cxx=$4 processor=$5 flags=$6
build=$all/$name
# The programs that are tried while CMake configures must not be run.
common=(-G Ninja -DCMAKE_BUILD_TYPE=None -DCMAKE_C_COMPILER="$cc" -DCMAKE_CXX_COMPILER="$cxx" -DCMAKE_C_FLAGS="$flags"
  -DCMAKE_CXX_FLAGS="$flags")
link=()

# Once for all levels of optimisation of libfvv.
dependencies() {
  local prefix=$all/$processor
  local others=(-G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_C_COMPILER="$cc" -DCMAKE_CXX_COMPILER="$cxx"
    -DCMAKE_SYSTEM_NAME=Linux -DCMAKE_SYSTEM_PROCESSOR="$processor")
  "$root/js/decoder/wasm/fetch_sources.sh" "$all/sources" draco=libdraco-dev meshoptimizer=libmeshoptimizer-dev
  cmake -S "$all/sources/meshoptimizer" -B "$prefix/build" "${others[@]}" -DCMAKE_INSTALL_PREFIX="$prefix" \
    -DCMAKE_INSTALL_LIBDIR=lib
  cmake --build "$prefix/build" --target install
  grep -q ToHostOrder "$all/sources/draco/src/draco/core/decoder_buffer.h" ||
    patch -s -p1 -d "$all/sources/draco" -i "$root/tests/matrix/draco_big_endian.patch"
  cmake -S "$all/sources/draco" -B "$prefix/draco" "${others[@]}" -DDRACO_TESTS=OFF
  cmake --build "$prefix/draco" --target draco_static
  mkdir -p "$prefix/lib/pkgconfig"
  cat >"$prefix/lib/pkgconfig/draco.pc" <<PC
Name: draco
Description: Draco from the sources of Debian's package
Version: 1
Cflags: -I$all/sources/draco/src -I$prefix/draco
Libs: -L$prefix/draco -ldraco
PC
}

if [[ "$processor" == native ]]; then
  link=(-lcrypto)
  plain=()
else
  dependencies
  common+=(-DCMAKE_SYSTEM_NAME=Linux -DCMAKE_SYSTEM_PROCESSOR="$processor" -Dmeshoptimizer_DIR="$all/$processor/lib/cmake/meshoptimizer")
  export PKG_CONFIG_LIBDIR=$all/$processor/lib/pkgconfig PKG_CONFIG_SYSROOT_DIR=
  # No OpenSSL of that machine is needed for a hash.
  plain=(-I"$root/tests/matrix/plain" "$root/tests/matrix/plain/sha256.cpp")
  link=(-L"$all/$processor/draco" -static)
fi
link+=(-ldraco -lmeshoptimizer -lm)
[[ "$processor" == native ]] || link+=(-L"$all/$processor/lib")
cmake -S "$root" -B "$build" "${common[@]}" -DFVV_MEDIA=OFF -DFVV_TOOLS=OFF -DFVV_TESTS=OFF
cmake --build "$build" --target fvv_static
# Headers without code of a machine; the folder that they are in has others.
mkdir -p "$all/include"
ln -sfn "$(dirname "$(echo '#include <nlohmann/json.hpp>' | g++ -E -x c++ -M - | grep -o '/[^ ]*nlohmann/json.hpp')")" "$all/include/nlohmann"
read -ra words <<<"$flags"
# As CMakeLists.txt has it for libfvv.
[[ "$processor" != i686 ]] || words+=(-msse2 -mfpmath=sse)
"$cxx" -std=c++17 "${words[@]}" -ffp-contract=off -I"$root/libfvv/include" -isystem "$all/include" \
  "$root"/conformance/adapters/libfvv/*.cpp "${plain[@]}" -o "$build/adapter" "$build/libfvv/libfvv.a" "${link[@]}"
