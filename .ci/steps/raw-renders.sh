render="$SCRATCH/render"
rgb_render
for cfa in BGGR GRBG GBRG x-trans full:RGB; do
    cornell_box "$render/${cfa/:/-}" sensor.preset=generic-cmos-color sensor.cfa=$cfa
done
cornell_box "$render/mono" sensor.preset=sony-imx249-mono sensor.cfa=mono
for layout in bayer linear; do
    cornell_box "$render/quad-$layout" sensor.preset=generic-cmos-color sensor.cfa=quad-bayer output.raw_layout=$layout \
        output.dng_compression=packed
done
# Sensors whose numbers are nonlinear on purpose.
nonlinear() {
    target/release/photosite expose "$render/RGGB" --quiet -o "$render/$1" --set output.raw='["dng", "tiff"]' --set "$2"
}
nonlinear gamma 'sensor.adc.companding={ bits = 10, gamma = 2.2 }'
nonlinear knees 'sensor.adc.companding={ bits = 10, knee_points_dn = [[0, 0], [300, 300], [1200, 600], [4095, 1023]] }'
nonlinear logarithmic sensor.charge.logarithmic_reference_e_per_s=2000
python judges tests/judges/raw_files.py "$render"/*
python judges tests/judges/raw_files.py --developers "$render"/{x-trans,full-RGB,quad-linear}
