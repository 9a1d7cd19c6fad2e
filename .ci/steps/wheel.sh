# Without --full of the tree, whose crates then are not compiled again in another folder; that the source distribution has every
# file that its crates are made of is checked without making code. With --full of the source distribution, as pip does.
python tools -m maturin sdist --out "$SCRATCH/sdist"
# Times of the archive are old ones: cargo would take what was compiled of an earlier distribution for this one.
tar -xzmf "$SCRATCH"/sdist/photosite-*.tar.gz -C "$SCRATCH/sdist"
source=$(echo "$SCRATCH"/sdist/photosite-*/)
export CARGO_TARGET_DIR=$PWD/target
# Not --locked where it is of the distribution: the lock that it has is that of all crates, of which some are not in it.
if [[ $CI_CASES == '*' ]]; then
    (cd "$source" && python tools -m maturin build --release --out "$SCRATCH/wheels")
else
    python tools -m maturin build --release --locked --out "$SCRATCH/wheels"
    cargo check --quiet --release --features gpu --manifest-path "$source/crates/photosite-py/Cargo.toml"
fi
ls -l "$SCRATCH/wheels"
wheel=$(echo "$SCRATCH"/wheels/*.whl)
[[ $wheel == *-cp39-abi3-* && $(stat -c %s "$wheel") -le 25000000 ]]
