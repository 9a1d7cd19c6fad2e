quick=()
if [[ $CI_CASES != '*' ]]; then quick=(--quick); fi
names=$(python3 tests/faults.py --list "${quick[@]}")
mapfile -t faults <<<"$names"
chosen=$(share ${#faults[@]} "${faults[@]}")
# shellcheck disable=SC2086 # names without blanks
python3 tests/faults.py $chosen
