# Convergence curves of docs/evidence/papers/cheng2014.md from curves.csv: estimated residual of each coefficient, and its standard uncertainty.
set datafile separator ","
set terminal svg size 900,1000 font "sans-serif,13" background "white"
set grid lc rgb "#dddddd"
set border lc rgb "#888888"
set tics textcolor rgb "black"
set key outside right top
set xlabel "time, s"
do for [triad in "accel gyro"] {
  set output triad eq "accel" ? "accelerometers.svg" : "gyros.svg"
  set multiplot layout 3, 1
  do for [term = 1:3] {
    names = term == 1 ? "offset.x offset.y offset.z" : term == 2 ? "matrix.xx matrix.yy matrix.zz" : \
            triad eq "accel" ? "matrix.yx matrix.zx matrix.zy" : "matrix.xy matrix.xz matrix.yx matrix.yz matrix.zx matrix.zy"
    unit = term == 1 ? (triad eq "accel" ? 9.80665e-6 : pi / 180 / 3600) : term == 2 ? 1e-6 : pi / 180 / 3600
    set ylabel term == 1 ? (triad eq "accel" ? "bias, ug" : "bias, deg/h") : term == 2 ? "scale factor, ppm" : (triad eq "accel" ? "nonorthogonality, arcsec" : "misalignment, arcsec")
    reach = term == 1 ? (triad eq "accel" ? 300 : 0.3) : term == 2 ? 2000 : 400  # the first minutes exceed it
    set yrange [-reach:reach]
    plot for [i = 1:words(names)] "curves.csv" using 1:(column(triad . "." . word(names, i)) / unit) with lines lw 2 title word(names, i)[strstrt(word(names, i), ".") + 1:]
  }
  unset multiplot
}
