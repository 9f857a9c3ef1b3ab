#!/usr/bin/env bash
# Installs burin into a folder and, against that alone, builds and runs the example of docs/extending.md and
# imports the Python package: install_test.sh BUILD_DIR SOURCE_DIR.
set -euo pipefail
build="$1"
source="$2"
work="$(mktemp -d)"
trap 'rm -rf -- "$work"' EXIT
cmake --install "$build" --prefix "$work/prefix" >/dev/null
for file in bin/burin share/man/man1/burin.1 include/burin/apps/run/pipeline.h; do
  [[ -s "$work/prefix/$file" ]] || { echo "$file was not installed"; exit 1; }
done
# Pages without faults, and every command on it.
if command -v groff >/dev/null; then
  groff -man -Tutf8 -ww "$work/prefix/share/man/man1/burin.1" >"$work/page" 2>"$work/faults"
  [[ ! -s "$work/faults" ]] || { cat "$work/faults"; exit 1; }
fi
for command in refine select convert evaluate synth; do
  grep -q "^\.B $command$" "$work/prefix/share/man/man1/burin.1" || { echo "no $command"; exit 1; }
done
cp -r "$source/docs/examples/extension" "$work/extension"
# With the flags of the build: what has a sanitizer is linked with one.
flags="$(sed -n 's/^CMAKE_CXX_FLAGS:[A-Z]*=//p' "$build/CMakeCache.txt")"
cmake -S "$work/extension" -B "$work/build" -G Ninja -DCMAKE_BUILD_TYPE=Release \
  -DCMAKE_CXX_FLAGS="$flags" -DCMAKE_PREFIX_PATH="$work/prefix" >"$work/configured" 2>&1 || { cat "$work/configured"; exit 1; }
cmake --build "$work/build" >"$work/built" 2>&1 || { cat "$work/built"; exit 1; }
"$work/prefix/bin/burin" synth --output "$work/scene" --synth.width 160 --synth.height 120 \
  --synth.views 4 --synth.truth_point_count 1000 >/dev/null
"$work/build/extension" "$work/scene" "$work/scene/init.ply" "$work/refined.ply" | tee "$work/said"
grep -q "^level 1: diagonal, energy [0-9.e+]* (plane [0-9.e+-]*)$" "$work/said"
error() {  # error MESH: its RMSE to the truth
  "$work/prefix/bin/burin" evaluate --mesh "$1" --truth "$work/scene/truth.ply" --json |
    sed -n 's/.*"rmse": *\([0-9.e-]*\).*/\1/p' | head -n 1
}
python="$work/prefix/lib/python3/dist-packages"
if [[ -d "$python" ]]; then
  PYTHONPATH="$python" /usr/bin/python3 -c 'import burin; assert "lm_pcg" in burin.strategies()'
fi
before="$(error "$work/scene/init.ply")"
after="$(error "$work/refined.ply")"
echo "RMSE to truth: $before before, $after after"
awk -v before="$before" -v after="$after" 'BEGIN { exit !(after < before) }'
