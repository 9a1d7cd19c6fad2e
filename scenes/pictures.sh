#!/bin/bash
# Renders the images of README.md and scenes/README.md anew: bash scenes/pictures.sh. Takes some ten minutes on two cores.
# The small ones have pixels twice as wide and high, hence a quarter of the exposure time, and more samples each.
set -euo pipefail
cd "$(dirname "$0")/.."
cargo build --release
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

# image NAME CAPTURE CHANGES...
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
# Three lenses at f/1.8 and f/8, side by side: needs Pillow.
for lens in canon-rf24 canon-ef50 canon-ef85; do
    for stop in "1.8 1e-4" "8 1.975e-3"; do
        target/release/photosite render scenes/three-lenses/capture.toml -o "$scratch/$lens-${stop% *}" \
            --set "lens.prescription=$lens" --set "lens.f_number=${stop% *}" --set "exposure.time_s=${stop#* }"
    done
done
python3 - "$scratch" <<'PYTHON'
import sys
from PIL import Image

whole = Image.new("RGB", (1080, 480))
for column, lens in enumerate(("canon-rf24", "canon-ef50", "canon-ef85")):
    for row, stop in enumerate(("1.8", "8")):
        whole.paste(Image.open(f"{sys.argv[1]}/{lens}-{stop}/image.png"), (360 * column, 240 * row))
whole.save("scenes/three-lenses/picture.jpg", quality=88)
PYTHON
picture balls/picture balls/capture.toml "${small[@]}" sensor.resolution_px='[400, 260]' exposure.time_s=0.00025
