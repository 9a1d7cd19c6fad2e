if command -v npm >/dev/null; then
    root=$PWD
    cd "$(npm_package playwright-core@1.65.1)"
    for script in page light sheet; do
        node "$root/tests/view/$script.mjs" "$root/target/release/photosite"
    done
else
    echo "no npm here: the page is not driven"
fi
