checker_charts
lights=$(share 3 D65 D50 A)
for cfa in RGGB x-trans; do
    for light in $lights; do
        traced="$SCRATCH/traced/$cfa-$light"
        target/release/photosite render scenes/colour-checker/capture-a.toml --quiet -o "$traced" \
            --set scene.environment.illuminant="$light" --set sensor.cfa=$cfa --set exposure.stages=[]
        target/release/photosite develop "$traced/raw.dng" --quiet -o "$traced/wide.tiff" --set develop.colour_space=rec2020 \
            --set develop.tone_curve=linear --set develop.bits=16
    done
done
for d65 in "$SCRATCH"/checker/*-D65; do presets+=("${d65%-D65}"); done
chosen=$(share 3 "${presets[@]}")
for preset in $chosen; do charts+=("$preset"-{D65,D50,A}); done
python judges tests/judges/developed_colours.py "${charts[@]}" "$SCRATCH"/traced/*
