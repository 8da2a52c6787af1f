#!/bin/sh
# sh measure.sh HEADER: flash, stack and instructions of a header's functions, exported with --fixed-point --q15, on two processors in QEMU.
# Flash: what a program grows by, the compiler's arithmetic included. Instructions and stack: of one call, without the call itself.
# Cycles: what QEMU executed, by Arm's tables of cycles an instruction, for memory without wait states (cycles.awk): QEMU itself knows none.
set -eu
header=$1
here=$(dirname "$0")
for tool in arm-none-eabi-gcc arm-none-eabi-size qemu-system-arm; do
  command -v $tool > /dev/null || { echo "not run: $tool is not installed (Debian: gcc-arm-none-eabi, qemu-system-arm)"; exit 0; }
done
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

build() { # OUTPUT WHAT REAL FURTHER FLAGS
  output=$1 what=$2 real=$3
  shift 3
  arm-none-eabi-gcc -std=c11 -O2 -ffp-contract=off -Wall -Wextra -Werror "$@" -mthumb -ffreestanding -nostdlib -ffunction-sections -fdata-sections \
    -Wl,--gc-sections -T "$here/link.ld" -DCALIBRATION="\"$header\"" -DWHAT="$what" -DIMULAB_REAL="$real" \
    "$here/startup.c" "$here/cost.c" -lgcc -o "$output"
}
flash() { # WHAT REAL PROCESSOR'S FLAGS: bytes
  build "$folder/flash" "$@" -DFLASH_ONLY
  arm-none-eabi-size "$folder/flash" | awk 'NR == 2 { print $1 + $2 }'
}
run() { # PROGRAM: what it writes
  timeout 60 qemu-system-arm -M "$machine" -icount shift=0 -display none -monitor none -serial none -chardev stdio,id=out \
    -semihosting-config enable=on,target=native,chardev=out -kernel "$1" < /dev/null
}

cycles() { # WHAT REAL PROCESSOR'S FLAGS: of one call, by a table of cycles an instruction (cycles.awk)
  build "$folder/trace" "$@" -DTRACE
  arm-none-eabi-objdump -d --no-show-raw-insn "$folder/trace" > "$folder/listing"
  timeout 120 qemu-system-arm -M "$machine" -singlestep -d exec,nochain -D "$folder/executed" -display none -monitor none -serial none \
    -chardev stdio,id=out -semihosting-config enable=on,target=native,chardev=out -kernel "$folder/trace" < /dev/null
  awk -v processor="$table" -f "$here/cycles.awk" "$folder/listing" "$folder/executed" | cut -d ' ' -f 1
}

case $header in /*) ;; *) header=$PWD/$header ;; esac
echo "| processor | function | numbers | flash, bytes | stack, bytes | instructions | cycles, by the table |"
echo "| --- | --- | --- | --- | --- | --- | --- |"
while read -r machine table name flags; do
  for row in "1 imulab_compensate double" "1 imulab_compensate float" "4 imulab_compensate_fixed int32" "6 imulab_compensate_q15 int16" "2 imulab_filter_push double" \
    "2 imulab_filter_push float" "5 imulab_filter_fixed_push int32"; do
    set -- $row
    real=$3
    case $real in int*) real=float ;; esac
    build "$folder/nothing" 0 "$real" $flags
    build "$folder/program" "$1" "$real" $flags
    bytes=$(($(flash "$1" "$real" $flags) - $(flash 0 "$real" $flags)))
    set -- "$@" $(run "$folder/nothing") $(run "$folder/program")
    echo "| $name | \`$2\` | $3 | $bytes | $(($7 - $5)) | $(($6 - $4)) | $(cycles "$1" "$real" $flags) |"
  done
done <<LIST
mps2-an386 m4 Cortex-M4F -mcpu=cortex-m4 -mfpu=fpv4-sp-d16 -mfloat-abi=hard
microbit m0plus Cortex-M0+ -mcpu=cortex-m0plus -mfloat-abi=soft
LIST
