rgb_render
target/release/examples/write_demosaic_charts "$SCRATCH/charts" "$SCRATCH/render/RGGB/electrons.exr"
python judges tests/judges/demosaicing.py "$SCRATCH"/charts/*
