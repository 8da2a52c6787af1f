# Cycles of a function's last call, from what was executed and from a table of cycles an instruction, without wait states of the memory.
#   awk -v processor=m0plus|m4 -f cycles.awk DISASSEMBLY TRACE      objdump -d --no-show-raw-insn; qemu -singlestep -d exec,nochain -D TRACE
# Begins anew at each entry of `measured`, ends at `known_end`.
# Cortex-M0+ (Arm DDI 0484C, table 3.1): with the multiplier of one cycle. Cortex-M4 (Arm 100166, tables 3-1 and 7-1): a taken branch refills the pipeline
# in 1 to 3 cycles, here 2; loads one after the other overlap, here not; so it is rather too many.
FNR == 1 { file++ }
file == 1 && /^[0-9a-f]+ <measured>:/ { begin = substr($1, 1, 8) }
file == 1 && /^[0-9a-f]+ <known_end>:/ { finish = substr($1, 1, 8) }
file == 1 && $1 ~ /^[0-9a-f]+:$/ && NF > 1 {
  at = sprintf("%8s", substr($1, 1, length($1) - 1))
  gsub(/ /, "0", at)
  operation = $2
  sub(/\.[nw]$/, "", operation)
  line = $0
  sub(/[@;].*/, "", line)
  name[at] = operation
  operands[at] = line
  if (before != "") following[before] = at
  before = at
  next
}
file == 1 { next }
{
  split($4, part, "/")
  pc = part[2]
  if (counting) total += cost(last, pc)
  if (pc == begin) { total = 0; counting = 1; count = 0 }
  if (pc == finish && counting) { counting = 0; result = total; instructions = count }
  count++
  last = pc
}
END { printf "%d %d\n", result, instructions }

function registers(text, list, i, n, parts, ends, count) { # of {r4, r5-r7, lr}
  if (!match(text, /\{[^}]*\}/)) return 1
  list = substr(text, RSTART + 1, RLENGTH - 2)
  n = split(list, parts, ",")
  for (i = 1; i <= n; i++) {
    gsub(/[ a-z]/, "", parts[i])
    count += split(parts[i], ends, "-") == 2 ? ends[2] - ends[1] + 1 : 1
  }
  return count
}
function cost(at, to, op, taken, m0) {
  op = name[at]
  m0 = processor == "m0plus"
  taken = to != following[at]
  if (op ~ /^(push|stm)/) return 1 + registers(operands[at])
  if (op ~ /^(pop|ldm)/) return operands[at] ~ /pc/ ? 3 + registers(operands[at]) : 1 + registers(operands[at])
  if (op ~ /^v(push|stm|pop|ldm)/) return 1 + registers(operands[at])
  if (op == "bl") return 3
  if (op ~ /^(bx|blx)$/) return m0 ? 2 : 3
  if (op ~ /^(b|beq|bne|bcs|bcc|bmi|bpl|bvs|bvc|bhi|bls|bge|blt|bgt|ble|cbz|cbnz)$/) return taken ? (m0 ? 2 : 3) : 1
  if (op ~ /^tb[bh]$/) return 4
  if (op ~ /^(ldrd|strd)/) return 3
  if (op ~ /^(ldr|str)/) return operands[at] ~ /\<pc\>, \[|[[:space:]]pc,/ ? 4 : 2
  if (op ~ /^v(ldr|str)/) return operands[at] ~ /[[:space:]]d[0-9]/ ? 3 : 2
  if (op ~ /^vdiv/ || op ~ /^vsqrt/) return 14
  if (op ~ /^v(fma|fms|fnma|fnms|mla|mls|nmla|nmls)/) return 3
  if (op ~ /^[us]div/) return 12
  if (op ~ /^(mrs|msr|dsb|isb|dmb)$/) return 4
  return 1
}
