# Pictures of docs/evidence/papers/xu2024.md, Dai 2011, from ideal/, flight/, none.csv, traditional.csv, whole.csv, fog/ and fog.csv, as the page's commands make them.
set datafile separator ","
set grid lc rgb "#dddddd"
set border lc rgb "#888888"
set tics textcolor rgb "black"
one = "#3b76af"; two = "#c8553d"; three = "#6a9f58"
deg = pi / 180
rate_hz = 200

set terminal svg size 900,900 font "sans-serif,13" background "white"
set xrange [0:87]
set lmargin 11
set key inside right top vertical reverse Left samplen 3 opaque
set output "flight.svg"
set multiplot layout 4, 1
set ylabel "height, km"
plot "ideal/truth.csv" using 1:($4 / 1000) skip 1 with lines lw 2 lc rgb one notitle
set ylabel "specific force, g"
plot "ideal/recording.csv" using 1:($6 * rate_hz / 9.80665) skip 1 every 16 with lines lw 2 lc rgb one title "along the body (y)", \
     "" using 1:($5 * rate_hz / 9.80665) skip 1 every 16 with lines lw 1 lc rgb two title "across (x)", \
     "" using 1:($7 * rate_hz / 9.80665) skip 1 every 16 with lines lw 1 lc rgb three title "across (z)"
set ylabel "rate, deg/s"
plot "ideal/recording.csv" using 1:($3 * rate_hz / deg) skip 1 every 16 with lines lw 2 lc rgb one title "roll, about y", \
     "" using 1:($2 * rate_hz / deg) skip 1 every 16 with lines lw 1 lc rgb two title "about x", "" using 1:($4 * rate_hz / deg) skip 1 every 16 with lines lw 1 lc rgb three title "about z"
set ylabel "temperature, degC"
set xlabel "time, s"
plot "flight/recording.csv" using 1:11 skip 1 every 20 with lines lw 2 lc rgb one notitle
unset multiplot

# Distance between a solution and the truth (a sphere: for the eye).
joined(solution, truth) = "< awk -F, 'NR == FNR {t[$1 + 0] = $0; next} ($1 + 0) in t && FNR > 1 {print t[$1 + 0] FS $0}' " . truth . " " . solution
off(lat, lon, h, lat0, lon0, h0) = sqrt(((lat - lat0) * deg * 6371e3) ** 2 + ((lon - lon0) * deg * 6371e3 * cos(lat0 * deg)) ** 2 + (h - h0) ** 2)
set terminal svg size 900,420 font "sans-serif,13" background "white"
set lmargin 12
set output "errors.svg"
set ylabel "position error, m"
set logscale y
set yrange [0.01:1e5]
set key outside right top
plot for [i = 1:4] joined(word("none.csv traditional.csv fog.csv whole.csv", i), word("flight flight fog flight", i) . "/truth.csv") \
     using 1:(off($12, $13, $14, $2, $3, $4)) with lines lw 2 lc rgb word("#888888 #c8553d #6a9f58 #3b76af", i) \
     title word("'no compensation' traditional FOG whole-unit", i)
