#!/usr/bin/env bash
# Builds, tests and measures the GPU backend on a machine with an NVIDIA GPU, in one call: bench/gpu.sh [OUT]
# Writes CSV files to OUT (default bench/results/gpu) and prints a table last. Needs CUDA 12.8 or later and the packages of
# tools/setup.sh; a machine that reaches no package registry may have them as .deb files in .gpu/debs (then run as root).
set -euo pipefail
cd "$(dirname "$0")/.."
out=${1:-bench/results/gpu}
mkdir -p "$out"
export PATH=$PATH:/usr/local/cuda/bin

if compgen -G '.gpu/debs/*.deb' >/dev/null; then
    for package in .gpu/debs/*.deb; do dpkg -x "$package" /; done
    ldconfig
fi

build=${PIERCE_BUILD:-build/gpu}
cmake -S . -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DPIERCE_CUDA=ON -DCMAKE_CUDA_ARCHITECTURES=native >"$out/log.txt" 2>&1
cmake --build "$build" --target conformance_tests pierce_app pierce_gpu_steps pierce_gpu_trees pierce_gpu_sheets >>"$out/log.txt"
echo "built in $SECONDS s"

{
    nvidia-smi --query-gpu=name,driver_version,memory.total --format=csv,noheader
    nvcc --version | tail -2 | head -1
    echo "$(nproc) CPU cores"
    git rev-parse --short HEAD 2>/dev/null || true
} >"$out/machine.txt"

# Every backend's contact lists against the reference, bit for bit.
ctest --test-dir "$build" --tests-regex '^conformance\.' --parallel "$(nproc)" --output-on-failure >>"$out/log.txt" 2>&1 ||
    { tail -40 "$out/log.txt"; exit 1; }
echo "$(grep 'tests passed' "$out/log.txt"), $SECONDS s"

# The paper's scene: 100 soft tori fall on each other; the frames of the pile are then replayed on the GPU.
"$build"/src/app/pierce run tori --count 100 --soft --seconds 5 --record "$out/../soft_tori" >>"$out/log.txt"
steps=$build/bench/pierce_gpu_steps
"$steps" "$out/../soft_tori" lattice:100 lattice:1000 lattice:10000 --steps 300 --check 8 >"$out/steps.csv"
"$steps" "$out/../soft_tori" lattice:100 lattice:1000 lattice:10000 --steps 40 --check 0 --stages >"$out/stages.csv"
for builder in lbvh hlbvh ploc; do
    "$steps" lattice:100 lattice:1000 lattice:10000 --steps 100 --check 0 --builder "$builder" | tail -n +2 >>"$out/steps.csv"
done
"$build"/bench/pierce_gpu_trees 100 1000 10000 rest:10000 mesh:7 mesh:8 >"$out/trees.csv"
"$build"/bench/pierce_gpu_sheets --steps 60 --check 2 >"$out/sheets.csv"
"$build"/bench/pierce_gpu_sheets --steps 20 --check 0 --stages | tail -n +2 >>"$out/sheets.csv"
rm -r "$out/../soft_tori"
# Table 1, tables 2 and 3, and the crossover, as `pierce report paper --gpu-results DIR` merges them.
"$build"/src/app/pierce report paper --parts trees,gpu,crossover --seconds 10 --soft-seconds 4 --out "$out/paper" >>"$out/log.txt"

if command -v compute-sanitizer >/dev/null; then
    compute-sanitizer --tool racecheck "$steps" lattice:27 --steps 12 --check 2 2>&1 | grep hazards >"$out/racecheck.txt" ||
        echo "racecheck could not run" >"$out/racecheck.txt"
    # Lists of sheets outgrow their room in these tests.
    {
        compute-sanitizer --tool memcheck "$steps" lattice:27 --steps 12 --check 2
        compute-sanitizer --tool memcheck "$build"/tests/conformance_tests --gtest_filter='*/SheetsTest*/cuda'
    } 2>&1 | grep "ERROR SUMMARY" >"$out/memcheck.txt" || echo "memcheck could not run" >"$out/memcheck.txt"
fi

echo "done in $SECONDS s"
cat "$out/machine.txt"
cut -d, -f1-4,6-14 "$out/steps.csv"
cut -d, -f1-5,7-8,11,13-14 "$out/trees.csv"
cat "$out/sheets.csv"
cat "$out"/{memcheck,racecheck}.txt 2>/dev/null || true

# The figures that matter, beside the time in which the bytes that a result cannot do without would be copied: positions read;
# nodes of trees, contacts and hits written; and whether contact lists are those of Embree, bit for bit.
awk -F, '
    function row(what, time, floor, rate) { printf "%-42s %9.4f ms %9.4f ms %25s\n", what, time, floor, rate }
    function error(differ, checked) { return differ " of " checked " lists differ" }
    BEGIN { printf "%-42s %12s %12s %25s\n", "what", "time", "floor", "rate, or error" }
    /a copy moves/ { split($0, word, " "); bandwidth = 1e9 * word[5] }
    FNR == 1 { file++ }
    file == 1 && $1 == "tori:10000" {
        row($3 " build, 6 M triangles", $4, $6, sprintf("%.2f Gtri/s", $5 / 1000))
        if ($3 == "trbvh") {
            row("refit of those", $7, $6, sprintf("%.1f Gtri/s", $8 / 1000))
            row("inward rays of 3 M vertices, through those", $10, $12, sprintf("%.2f Gray/s", $11))
        }
    }
    file == 2 && FNR > 1 && $4 == "trbvh" { row($1 ", whole step", $10, (38 * $3 + 208 * $8) / bandwidth, error($14, $13)) }
    file == 3 && $3 == "graph" { row($1 " sheets, " $2 " triangles, whole step", $8, (12 * $2 + 208 * $6) / bandwidth, error($12, $11)) }
' "$out/trees.csv" "$out/steps.csv" "$out/sheets.csv"
