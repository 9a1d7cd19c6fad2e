names=$(fuzz/run --list)
mapfile -t targets <<<"$names"
chosen=$(share 8 "${targets[@]}")
# shellcheck disable=SC2086 # names without blanks
fuzz/run --quick --jobs 2 --seconds 10 $chosen
