# Functions for the steps of the gate, which run in bash -euo pipefail at the root of the repository. $SCRATCH is a folder that
# lasts as long as the run; $CI_CASES has the cases of the step that run, * for all; $CI_TURN is a number of the commit.

# Runs Python in an environment of steps.toml, with the wheel where "+wheel" follows its name: python NAME[+wheel] ARGUMENT...
python() {
    local interpreter
    interpreter=$(interpreter_of "$1")
    "$interpreter" "${@:2}"
}

interpreter_of() {
    local options=()
    if [[ $1 == *+wheel ]]; then options=(--wheel); fi
    python3 "$CI_ROOT/.ci/environments.py" "${1%+wheel}" "${options[@]}"
}

# Prints cases that run, a line each: all; those that are named by what has changed; and, by turn, every Nth: share N CASE...
share() {
    local n=$1 i=$CI_TURN named=() case by_turn
    shift
    if (($# < n)); then n=$#; fi
    for case; do
        if [[ $CI_CASES == '*' || " $CI_CASES " == *" $case "* || " $CI_CASES " == *" ${case##*/} "* ]]; then named+=("$case"); fi
    done
    # Named ones that there are not any more are no reason to run none.
    if [[ " $CI_CASES " == *" by-turn "* ]] || ((${#named[@]} == 0)); then by_turn=1; fi
    for case; do
        if [[ -n ${by_turn-} ]] && ((i++ % n == 0)) || [[ " ${named[*]} " == *" $case "* ]]; then echo "$case"; fi
    done
}

# What more than one step asks for is made once, and is whole where it is there: once FOLDER COMMAND...
once() {
    if [[ ! -e $1 ]]; then
        rm -rf "$1.part"
        "${@:2}" "$1.part"
        mv "$1.part" "$1"
    fi
}

raw_layouts() {
    once "$SCRATCH/raw" target/release/examples/write_raw_layouts
}

checker_charts() {
    once "$SCRATCH/checker" target/release/examples/photograph_colour_checker
}

# Renders the Cornell box: cornell_box FOLDER SETTING...
cornell_box() {
    local folder=$1 settings=() setting
    shift
    for setting; do settings+=(--set "$setting"); done
    target/release/photosite render scenes/cornell-box/capture.toml --quiet -o "$folder" --set render.samples_per_pixel=2 \
        --set output.raw='["dng", "tiff", "pgm", "npy"]' "${settings[@]}"
}

rgb_render() {
    [[ -e $SCRATCH/render/RGGB ]] || cornell_box "$SCRATCH/render/RGGB" sensor.preset=generic-cmos-color sensor.cfa=RGGB
}

# Prints the folder of a package of npm, which is kept in the cache: npm_package NAME@VERSION
npm_package() {
    local cache=${PHOTOSITE_CI_CACHE:-${XDG_CACHE_HOME:-$HOME/.cache}/photosite-ci} made
    if [[ ! -e $cache/npm-$1 ]]; then
        mkdir -p "$cache"
        made=$(mktemp -d "$cache/.npm-XXXXXX")
        (cd "$made" && npm install --silent --no-fund --no-audit "$1" >/dev/null)
        mv -T "$made" "$cache/npm-$1"
    fi
    echo "$cache/npm-$1"
}
