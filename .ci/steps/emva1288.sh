# Figures as TIFF and as DNG.
sets="$SCRATCH/emva1288"
emva1288() {
    target/release/photosite emva1288 "sony-imx249-$1" --quiet -o "$sets/$1" "${@:2}"
}
sensors=$(share 2 mono color)
for sensor in $sensors; do
    case $sensor in
        mono) emva1288 mono --sweep 380..1000:10 --temperatures 15..55:10 ;;
        color) emva1288 color --channels G --format dng ;;
    esac
    target/release/photosite emva1288-report "$sets/$sensor" --json >"$sets/$sensor.json"
    python emva1288 tests/judges/emva1288_figures.py "$sets/$sensor" "$sets/$sensor.json"
    python emva1288 tests/judges/emva1288_figures.py --without-times target/release/photosite "$sets/$sensor"
    rm -r "${sets:?}/$sensor"
done
