names=$(python book+wheel docs/run.py --list)
mapfile -t pages <<<"$names"
chosen=$(share 2 "${pages[@]}")
# shellcheck disable=SC2086 # names without blanks
PATH="$PWD/target/release:$PATH" python book+wheel docs/run.py $chosen
