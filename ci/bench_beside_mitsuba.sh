#!/usr/bin/env bash
# path_trace beside Mitsuba 3's volpath: variance times time, all orders of scattering, in turns on one machine.
#
#   ci/bench_beside_mitsuba.sh PEERS CASES PYTHON [ROUNDS]
#
# PEERS holds mitsuba_ref.py, CASES the cases it renders (the same as tests/cases); PYTHON has numpy, OpenEXR and
# mitsuba, and finds LLVM. Neither side's start is counted: Mitsuba's kernels are compiled before, Tyndall's
# pipelines are not, but its stages are timed on the device. Prints the relative variance of a pixel (mean over
# the image, over the squared mean) times seconds, medians, and their ratio. Nothing here is a test.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
peers=${1:?folder of the peer scripts} cases=${2:?folder of the cases} python=${3:?python with mitsuba} rounds=${4:-3}
work=target/bench_beside_mitsuba
mkdir -p "$work"
cargo build --release --locked --quiet

tyndall() { # case, seed
    target/release/tyndall render "tests/cases/$1/scene.toml" --technique path_trace --spp 2048 --quiet \
        --set technique.path_trace.seed="$2" -o "$work/$1.exr" -o "$work/$1.json"
    "$python" - "$work/$1" <<'PY'
import json, sys, numpy, OpenEXR
with OpenEXR.File(sys.argv[1] + ".exr", separate_channels=True) as f:
    layers = {k.split(".")[-1] + ("v" if "variance" in k else ""): c.pixels
              for part in f.parts for k, c in
              (((part.header.get("name", "") + "." + k), c) for k, c in part.channels.items())}
variance = numpy.mean([layers[c + "v"] for c in "RGB"]) / numpy.mean([layers[c] for c in "RGB"]) ** 2
seconds = sum(s["seconds"] for s in json.load(open(sys.argv[1] + ".json"))["frame"]["stages"])
print(variance * seconds)
PY
}
mitsuba() { # case, round
    PYTHONPATH="$peers" "$python" - "$cases/$1/case.json" "$2" <<'PY' | tail -1
import sys, time, numpy
import mitsuba_ref as peer, mitsuba
case = peer.load_case(sys.argv[1])
scene = peer.build_scene(case, "full", boundary=case.get("render", {}).get("boundary", "null_cube"),
                         integrator="volpath")
numpy.asarray(mitsuba.render(scene, spp=256, seed=0))
start, passes = time.time(), 16
images = numpy.array([numpy.asarray(mitsuba.render(scene, spp=256, seed=1 + i + 1000 * int(sys.argv[2])))
                      for i in range(passes)], dtype=float)
seconds = time.time() - start
variance = images.var(0, ddof=1).mean() / passes / images.mean() ** 2
print(variance * seconds)
PY
}
for ((round = 1; round <= rounds; round++)); do
    for case in c01_homog_side c03_homog_bwd_front c04_gauss_point c06_thin c09_two_lights; do
        echo "$case $(mitsuba $case $round) $(tyndall $case $round)"
    done
done | tee "$work/rounds.txt" | "$python" -c "
import statistics, sys
rows = {}
for line in sys.stdin:
    case, a, b = line.split()
    rows.setdefault(case, []).append((float(a), float(b)))
for case, r in rows.items():
    a, b = (statistics.median(c) for c in zip(*r))
    print(f'{case}: Mitsuba {a:.2e} s, Tyndall {b:.2e} s: {a / b:.1f} times as fast at equal error')
"
