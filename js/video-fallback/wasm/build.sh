#!/usr/bin/env bash
# Builds libavcodec's decoders of H.264, HEVC and VP9 as a wasm module, from the source package of the installed
# libavcodec-dev, and writes this package's dist. usage: build.sh BUILD_DIRECTORY, the same as for js/decoder
set -euo pipefail
[[ $# -eq 1 ]] || { echo "usage: build.sh BUILD_DIRECTORY" >&2; exit 2; }
here=$(cd "$(dirname "$0")" && pwd)
decoder=$here/../../decoder/wasm
mkdir -p "$1/video"
build=$(cd "$1" && pwd)
"$decoder/fetch_sources.sh" "$build/sources" ffmpeg=libavcodec-dev
ffmpeg=$build/sources/ffmpeg
# Debian's emcc looks for the modules of its optimiser there.
export NODE_PATH=${NODE_PATH:-/usr/share/nodejs}

# Emscripten's clang without emcc, which takes longer to start than most of these files to compile.
find_tools() {
  read -r FVV_CLANG archiver symbols ranlib < <(PYTHONPATH=$(em-config EMSCRIPTEN_ROOT) python3 -c \
    'from tools import shared; print(shared.CLANG_CC, shared.LLVM_AR, shared.LLVM_NM, shared.LLVM_RANLIB)')
  FVV_SYSROOT=$(em-config CACHE)/sysroot
  export FVV_CLANG FVV_SYSROOT
}

# LGPL 2.1 or later: nothing here asks for the parts under the GPL. -O3, and SIMD by the compiler, make it nearly
# twice as large and a few percent faster.
configure() {
  find_tools
  "$ffmpeg/configure" --cc="$FVV_CLANG $(emcc --cflags)" --ld="$here/linker.sh" --ar="$archiver" \
    --ranlib="$ranlib" --nm="$symbols" --enable-cross-compile --target-os=none --arch=c \
    --disable-everything --disable-autodetect --disable-asm --disable-inline-asm --disable-runtime-cpudetect \
    --disable-pthreads --disable-network --disable-programs --disable-doc --disable-debug --disable-stripping \
    --disable-avdevice --disable-avformat --disable-avfilter --disable-swresample --disable-swscale \
    --disable-postproc --disable-faan --enable-decoder=h264,hevc,vp9 --optflags=-Os \
    --extra-cflags='-fvisibility=hidden -w'
}

link() {
  emcc -Os -fvisibility=hidden -Wall -Wextra -Werror -I. -I"$ffmpeg" "$here/decoder.c" \
    libavcodec/libavcodec.a libavutil/libavutil.a -o video.wasm --no-entry -sSTANDALONE_WASM=1 \
    -sIMPORTED_MEMORY=1 -sALLOW_MEMORY_GROWTH=1 -sMAXIMUM_MEMORY=2147483648 -sINITIAL_MEMORY=4194304 \
    -sTOTAL_STACK=1048576 -sFILESYSTEM=0 -sMALLOC=emmalloc -sERROR_ON_UNDEFINED_SYMBOLS=0 \
    -sWARN_ON_UNDEFINED_SYMBOLS=0 -Wl,--gc-sections
}

cd "$build/video"
# Of these sources and this script: make sees neither.
made_of=$(cat "$build/sources/ffmpeg.version" "$here/build.sh" "$here/linker.sh" | sha256sum)
if [[ ! -f configured || "$(<configured)" != "$made_of" ]]; then
  rm -rf "${build:?}/video/"{config.h,libavcodec,libavutil,video.wasm}
  configure >configure.log || { tail -n 20 configure.log >&2; exit 1; }
  echo "$made_of" >configured
fi
make -j2 --silent libavcodec/libavcodec.a libavutil/libavutil.a
dist=$here/../dist
mkdir -p "$dist"
if [[ ! (video.wasm -nt libavcodec/libavcodec.a && video.wasm -nt libavutil/libavutil.a &&
         video.wasm -nt "$here/decoder.c") ]]; then
  link
fi
[[ "$dist/video.wasm.js" -nt video.wasm ]] || node "$decoder/pack.mjs" video.wasm "$dist/video.wasm.js"
cp video.wasm "$here"/../src/* "$dist/"
cat >"$dist/SOURCE" <<END
video.wasm and video.wasm.js contain libavcodec and libavutil of FFmpeg, under the GNU Lesser General Public License,
version 2.1 or later (see LICENSE). Their source is Debian's source package $(<"$build/sources/ffmpeg.version"),
unchanged: "apt-get source $(<"$build/sources/ffmpeg.version")", or https://snapshot.debian.org/package/ffmpeg/.
wasm/build.sh configures, compiles and links it with wasm/decoder.c.
END
