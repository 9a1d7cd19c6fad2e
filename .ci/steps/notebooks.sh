names=$(cd docs/notebooks && ls ./*.ipynb)
mapfile -t notebooks < <(sed 's|^\./||; s|\.ipynb$||; /^train-a-denoiser$/d' <<<"$names")
chosen=$(share 2 "${notebooks[@]}")
# shellcheck disable=SC2086 # names without blanks
python notebooks+wheel docs/notebooks/run.py $chosen
