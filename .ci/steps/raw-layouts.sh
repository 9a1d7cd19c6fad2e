raw_layouts
chosen=$(share 3 "$SCRATCH"/raw/*)
# shellcheck disable=SC2086 # names without blanks
python judges tests/judges/raw_files.py $chosen
chosen=$(share 8 "$SCRATCH"/raw/{RGGB,x-trans,full-RGB}-333x217-16bit-{plain,jpeg} "$SCRATCH"/raw/{GRBG,mono}-masked)
# shellcheck disable=SC2086
python judges tests/judges/raw_files.py --developers "$SCRATCH"/raw/RGGB-640x480-12bit-packed $chosen
