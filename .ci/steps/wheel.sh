# Of the tree, so that the crates are not compiled again in another folder. That the source distribution has every file that its
# crates are made of is checked without making code; --full makes a wheel of it, as pip does.
python tools -m maturin build --release --locked --out "$SCRATCH/wheels"
python tools -m maturin sdist --out "$SCRATCH/sdist"
# Times of the archive are old ones: cargo would take what was compiled of an earlier distribution for this one.
tar -xzmf "$SCRATCH"/sdist/photosite-*.tar.gz -C "$SCRATCH/sdist"
source=$(echo "$SCRATCH"/sdist/photosite-*/)
if [[ $CI_CASES == '*' ]]; then
    (cd "$source" && python tools -m maturin build --release --out "$SCRATCH/sdist/wheels")
    rm -r "$source/target"
else
    # Not --locked: the lock that it has is that of all crates, of which some are not in it.
    CARGO_TARGET_DIR=$PWD/target cargo check --quiet --release --features gpu --manifest-path "$source/crates/photosite-py/Cargo.toml"
fi
ls -l "$SCRATCH/wheels"
wheel=$(echo "$SCRATCH"/wheels/*.whl)
[[ $wheel == *-cp39-abi3-* && $(stat -c %s "$wheel") -le 25000000 ]]
