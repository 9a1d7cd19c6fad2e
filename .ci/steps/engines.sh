root=$PWD
cd "$SCRATCH"
engine() {
    python package+wheel "$root/tests/engines.py" "$root/target/release/photosite" "$@"
}
engine --samples 500
engine --split samples --frames 16 --kills 4 --samples 2000
