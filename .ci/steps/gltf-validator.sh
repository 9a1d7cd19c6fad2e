if command -v npm >/dev/null; then
    tests=$PWD/tests/gltf
    cd "$(npm_package gltf-validator@2.0.0-dev.3.10)"
    node "$tests/validate.mjs" "$tests"/*.gltf
else
    echo "no npm here: the files are not validated"
fi
