# Lanes of a processor that this machine does not have: Debian's compiler links for it, an emulator runs the tests.
rustup target add aarch64-unknown-linux-gnu || true
if [[ ! -d $(rustc --print sysroot)/lib/rustlib/aarch64-unknown-linux-gnu/lib ]]; then
    echo "warning: no standard library of aarch64-unknown-linux-gnu is to be had: lanes of NEON are not tested"
    exit 0
fi
export CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_LINKER=aarch64-linux-gnu-gcc
export CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_RUNNER="qemu-aarch64 -L /usr/aarch64-linux-gnu"
crate=(--release --locked -p photosite-simd --target aarch64-unknown-linux-gnu)
cargo clippy "${crate[@]}" --all-targets -- -D warnings
cargo test "${crate[@]}"
