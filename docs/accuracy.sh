#!/bin/sh
# Prints the tables of docs/accuracy.md. Usage: docs/accuracy.sh [FOLDER WITH HDR MAPS] [SIZE]
# Needs `cargo build --release`; the folder is optional.
set -eu
cd "$(dirname "$0")/.."
maps=${1:-}
size=${2:-512x512}
bin=target/release/tapline

# PSNR of each pair that compare prints, in dB, in the ladder's order.
psnr() {
    "$bin" compare "$@" --size "$size" --json - | sed -n 's/.*"psnr_db": *\([0-9.]*\|null\),*/\1/p' |
        sed 's/^null$/identical/; s/\(\.[0-9][0-9]\)[0-9]*/\1/' | tr '\n' ' '
}

row() {
    name=$1
    shift
    exact=$(psnr "$@" --engines rtl,f64)
    table=$(psnr "$@" --engines rtl,f64 --reference-axis table)
    ten=$(psnr "$@" --engines rtl,f64 --unit preset:schilling)
    echo "| $name | $exact| $table| $ten|"
}

echo "rtl against f64, PSNR in dB, $size"
echo
echo "| scene, environment | exact axis | table axis | preset schilling, exact axis |"
echo "|---|--:|--:|--:|"
for scene in sphere cylinder parabola scratches waves; do
    row "$scene, procedural" "$scene"
done
if [ -n "$maps" ]; then
    for scene in sphere cylinder; do
        for map in "$maps"/*.exr "$maps"/*.hdr; do
            row "$scene, $(basename "$map")" "$scene" --env "$map"
        done
    done
fi

echo
echo "The ladder, PSNR in dB, $size"
echo
echo "| scene | rtl - f64 | f64 - ewa | ewa - truth | f64 - truth |"
echo "|---|--:|--:|--:|--:|"
for scene in sphere cylinder parabola scratches waves; do
    ladder=$(psnr "$scene" --engines rtl,f64,ewa,truth | sed 's/ $//; s/ / | /g')
    direct=$(psnr "$scene" --engines f64,truth)
    echo "| $scene | $ladder | $direct|"
done

echo
echo "roughness.scale against truth, PSNR in dB, $size"
echo
echo "| scene | scale | ewa - truth | f64 - truth |"
echo "|---|--:|--:|--:|"
for scene in scratches waves; do
    for scale in 1.0 1.7320508075688772 2.5 3.4641016151377544; do
        ewa=$(psnr "$scene" --engines ewa,truth --set roughness.scale=$scale)
        f64=$(psnr "$scene" --engines f64,truth --set roughness.scale=$scale)
        echo "| $scene | $scale | $ewa| $f64|"
    done
done
