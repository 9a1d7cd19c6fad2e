# With what is compiled already, in a copy, as our crates stand in another folder there, and would be compiled again here.
mkdir -p "$SCRATCH/target/release"
cp -a target/release/{.fingerprint,build,deps} "$SCRATCH/target/release"
CARGO_TARGET_DIR="$SCRATCH/target" python tools -m maturin build --release --sdist -o "$SCRATCH/wheels"
rm -r "$SCRATCH/target"
ls -l "$SCRATCH/wheels"
wheel=$(echo "$SCRATCH"/wheels/*.whl)
[[ $wheel == *-cp39-abi3-* && $(stat -c %s "$wheel") -le 25000000 ]]
