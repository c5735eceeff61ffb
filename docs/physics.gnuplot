# gnuplot docs/physics.gnuplot: run time against error, from docs/physics.csv
# (build/tests/game/bench_billiards > docs/physics.csv) to docs/images/physics-error.png.
set terminal pngcairo size 720,480 font "sans,11"
set output "docs/images/physics-error.png"
set datafile separator ","
set logscale xy
set xlabel "CPU time of 1.5 s of play, ms"
set ylabel "error of the farthest ball, m"
set format xy "10^{%L}"
set yrange [1e-16:0.1]
set key bottom left
set grid
plot for [s in "s3 e3 h3"] "<grep '^steps," . s . ",' docs/physics.csv" using 4:5 with linespoints \
       title s . " in steps of 10 ms to 3 {/Symbol m}s", \
     for [s in "s3 e3 h3"] "<grep '^events," . s . ",' docs/physics.csv" using 4:5 with points \
       pointtype 7 pointsize 1.4 title s . " event by event"
