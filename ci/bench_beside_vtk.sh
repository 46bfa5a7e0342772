#!/usr/bin/env bash
# Tyndall beside VTK: same volume, transfer function, camera orbit and step, in turns on one machine.
#
#   ci/bench_beside_vtk.sh PEERS PYTHON [ROUNDS]
#
# PEERS holds make_synth.py, vtk_bench.py and tf_synth.json; PYTHON has numpy and vtk. Prints medians in
# seconds a frame and their ratio; "rebuilt" is a frame and the stage that fills the light cache. Figures
# of one run on one idle machine; nothing here is a test.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
peers=${1:?folder of the peer scripts} python=${2:?python with numpy and vtk} rounds=${3:-3}
work=target/bench_beside_vtk
mkdir -p "$work"
cargo build --release --locked --quiet

[[ -f $work/synth.npy ]] || "$python" "$peers/make_synth.py" 256 "$work/synth.npy" >/dev/null
"$python" -c "import numpy; numpy.load('$work/synth.npy').tofile('$work/synth.raw')"
cp "$peers/tf_synth.json" "$work/tf.json"
# VTK's default camera of vtk_bench.py: the longest side spans 85 % of the image's height.
read -r x y z < <("$python" -c "
import math
d = 255 / (2 * 0.85 * math.tan(math.radians(15)))
n = math.sqrt(0.35**2 + 0.45**2 + 1)
print(127.5 + 0.35 / n * d, 127.5 + 0.45 / n * d, 127.5 + d / n)")
cat >"$work/scene.toml" <<TOML
[volume]
file = "synth.raw"
raw = { dims = [256, 256, 256], type = "f32" }
[transfer_function]
file = "tf.json"
[[lights]]
directional = { direction = [-0.5, -1.0, -0.6], irradiance = 3.14159265 }
[camera]
eye = [$x, $y, $z]
target = [127.5, 127.5, 127.5]
up = [0.0, 1.0, 0.0]
[image]
width = 512
height = 512
[technique.ray_march]
step = 1.0
[technique.single_scatter]
step = 1.0
TOML

vtk() {
    "$python" "$peers/vtk_bench.py" --volume "$work/synth.npy" --tf "$work/tf.json" --size 512x512 \
        --step-voxels 1 --frames 8 --specular 0 "$@" 2>/dev/null |
        "$python" -c "import json, sys; print(json.load(sys.stdin)['frame_s']['median'])"
}
bench() {
    target/release/tyndall bench "$work/scene.toml" --quiet --json --frames 8 --repeat 1 "$@" |
        "$python" -c "
import json, sys
bench = json.load(sys.stdin)
frame = bench['orbit'][-1]['seconds']['median']
cache = sum(s['seconds'] for s in bench['first_frame']['stages'] if 'light_cache' in s['name'])
print(frame, frame + cache)"
}
tyndall() { bench --technique ray_march "$@" | cut -d ' ' -f 1; }
shading='technique.ray_march.shading={ambient=0.0,diffuse=0.9,specular=0.0}'
opaque='transfer_function.points=[[0.0,0.5,0.5,0.5,0.002],[1.0,1.0,1.0,1.0,0.002]]'
for ((round = 1; round <= rounds; round++)); do
    echo "cpu_ea $(vtk --mode cpu) ea $(tyndall --set technique.ray_march.shading=false)"
    echo "cpu_shaded $(vtk --mode cpu --cpu-shade) shaded $(tyndall --set "$shading")"
    read -r warm rebuilt < <(bench --technique single_scatter)
    shadow=$(vtk --mode shadow --blending 2 --frames 2)
    echo "shadow $shadow warm $warm"
    echo "shadow $shadow rebuilt $rebuilt"
    echo "gpu_ea $(vtk --mode ea) full $(tyndall --set technique.ray_march.shading=false --set "$opaque")"
done | tee "$work/rounds.txt" | "$python" -c "
import statistics, sys
rows = {}
for line in sys.stdin:
    a, x, b, y = line.split()
    rows.setdefault((a, b), []).append((float(x), float(y)))
name = {'cpu_ea': 'VTK CPU mapper, emission-absorption', 'cpu_shaded': 'VTK CPU mapper, gradient shading',
        'gpu_ea': 'VTK GPU mapper, emission-absorption',
        'shadow': 'VTK GPU mapper, a shadow ray a sample'}
for (a, b), r in rows.items():
    x, y = (statistics.median(c) for c in zip(*r))
    extra = f' = {50.1 / y:.0f} M samples/s (50.1 M a frame, nothing skipped)' if b == 'full' else f', ratio {y / x:.3f}'
    if a == 'shadow':
        b = f'single_scatter, {b} cache'
    print(f'{name[a]}: {x:.3f} s; tyndall {b}: {y:.3f} s{extra}')
"
