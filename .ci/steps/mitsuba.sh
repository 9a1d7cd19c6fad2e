scenes=(tests/mitsuba/scenes/*/capture.toml)
scenes=("${scenes[@]%/capture.toml}")
# Two of them by turn.
chosen=$(share $((${#scenes[@]} / 2)) "${scenes[@]##*/}")
# shellcheck disable=SC2086 # names without blanks
python judges tests/mitsuba/references.py --check $chosen
