raw_layouts
checker_charts
target/release/photosite develop "$SCRATCH"/checker/generic-cmos-color-D65/raw.dng --quiet -o "$SCRATCH/blurred.png" \
    --set develop.demosaic=nearest --set develop.noise_filter=gaussian
python judges tests/judges/measures.py target/release/photosite "$SCRATCH"/blurred.png \
    "$SCRATCH"/checker/generic-cmos-color-D65/image.png "$SCRATCH"/raw/{RGGB,GBRG,mono,quad-bayer}-masked/raw.dng
