#!/usr/bin/env bash
# Renders the pictures of src/technique/half_angle/README.md: half_angle.png, half_angle_clouds.png,
# half_angle_height_fields.png and half_angle_materials.png.
#
#   ci/half_angle_pictures.sh HEAD PYTHON [FOLDER]
#
# HEAD is a CT of a head in Hounsfield units, z up, its face towards +y; PYTHON has Pillow and joins the pictures.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
head=$(realpath "${1:?CT of a head}") python=${2:?python with Pillow} out=$(realpath "${3:-docs/images}")
cargo build --release --locked --quiet
tyndall=$(realpath "${CARGO_TARGET_DIR:-target}/release/tyndall")
work=$(mktemp -d)
trap 'rm -r "$work"' EXIT

# A block [Kniss2003, Fig. 9]: any formula will do, as all its values are the same medium.
cat >"$work/wax.toml" <<'TOML'
[volume.procedural]
name = "marschner_lobb"
resolution = 64
[transfer_function]
color_space = "linear"
extinction = [[0, 1, 1, 1, 6], [1, 1, 1, 1, 6]]
[medium]
albedo = 1
[[lights]]
point = { position = [0, 0, 1.9], intensity = 8 }
[camera]
azimuth_deg = 25
elevation_deg = 20
[technique]
name = "half_angle"
[technique.half_angle]
transport_color = [0.92, 0.78, 0.50]
TOML
sed 's/1, 1, 1, 6\]/0.25, 0.45, 1, 6]/g' "$work/wax.toml" >"$work/blue.toml"

# Skin [Fig. 17], light over the viewer's left shoulder.
cat >"$work/skin.toml" <<TOML
[volume]
file = "$head"
[transfer_function]
opacity_unit_distance = 1
points = [[-600, 0.95, 0.75, 0.62, 0], [-300, 0.95, 0.75, 0.62, 0.10], [60, 0.95, 0.72, 0.60, 0.16],
    [160, 0.95, 0.72, 0.60, 0.16], [300, 0.98, 0.95, 0.88, 0.5], [1500, 1, 0.98, 0.94, 0.9]]
[medium]
albedo = 0.98
[[lights]]
directional = { direction = [-0.47, -0.88, -0.8], irradiance = 3.14 }
[camera]
azimuth_deg = 205
elevation_deg = 10
zoom = 1.1
[technique]
name = "half_angle"
TOML
# Flesh [Fig. 16]: thinner, lit from the left and behind.
sed -e 's/0.10\]/0.03]/; s/0.16\]/0.05]/g; s/direction = \[[^]]*\]/direction = [-1.0, 0.1, -0.5]/' \
    "$work/skin.toml" >"$work/flesh.toml"

# Clouds [Fig. 10], lit from the side or from behind.
clouds=assets/scenes/cumulus.toml
sed -e 's/^eye = .*/eye = [0.5, -3.3, 0.25]/; s/^target = .*/target = [0, 0, 0.05]/' \
    -e 's/^background = .*/background = [0.02, 0.05, 0.12]/' "$clouds" >"$work/detailed.toml"
cat >>"$work/detailed.toml" <<'TOML'
[technique]
name = "half_angle"
[technique.half_angle]
light_buffer = 256
TOML
sed '/^\[medium.perturbation\]/,/^]/d' "$work/detailed.toml" >"$work/coarse.toml"
behind='s/^directional = .*/directional = { direction = [0.15, -1.0, -0.1], irradiance = 3 }/'
# Slow noise on the albedo of each colour, which is what dims scattered light.
slow='    { frequency = 4, displacement = 0, color = [0.2, 0.2, 0.2] },'
sed -e "$behind" -e "/frequency = 61/i\\$slow" -e 's/^albedo = /density_scale = 0.3\n&/' \
    "$work/detailed.toml" >"$work/noise.toml"
sed -e "$behind" -e 's/^albedo = /density_scale = 0.15\n&/' "$work/detailed.toml" >"$work/corona.toml"
# Droplets of a radius of 2 micrometres at wavelengths of 0.65, 0.55 and 0.45: half Airy's disc and rings, half what
# Henyey-Greenstein's function gives at 0.6.
"$python" - >>"$work/corona.toml" <<'PY'
from math import acos, cos, pi, sin
def j1(x):
    return sum(cos(t - x * sin(t)) for t in (pi * (i + 0.5) / 200 for i in range(200))) / 200
def airy(theta, per_wave):
    x = 2 * pi * per_wave * sin(theta)
    return pi * per_wave**2 * (1 if x < 1e-6 else 2 * j1(x) / x) ** 2 if theta < pi / 2 else 0
