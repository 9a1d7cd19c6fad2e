cargo package --quiet --workspace --exclude photosite-fuzz --exclude photosite-py --no-verify --locked
for shell in bash zsh fish; do
    # The others are read where they are installed.
    if command -v $shell >/dev/null; then
        target/release/photosite completions $shell >"$SCRATCH/completions"
        $shell -n "$SCRATCH/completions"
    fi
done
target/release/photosite man "$SCRATCH/man"
[[ -s $SCRATCH/man/photosite-render.1 ]]
