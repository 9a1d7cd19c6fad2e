names=$(fuzz/run --list)
mapfile -t targets <<<"$names"
chosen=$(share 13 "${targets[@]}")
# Where much has changed, four of them, by turn, as each takes half a minute on two cores.
if [[ $CI_CASES != '*' ]]; then chosen=$(tail -n 4 <<<"$chosen"); fi
# shellcheck disable=SC2086 # names without blanks
fuzz/run --quick --jobs 2 --seconds 60 $chosen
