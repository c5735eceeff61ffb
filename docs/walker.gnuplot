# gnuplot docs/walker.gnuplot: how far off walkers in {5,3,4} are, from docs/walker.csv
# (build/tests/track/bench_walker > docs/walker.csv) to docs/images/walker.png.
set terminal pngcairo size 720,440 font "sans,11"
set output "docs/images/walker.png"
set datafile separator ","
set logscale y
set title "Steps that are given, in h3: how far the walker is from where she ought to be"
set xlabel "distance walked, in radii (rho)"
set ylabel "off by (rho, or radians)"
set format y "10^{%L}"
set xrange [0:100]
set yrange [1e-17:1]
set key at 99,1e-9 right
set grid
file = "docs/walker.csv"
plot "<grep '^given,world,' ".file using 4:5 with linespoints title "world matrix, double", \
     "<grep '^given,cell,' ".file using 4:5 with linespoints title "relative to the cell, double", \
     "<grep '^given,cell-dd,' ".file using 4:5 with linespoints title "relative to the cell, double-double", \
     "<grep '^given,cell-256,' ".file using 4:5 with linespoints title "relative to the cell, 256 bits (the program)"
