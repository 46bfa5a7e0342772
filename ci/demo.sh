#!/usr/bin/env bash
# Builds Tyndall and renders its default scene into out/.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

ci/setup.sh
cargo build --release --locked
mkdir -p out
"${CARGO_TARGET_DIR:-target}/release/tyndall" render --output out/demo.png --output out/demo.exr
echo "demo: $PWD/out/demo.png is the picture, $PWD/out/demo.exr its linear radiance"
