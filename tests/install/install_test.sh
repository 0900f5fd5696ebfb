#!/bin/sh
# install_test.sh BUILD FILE: installs BUILD into a prefix inside it, moves the prefix, and builds and runs the consumers
# with FILE by each way that a user has. ctest sets CMAKE, GENERATOR, CC, CXX, PKG_CONFIG, LIBDIR and VERSION.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
work=$1/install_test
file=$2
rm -rf "$work"
mkdir -p "$work"
"$CMAKE" --install "$1" --prefix "$work/first" > "$work/install.log"
# A package that was moved shows whether something still names the place of its installation.
prefix=$work/prefix
mv "$work/first" "$prefix"
# -lfvv takes the shared library where there is one: static users by pkg-config get a prefix without it.
alone=$work/static
cp -R "$prefix" "$alone"
rm -f "$alone/$LIBDIR"/libfvv.so*
warnings="-Wall -Wextra -pedantic -Werror"
failed=0

by_number="fvv $VERSION: 1 frames, 4 vertices"
by_push="time 0, track 1: 4 vertices, 4 faces"

# expect WAY PROGRAM OUTPUT [FOLDER OF SHARED LIBRARIES]
expect() {
  found=$(LD_LIBRARY_PATH=${4:-} "$2" "$file" 2>&1) || found="exit code $?: $found"
  if [ "$found" = "$3" ]; then
    echo "$1: ok"
  else
    echo "$1: expected $3; found $found"
    failed=1
  fi
}

# by_cmake KIND
by_cmake() {
  "$CMAKE" -S "$here/consumer" -B "$work/cmake_$1" -G "$GENERATOR" -DCMAKE_C_COMPILER="$CC" \
    -DCMAKE_CXX_COMPILER="$CXX" -DCMAKE_PREFIX_PATH="$prefix" -DFVV_KIND="${1#default}" > "$work/cmake_$1.log"
  "$CMAKE" --build "$work/cmake_$1" >> "$work/cmake_$1.log" || { cat "$work/cmake_$1.log"; exit 1; }
  expect "CMake package, $1" "$work/cmake_$1/consumer" "$by_number"
  expect "CMake package, $1, frames" "$work/cmake_$1/consumer_frames" "$by_push"
}
by_cmake default
by_cmake shared
by_cmake static

# by_pkg_config PREFIX SOURCE OUTPUT [--static]
by_pkg_config() {
  flags=$(PKG_CONFIG_PATH="$1/$LIBDIR/pkgconfig" "$PKG_CONFIG" ${4:-} --cflags --libs fvv)
  # $flags and $warnings are lists.
  "$CC" -std=c99 $warnings "$here/$2.c" -o "$work/$3" $flags
}
by_pkg_config "$prefix" consumer pc_shared
expect "pkg-config, shared" "$work/pc_shared" "$by_number" "$prefix/$LIBDIR"
by_pkg_config "$alone" consumer pc_static --static
expect "pkg-config --static" "$work/pc_static" "$by_number"
by_pkg_config "$prefix" consumer_frames pc_frames
expect "pkg-config, shared, frames" "$work/pc_frames" "$by_push" "$prefix/$LIBDIR"

