# For the scripts beside it: what `begin` starts ends with the script, however that ends. A shell that waits for
# a program in the foreground hears no signal, so everything is in the background.
children=
begin() {
    "$@" &
    last=$!
    children="$children $last"
}
trap 'trap - EXIT; kill $children 2>/dev/null || true; wait' EXIT
trap 'exit 130' INT
trap 'exit 143' TERM HUP
