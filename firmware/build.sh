#!/bin/sh
# Builds the images into firmware/image/: pasapas-PART.elf (symbols kept, no debug information) for each
# part named, by default those of lang::part and whole for the tests. Byte for byte the same from any checkout.
#
# Needs a rustc with the MSP430 back end and the library source of the same version: Debian's
# rustc-web, cargo-web, rust-web-src, lld-22 and llvm-22, or a rustup nightly with rust-src and
# LLVM tools. Override with RUSTC, CARGO, MSP430_LD, OBJCOPY.
set -eu
cd "$(dirname "$0")/.."
root=$(pwd)
: "${RUSTC:=/usr/bin/rustc}" "${CARGO:=/usr/bin/cargo}" "${MSP430_LD:=ld.lld-22}" "${OBJCOPY:=llvm-objcopy-22}"
home=${CARGO_HOME:-$HOME/.cargo}
sysroot=$("$RUSTC" --print sysroot)
source=$(readlink -f "$sysroot/lib/rustlib/src/rust")
export RUSTC RUSTC_BOOTSTRAP=1
export CARGO_TARGET_MSP430_NONE_ELF_LINKER="$MSP430_LD"
# A rustup override in the caller's environment must not pick another toolchain.
unset RUSTFLAGS CARGO_ENCODED_RUSTFLAGS || true
# An incremental build splits the assembly, whose parts know one another's distances.
export CARGO_INCREMENTAL=0
# Panics end in `abort`, without a message or a place to tell. The heuristics of the middle end are
# those with which the largest image is smallest, 930 bytes less: none of them changes a meaning.
small="-Zmir-opt-level=1 -Cllvm-args=-inline-threshold=12 -Cllvm-args=-enable-pre=false"
small="$small -Cllvm-args=-bonus-inst-threshold=0 -Cllvm-args=-join-globalcopies -Cllvm-args=-pre-RA-sched=list-burr"
export CARGO_TARGET_MSP430_NONE_ELF_RUSTFLAGS="-Clinker-flavor=ld -Clink-arg=-Tlink.x -Clink-arg=--gc-sections -Clink-arg=--build-id=none --remap-path-prefix=$root=. --remap-path-prefix=$home=cargo --remap-path-prefix=$source=rust -Zunstable-options -Cpanic=immediate-abort $small"
mkdir -p firmware/image
# Of the MSP430F5529 compiled functions go above 64 KB: `far` stands in the linker's place. Tables of jumps
# have no counterpart there.
far() {
    env -u CARGO_TARGET_MSP430_NONE_ELF_RUSTFLAGS "$CARGO" build --quiet --locked --release -p far --target-dir "$root/target/msp430"
    export FAR_LD="$MSP430_LD" FAR_NEAR="$root/firmware/f5529/chip/f5529/near.txt"
    export CARGO_TARGET_MSP430_NONE_ELF_LINKER="$root/target/msp430/release/far"
    export CARGO_TARGET_MSP430_NONE_ELF_RUSTFLAGS="$CARGO_TARGET_MSP430_NONE_ELF_RUSTFLAGS -Cjump-tables=no"
}
# Name and chip of each part. What TI calls MSP430F5 is of the family of the MSP430F5529, whose image is `f5529`.
rows=lang/src/part/rows.rs
# Each row on a line: its name, the name of its chip.
listed=$(tr '\n' ' ' <$rows | sed 's/pub const /\n/g' |
    sed -n 's/^[A-Z0-9_]*: Part = Part {[^}]* name: "\([^"]*\)",[^}]* chip: &\([A-Z0-9]*\),.*/\1 \2/p')
parts=$(echo "$listed" | cut -d' ' -f1)
for part in ${*:-$parts whole}; do
    program=g2553 features=g2553 name=$part
    case $part-$(echo "$listed" | sed -n "s/^$part //p") in
        # All that the G2553's sources can do, on a chip of the tests.
        whole-) features=g2553,whole name=g2553 ;;
        *-MSP430G2*) ;;
        *-MSP430F5*) program=f5529 features=f5529 ;;
        *) echo "$rows has no part $part, or of a chip without sources" >&2; exit 1 ;;
    esac
    (
        export PASAPAS_PART="$name"
        [ "$program" != f5529 ] || far
        "$CARGO" build --quiet --locked -Zbuild-std=core --target msp430-none-elf \
            --profile firmware -p firmware --bin "pasapas-$program" --features "$features" \
            --target-dir "$root/target/msp430"
    )
    out=$root/target/msp430/msp430-none-elf/firmware/pasapas-$program
    "$OBJCOPY" --strip-debug "$out" "firmware/image/pasapas-$part.elf"
done
