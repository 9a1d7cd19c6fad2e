# The figures that the EMVA 1288 tool finds of a twin, how often truth lies within two errors of a fit, and whether classifiers tell
# twin and original apart.
sets="$SCRATCH/camera-fit"
target/release/photosite emva1288 sony-imx249-mono --quiet -o "$sets/original" --set serial=7 --set noise.row_noise_e=1.5 --set noise.dsnu_e=2
target/release/photosite fit "$sets/original" --quiet -o "$sets/twin.toml"
target/release/photosite emva1288 "$sets/twin.toml" --quiet --like "$sets/original" --seed 1 -o "$sets/twin"
python emva1288 tests/judges/emva1288_figures.py --twin "$sets/original" "$sets/twin"
rm -r "${sets:?}"
python3 tests/judges/fitted_sensors.py target/release/photosite --seeds 3 --size 128
python twin tests/judges/twin_likeness.py target/release/photosite
