filters=()
case " $CI_CASES " in
    *" by-turn "* | ' * ') ;;
    *) read -ra filters <<<"$CI_CASES" ;;
esac
cargo test --release --locked --test cli -- "${filters[@]}"