# encodes WAY OUTPUT PROGRAM...: writes a stream from arrays, which fvvinfo has to call whole. All have the same bytes.
encodes() {
  way=$1
  output=$2
  shift 2
  "$@" "$work/encoded.fvv" > "$work/encoded.txt" 2>&1 || true
  [ -e "$work/first.fvv" ] || cp "$work/encoded.fvv" "$work/first.fvv"
  if [ "$(cat "$work/encoded.txt")" = "$output" ] && "$prefix/bin/fvvinfo" --check "$work/encoded.fvv" > "$work/info.txt" 2>&1 &&
    cmp "$work/first.fvv" "$work/encoded.fvv" >> "$work/info.txt" 2>&1; then
    echo "$way: ok"
  else
    echo "$way: expected $output and a whole stream, the same in all ways; found"
    cat "$work/encoded.txt" "$work/info.txt"
    failed=1
  fi
  rm -f "$work/encoded.fvv"
}
encodes "CMake package, component mux" "10 frames" "$work/cmake_default/consumer_encode"
flags=$(PKG_CONFIG_PATH="$prefix/$LIBDIR/pkgconfig" "$PKG_CONFIG" --cflags --libs fvv_mux)
"$CXX" -std=c++17 -Wall -Wextra "$here/consumer_encode.cpp" -o "$work/pc_encode" $flags
LD_LIBRARY_PATH=$prefix/$LIBDIR encodes "pkg-config fvv_mux" "10 frames" "$work/pc_encode"
encodes "CMake package, component encoder, C" "10 frames, 50 vertices" "$work/cmake_default/consumer_encoder"
flags=$(PKG_CONFIG_PATH="$prefix/$LIBDIR/pkgconfig" "$PKG_CONFIG" --cflags --libs fvv_encoder)
"$CC" -std=c99 $warnings -Wno-missing-field-initializers "$here/consumer_encoder.c" -o "$work/pc_encoder" $flags -lm
LD_LIBRARY_PATH=$prefix/$LIBDIR encodes "pkg-config fvv_encoder, C" "10 frames, 50 vertices" "$work/pc_encoder"
encodes "libfvv_encoder by ctypes" "10 frames" python3 "$here/encoder_ctypes.py" "$prefix/$LIBDIR/libfvv_encoder.so"

# The program of the documentation.
sed -n '/^```c$/,/^```$/p' "$here/../../docs/guide/encoder-in-c.md" | grep -v '^```' > "$work/clip.c"
flags=$(PKG_CONFIG_PATH="$prefix/$LIBDIR/pkgconfig" "$PKG_CONFIG" --cflags --libs fvv_encoder)
"$CC" -std=c99 $warnings "$work/clip.c" -o "$work/clip" $flags -lm
found=$(cd "$work" && LD_LIBRARY_PATH=$prefix/$LIBDIR ./clip && "$prefix/bin/fvvinfo" --check clip.fvv 2>&1) || found="failed: $found"
case $found in
  "50 frames, "*) echo "docs/guide/encoder-in-c.md: ok" ;;
  *) echo "docs/guide/encoder-in-c.md: expected 50 frames, found $found" && failed=1 ;;
esac

expect "CMake package, components view and compare" "$work/cmake_default/consumer_view" "a mesh, equal"
flags=$(PKG_CONFIG_PATH="$prefix/$LIBDIR/pkgconfig" "$PKG_CONFIG" --cflags --libs fvv_view fvv_compare)
"$CXX" -std=c++17 -Wall -Wextra "$here/consumer_view.cpp" -o "$work/pc_view" $flags
expect "pkg-config fvv_view fvv_compare" "$work/pc_view" "a mesh, equal" "$prefix/$LIBDIR"

for header in "$prefix"/include/fvv/*.h; do
  name=fvv/$(basename "$header")
  echo "#include <$name>" > "$work/alone.c"
  "$CC" -std=c99 $warnings -I"$prefix/include" -fsyntax-only "$work/alone.c"
  "$CXX" -x c++ -std=c++11 $warnings -I"$prefix/include" -fsyntax-only "$work/alone.c"
  echo "$name alone, C99 and C++11: ok"
done

count=0
for header in $(cd "$prefix/include" && ls -d fvv_*/*.h); do
  count=$((count + 1))
  echo "#include <$header>" > "$work/alone.cpp"
  "$CXX" -std=c++17 $warnings -I"$prefix/include" -fsyntax-only "$work/alone.cpp"
  # Of other projects the standard library's alone.
  if grep '#include' "$prefix/include/$header" | grep -v -e '<[a-z_]*>' -e '"fvv'; then
    echo "$header: expected headers of fvv and of the standard library, found that"
    failed=1
  fi
  echo "$header alone, C++17: ok"
done
if [ $count -gt 8 ] || [ $count -lt 1 ]; then
  echo "C++ headers: expected at most 8, found $count"
  failed=1
fi

found=$("$prefix/bin/fvvinfo" --version)
if [ "$found" = "fvvinfo $VERSION" ]; then
  echo "bin/fvvinfo: ok"
else
  echo "bin/fvvinfo: expected fvvinfo $VERSION, found $found"
  failed=1
fi
exit $failed