rows = []
for i in range(512):
    c = -1 + 2 * i / 511
    even = (1 - 0.36) / (4 * pi * (1.36 - 1.2 * c) ** 1.5)
    rgb = [0.5 * (airy(acos(max(-1, min(1, c))), 2 / wave) + even) for wave in (0.65, 0.55, 0.45)]
    rows.append("[%.4g, %.4g, %.4g]" % tuple(rgb))
print("phase_table = [" + ", ".join(rows) + "]")
PY

# Materials [Fig. 18].
cat >"$work/part.toml" <<'TOML'
[volume.procedural]
name = "mechanical_part"
resolution = 128
[transfer_function]
color_space = "linear"
extinction = [[0.1, 1, 1, 1, 0], [0.3, 1, 1, 1, 40], [1, 1, 1, 1, 40]]
[medium]
albedo = 1
[[lights]]
directional = { direction = [-0.9, 0.1, -0.5], irradiance = 4 }
[camera]
azimuth_deg = 30
elevation_deg = 32
zoom = 1.2
[technique]
name = "half_angle"
[technique.half_angle]
light_buffer = 320
slice_spacing = 0.5
TOML
part() { # NAME COLOUR
    sed "s/, 1, 1, 1, /, $2, /g" "$work/part.toml" >"$work/$1.toml"
}
part white "1, 1, 1"
part yellow "0.9, 0.75, 0.45"
part cyan "0.5, 0.8, 0.9"
part red "0.85, 0.45, 0.4"

sheet() { # NAME SIZE: the pictures from here on join it
    name=$1 size=$2 n=0
    mkdir "$work/$name"
}
picture() { # SCENE EXPOSURE [KEY=VALUE ...]: a key without a dot is the technique's
    local scene=$1 exposure=$2 set=(--set image.samples_per_axis=2)
    shift 2
    for key in "$@"; do
        [[ ${key%%=*} == *.* ]] || key=technique.half_angle.$key
        set+=(--set "$key")
    done
    "$tyndall" -q render "$work/$scene.toml" --size "$size" --exposure "$exposure" "${set[@]}" \
        -o "$work/$name/$(printf %02d $n).png"
    n=$((n + 1))
}
sheet half_angle 184x184
picture wax 1
picture blue 1
picture wax 1 lighting=direct
picture wax 1 'transport_color=[0.78,0.78,0.78]'
picture skin 0 lighting=none
picture skin 0 lighting=surface
picture skin 2 lighting=direct
picture skin 2
picture flesh 2 lighting=direct
picture flesh 2 'transport_color=[0.8,0.8,0.8]'
picture flesh 2 'transport_color=[0.93,0.82,0.74]'
picture flesh 2 'transport_color=[0.93,0.82,0.74]' surface=gradient surface_gradient=0.2

sheet half_angle_clouds 240x180
picture coarse 2
picture detailed 2
picture noise 1.2
"$tyndall" -q render "$work/corona.toml" --size "$size" --tone-map reinhard --exposure 0 \
    --set image.samples_per_axis=2 -o "$work/$name/03.png"

# Height fields [Fig. 13].
cp assets/scenes/{terrain,cumulus_field}.toml "$work"
sheet half_angle_height_fields 320x214
picture terrain 0.7 technique.name=half_angle 'image.background=[0.25,0.35,0.5]'
picture cumulus_field 1 technique.name=half_angle 'image.background=[0.05,0.1,0.2]'

sheet half_angle_materials 120x120
for color in 0.85,0.85,0.85 0.92,0.75,0.65 0.65,0.9,0.7 0.65,0.78,0.94; do
    picture white 0.5 "transport_color=[$color]"
done
for angle in 0 60 120 165; do
    picture yellow 1 'transport_color=[0.8,0.8,0.8]' blur_angle_deg=$angle
done
for g in -0.5 0 0.4 0.8; do
    picture cyan 1 medium.phase.g=$g
done
picture red 1 lighting=direct
picture red 0 lighting=direct surface=gradient surface_gradient=0.05
picture red 0 surface=gradient surface_gradient=0.4
picture red 0 surface=gradient surface_gradient=0.05 specular=0.6

"$python" - "$work" "$out" <<'PY'
import glob, sys
from PIL import Image
work, out = sys.argv[1:]
for name, columns in [("half_angle", 4), ("half_angle_clouds", 2), ("half_angle_height_fields", 2),
                      ("half_angle_materials", 4)]:
    tiles = [Image.open(f).convert("RGB") for f in sorted(glob.glob(f"{work}/{name}/*.png"))]
    width, height = tiles[0].size
    sheet = Image.new("RGB", (columns * width, len(tiles) // columns * height))
    for i, tile in enumerate(tiles):
        sheet.paste(tile, (i % columns * width, i // columns * height))
    sheet.save(f"{out}/{name}.png", optimize=True)
PY
