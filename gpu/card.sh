#!/usr/bin/env bash
# Checks on a card, in a few minutes: digests against the host, then times against one core of the host, and times by kernel.
# `gpu/card.sh FOLDER [LOG]`: FOLDER has the program `scphd-gpu` and a module of `cargo xtask gpu` (target/release/scphd-gpu and
# target/xtask/gpu/modules/scphd-sm_90.cubin, or scphd.ptx), so that it can be carried to a machine with neither Rust nor the sources;
# and, if it is to be timed, the recorded log `thesis_cmp_a00`. Without a card, the module (scphd.ptx) is interpreted for the digests
# of a few scans, and the script ends with 3.
set -euo pipefail
folder=${1:?a folder with the program scphd-gpu and a module}
log=${2:-$folder/card.log}
device=cuda

ask() {
    echo "\$ scphd-gpu $*"
    timeout -k 5 90 "$folder/scphd-gpu" "$@" --device $device --modules "$folder"
}

{
    ask check thesis-dynamic --runs 16 --scans 100 || {
        code=$?
        if [ $code = 3 ]; then
            device=ptx
            ask check thesis-dynamic --runs 2 --scans 20
            ask check survey --particles 32 --scans 20
            for scenario in thesis-dynamic survey; do ask check $scenario --joint --scans 20; done
            ask check thesis-dynamic --particles 64 --scans 10
        fi
        exit $code
    }
    ask check survey --particles 32 --runs 8 --scans 60
    ask check thesis-dynamic --joint --runs 16 --scans 100
    ask check survey --joint --runs 16 --scans 100
    ask check thesis-dynamic --particles 64 --scans 60
    ask check thesis-dynamic --particles 4096 --scans 4
    ask time thesis-dynamic --runs 10000
    ask time thesis-dynamic --runs 4096 --profile
    for runs in 256 2048 10000; do ask time survey --joint --runs "$runs"; done
    ask time thesis-dynamic --joint --runs 10000
    for particles in 256 1024 4096; do ask time thesis-dynamic --particles "$particles" --scans 16; done
    ask time thesis-dynamic --particles 4096 --scans 16 --profile
    if [ -d "$folder/thesis_cmp_a00" ]; then
        printf '[filter]\nproposal = "blind"\nprune_weight = 1e-5\n' > "$folder/blind.toml"
        ask time "$folder/thesis_cmp_a00" --particles 4096 --scans 60 --settings "$folder/blind.toml"
        ask check "$folder/thesis_cmp_a00" --particles 4096 --scans 4
        ask time "$folder/thesis_cmp_a00" --particles 4096 --scans 60 --profile
    fi
} 2>&1 | tee "$log"
