#!/bin/bash
# Renders the pictures of README.md and scenes/README.md anew: bash scenes/pictures.sh. Takes some ten minutes on two cores.
# The small ones have pixels twice as wide and high, hence a quarter of the exposure time, and more samples each.
set -euo pipefail
cd "$(dirname "$0")/.."
cargo build --release
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

# picture NAME CAPTURE CHANGES...
picture() {
    local name=$1 capture=$2 changes=()
    for change in "${@:3}"; do changes+=(--set "$change"); done
    target/release/photosite render "scenes/$capture" -o "$scratch/$name" "${changes[@]}"
    mv "$scratch/$name/image.png" "scenes/$name.png"
}

small=(sensor.pixel_pitch_um='[12, 12]' render.samples_per_pixel=1024)
picture cornell-box/picture cornell-box/capture.toml
picture colour-checker/picture-d50 colour-checker/capture-d50.toml "${small[@]}" sensor.resolution_px='[400, 300]' exposure.time_s=0.005
picture colour-checker/picture-a colour-checker/capture-a.toml "${small[@]}" sensor.resolution_px='[400, 300]' exposure.time_s=0.005
picture targets/picture targets/capture.toml
picture depth-of-field/picture depth-of-field/capture.toml "${small[@]}" sensor.resolution_px='[400, 260]' exposure.time_s=0.0025
picture balls/picture balls/capture.toml "${small[@]}" sensor.resolution_px='[400, 260]' exposure.time_s=0.00025
