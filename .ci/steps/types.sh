python package+wheel -m mypy --cache-dir "$SCRATCH/mypy"
python package+wheel -m pyright --pythonpath "$(interpreter_of package+wheel)"
allowed=$PWD/python/tests/stubtest.txt
cd "$SCRATCH"
python package+wheel -m mypy.stubtest photosite._photosite --allowlist "$allowed"
