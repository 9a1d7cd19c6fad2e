set="$SCRATCH/emva1288-python"
target/release/photosite emva1288 sony-imx249-mono --quiet -o "$set"
python package+wheel tests/judges/python_sensor.py "$set"
python emva1288 tests/judges/emva1288_figures.py "$set"
