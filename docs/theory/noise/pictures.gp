# Pictures of docs/theory/noise.md: lengths.svg from its table (./dev accept noise-lengths), least.svg from the Allan variance of white noise and a walk.
$lengths << EOD
# T K^2/B^2   fit: median, stated uncertainty   read off: median, least 10 %, largest 10 %
1     4.10  0.36   2.01  0.87  3.33
10    1.46  0.33   0.99  0.40  1.74
30    1.05  0.26   0.87  0.40  1.65
100   1.00  0.16   0.82  0.36  1.57
300   1.01  0.10   0.76  0.30  1.49
1000  1.00  0.07   0.81  0.36  1.57
EOD
set terminal svg size 720,360 font "sans-serif,13" background "white"
set grid lc rgb "#dddddd"
set border lc rgb "#888888"
set tics textcolor rgb "black"
set logscale xy
set key top right
set output "lengths.svg"
set xlabel "length of the log, T K² / B²"
set ylabel "K over its truth"
set xrange [0.7:1500]
set yrange [0.2:10]
set ytics (0.2, 0.5, 1, 2, 5, 10)
plot 1 lc rgb "#888888" notitle, \
     $lengths using ($1*0.94):4:5:6 with yerrorbars lw 2 pt 7 ps 0.6 lc rgb "#d55e00" title "line through the curve's right end, middle 80 % of all logs", \
     $lengths using ($1*1.06):2:($2*(1-1.28*$3)):($2*(1+1.28*$3)) with yerrorbars lw 2 pt 7 ps 0.6 lc rgb "#0072b2" \
       title "likelihood, where it determines K, with its stated 80 %"
set output "least.svg"
set key top center
N = 1; K = 0.02
deviation(x) = sqrt(N**2 / x + K**2 * x / 3)
flat = sqrt(2 * N * K / sqrt(3))
set xlabel "averaging time, s"
set ylabel "Allan deviation"
set xrange [1:5000]
set ytics auto
set yrange [0.02:2]
set samples 200
plot deviation(x) lw 2 lc rgb "black" title "white noise and a random walk, no flicker", \
     N / sqrt(x) lw 1 lc rgb "#888888" title "white noise", K * sqrt(x / 3) lw 1 dt 2 lc rgb "#888888" title "random walk", \
     flat lw 2 dt 3 lc rgb "#d55e00" title "its least, read as 0.664 B: there is no B"
