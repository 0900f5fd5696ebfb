#!/bin/bash -eu
# Called by ClusterFuzzLite and OSS-Fuzz: builds libfvv and the targets that need nothing else into $OUT, each under its own
# name, with seeds. Sanitizers and engine come in CFLAGS and LIB_FUZZING_ENGINE. The targets of the other libraries (fvv_scene,
# fvv_media, fvv_mux) use C++ libraries of the system, which do not link with the image's libc++; ./run fuzz runs them.
cmake -S . -B "$WORK/build" -G Ninja -DCMAKE_BUILD_TYPE=None -DFVV_FUZZ=ON -DFVV_TOOLS=OFF -DFVV_MEDIA=OFF \
  -DFVV_FUZZ_ENGINE="$LIB_FUZZING_ENGINE" -DCMAKE_CXX_FLAGS="${CXXFLAGS/-stdlib=libc++/-stdlib=libstdc++}"
cmake --build "$WORK/build" --target fuzz_targets fuzz_seeds
python3 tests/fuzz/seeds.py "$WORK/seeds"
"$WORK/build/tests/fuzz/fuzz_seeds" "$WORK/seeds"
cd "$WORK/build/tests/fuzz"
# Links to one program: a copy for each, because the name says which target runs, and only $OUT goes on.
for link in $(find . -type l); do
  name=$(basename "$link")
  cp -L "$link" "$OUT/$name"
  [[ -d "$WORK/seeds/$name" ]] && (cd "$WORK/seeds/$name" && python3 -m zipfile -c "$OUT/${name}_seed_corpus.zip" ./*)
done
# Shared libraries that the image that runs them lacks.
mkdir -p "$OUT/lib"
for library in libdraco libmeshoptimizer; do cp -L "/usr/lib/$(uname -m)-linux-gnu/$library".so.* "$OUT/lib/"; done
for name in $(find . -type l -printf '%f\n'); do patchelf --set-rpath '$ORIGIN/lib' "$OUT/$name"; done
