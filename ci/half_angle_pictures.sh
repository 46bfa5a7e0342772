#!/usr/bin/env bash
# Renders the pictures of src/technique/half_angle/README.md into docs/images/half_angle.png.
#
#   ci/half_angle_pictures.sh HEAD PYTHON [OUT]
#
# HEAD is a CT of a head in Hounsfield units, z up, its face towards +y; PYTHON has Pillow and joins the pictures.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
head=$(realpath "${1:?CT of a head}") python=${2:?python with Pillow} out=$(realpath "${3:-docs/images/half_angle.png}")
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

n=0
picture() { # SCENE EXPOSURE [KEY=VALUE ...]
    local scene=$1 exposure=$2 set=(--set image.samples_per_axis=2)
    shift 2
    for key in "$@"; do set+=(--set "technique.half_angle.$key"); done
    "$tyndall" -q render "$work/$scene.toml" --size 184x184 --exposure "$exposure" "${set[@]}" \
        -o "$work/$(printf %02d $n).png"
    n=$((n + 1))
}
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

"$python" - "$work" "$out" <<'PY'
import glob, sys
from PIL import Image
tiles = [Image.open(f).convert("RGB") for f in sorted(glob.glob(sys.argv[1] + "/*.png"))]
side = tiles[0].width
sheet = Image.new("RGB", (4 * side, len(tiles) // 4 * side))
for i, tile in enumerate(tiles):
    sheet.paste(tile, (i % 4 * side, i // 4 * side))
sheet.save(sys.argv[2], optimize=True)
PY
