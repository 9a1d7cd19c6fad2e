mkdir "$SCRATCH/examples"
ln -s "$PWD/scenes" "$SCRATCH/examples/scenes"
# raw_to_png develops what render_cornell_box has written.
for example in render_cornell_box raw_to_png own_sensor noise_stage own_scene expose_many_times; do
    program="$PWD/target/release/examples/$example"
    (cd "$SCRATCH/examples" && echo "$example" && "$program")
done
