#!/bin/sh
# The fewest fraction bits that each register needs on its own, the others at their defaults: by bisection, against
# f64 with the unit's own angle table, on every built-in scene: at least 60 dB and at most 0.1 % of fragments more
# than one 8-bit step off. Usage: docs/words.sh [SIZE] [REGISTER ...]. Needs `cargo build --release`.
set -eu
cd "$(dirname "$0")/.."
bin=target/release/tapline
size=${1:-96x96}
[ $# -gt 0 ] && shift

# Whether every scene keeps the bound with a register's fraction bits.
holds() {
    for scene in scratches waves sphere cylinder parabola; do
        "$bin" compare "$scene" --size "$size" --engines rtl,f64 --reference-axis table --set "$1=$2" --json - 2>/dev/null |
            awk -F': *' '
                /"psnr_db"/ { gsub(/,/, "", $2); if ($2 != "null" && $2 + 0 < 60) bad = 1; seen = 1 }
                /"share_over_1_lsb8"/ { gsub(/,/, "", $2); if ($2 + 0 > 0.001) bad = 1 }
                END { exit (bad || !seen) }' || return 1
    done
}

registers=${*:-$("$bin" unit show --toml | sed -n 's/^\[registers\.\(.*\)\]$/\1/p')}
echo "| register | default frac | fewest frac alone |"
echo "|---|--:|--:|"
for register in $registers; do
    default=$("$bin" unit show --toml | sed -n "/^\[registers\.$register\]\$/,/^\$/s/^frac = //p")
    low=-1
    high=$default
    while [ $((high - low)) -gt 1 ]; do
        middle=$(((high + low) / 2))
        if holds "registers.$register.frac" "$middle"; then high=$middle; else low=$middle; fi
    done
    echo "| $register | $default | $high |"
done
"$bin" unit check
