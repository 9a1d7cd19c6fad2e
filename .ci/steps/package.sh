# First alone, with what it asks for, then with what tests need; not from here, where Python finds the source.
root=$PWD
interpreter=$(interpreter_of tools)
uv=${interpreter%/*}/uv
"$uv" venv --quiet --python "$interpreter" "$SCRATCH/alone"
"$uv" pip install --quiet --python "$SCRATCH/alone/bin/python" --constraints .ci/locks/package.lock "$SCRATCH"/wheels/*.whl
cd "$SCRATCH"
alone/bin/python -c "import photosite"
alone/bin/photosite --version
PHOTOSITE_BINARY="$root/target/release/photosite" python package+wheel -m pytest -q -n 2 -p no:cacheprovider "$root/python/tests"
