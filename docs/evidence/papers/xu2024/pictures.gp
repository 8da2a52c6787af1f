# Pictures of docs/evidence/papers/xu2024.md from pattern/truth.csv, draws/ (1000 draws) and run/ (one), as the page's commands make them.
set datafile separator ","
set grid lc rgb "#dddddd"
set border lc rgb "#888888"
set tics textcolor rgb "black"
set style fill solid noborder
band = "#c9dcf0"; middle = "#3b76af"; one = "#c8553d"; truth = "#888888"
deg = pi / 180

# Meters east and north of the start (a sphere: for the eye).
stats "pattern/truth.csv" using 2 every ::1::1 nooutput; lat0 = STATS_min
stats "pattern/truth.csv" using 3 every ::1::1 nooutput; lon0 = STATS_min
east(lon) = (lon - lon0) * deg * 6371e3 * cos(lat0 * deg)
north(lat) = (lat - lat0) * deg * 6371e3
# The truth's row and, from column 11, the errors of one draw at the same time.
flown = "< awk -F, 'NR == FNR {t[$1 + 0] = $0; next} ($1 + 0) in t && FNR > 1 {print t[$1 + 0] FS $0}' pattern/truth.csv run/monte_carlo.csv"

set terminal svg size 560,420 font "sans-serif,13" background "white"
set key outside right top reverse Left
set xlabel "east, km"; set ylabel "north, km"
set size ratio -1
set output "track.svg"
plot "pattern/truth.csv" using (east($3) / 1000):(north($2) / 1000) skip 1 with lines lw 2 lc rgb truth title "without errors", \
     flown using ((east($3) + $12) / 1000):((north($2) + $15) / 1000) with lines lw 2 lc rgb one title "one draw"
set size noratio
set xlabel "time, s"
set xrange [0:712]

set terminal svg size 900,900 font "sans-serif,13" background "white"
set key above  # a legend inside would hide curves
do for [kind = 0:2] {
  name = word("position velocity attitude", kind + 1)
  set output name . ".svg"
  set multiplot layout 3, 1
  do for [axis = 0:2] {
    low = 2 + 9 * kind + 3 * axis
    scale = kind == 2 ? 60.0 : 1.0
    set ylabel name . " error " . word("east north up", axis + 1) . (kind == 0 ? ", m" : kind == 1 ? ", m/s" : ", arcmin")
    plot "draws/monte_carlo.csv" using 1:(column(low) / scale):(column(low + 2) / scale) skip 1 with filledcurves lc rgb band title "5..95 % of 1000 draws", \
         "" using 1:(column(low + 1) / scale) skip 1 with lines lw 2 lc rgb middle title "median", \
         "run/monte_carlo.csv" using 1:(column(low + 1) / scale) skip 1 with lines lw 2 lc rgb one title "one draw"
  }
  unset multiplot
}

# By source: one sigma, or the size of what is fixed, of the horizontal position.
set terminal svg size 900,420 font "sans-serif,13" background "white"
set output "sources.svg"
set ylabel "horizontal position, m"
set logscale y
set yrange [0.1:5000]
set key outside right top vertical
kinds = "bias 'white noise' misalignment scale"
starts = "'attitude: level' 'attitude: heading' velocity position"
rows(name) = "< grep '^" . name . ",' draws/sources.csv"
plot for [i = 1:4] rows("gyro " . word(kinds, i)) using 2:(sqrt($3 * $3 + $4 * $4 + $6 * $6 + $7 * $7)) with lines lw 2 lc i title "gyro " . word(kinds, i), \
     for [i = 1:4] rows("accelerometer " . word(kinds, i)) using 2:(sqrt($3 * $3 + $4 * $4 + $6 * $6 + $7 * $7)) with lines lw 2 lc i dt 2 title "accelerometer " . word(kinds, i), \
     for [i = 1:4] rows("start " . word(starts, i)) using 2:(sqrt($3 * $3 + $4 * $4 + $6 * $6 + $7 * $7)) with lines lw 2 lc i dt 3 title "start " . word(starts, i)
