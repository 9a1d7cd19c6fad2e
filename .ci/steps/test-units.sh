# All tests but those with steps of their own, which a runner leaves out: so cargo builds all crates at once, as always, and what
# they stand on has the features that the program is built with.
cat >"$SCRATCH/runner" <<'END'
case ${1##*/} in
    cli-* | physics-* | mitsuba-* | figures-*) echo "a step of its own" ;;
    *) exec "$@" ;;
esac
END
cargo test --release --locked --no-fail-fast --config "target.'cfg(all())'.runner = ['bash', '$SCRATCH/runner']"
