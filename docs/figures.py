#!/usr/bin/env python3
"""Makes the figures of docs/figures.md anew: figures.py [--antipode PROGRAM] OUT

Needs the built program, Vulkan (software will do) and gnuplot; of Python only what comes with it.
Everything measured is measured in the pictures that the program drew; everything exact comes from
`antipode eval` or from the closed form that stands beside it.
"""
import csv
import json
import math
import os
import subprocess
import sys
import tempfile
import zlib

RHO = {"h3": 0.848036510331695, "s3": 0.572957795130823, "e3": 1.0}  # the 0.9 m table's
DARK = "#101418"


class Studio:
    def __init__(self, program, out):
        self.program, self.out = program, out
        self.work = tempfile.mkdtemp(prefix="figures-")
        os.makedirs(out, exist_ok=True)

    def path(self, name):
        return os.path.join(self.work, name)

    def eval(self, lines):
        """Numbers for each request."""
        done = subprocess.run([self.program, "eval"], input="\n".join(lines) + "\n", text=True,
                              capture_output=True, check=True)
        return [[float(x) for x in line.split()] for line in done.stdout.splitlines()]

    def scene(self, name, space, radius, objects, background=DARK):
        path = self.path(name + ".json")
        with open(path, "w") as f:
            json.dump({"space": {"geometry": space, "radius_m": radius}, "background": background,
                       "objects": objects}, f)
        return path

    def shoot(self, name, head, size=(560, 420), half=0.6, options=()):
        """One stereo pair from a head at (x, y, z), turned by yaw and pitch. Returns its folder."""
        tall = math.atan(math.tan(half) * size[1] / size[0])
        eye = {"resolution_px": list(size), "yaw_rad": 0,
               "fov_rad": {"left": -half, "right": half, "up": tall, "down": -tall}}
        profile, log, folder = self.path("camera.json"), self.path("head.csv"), self.path(name)
        with open(profile, "w") as f:
            json.dump({"name": "camera", "refresh_hz": 90, "ipd_m": 0.064,
                       "eyes": {"left": eye, "right": eye}}, f)
        x, y, z, yaw, pitch = head
        q = (math.cos(yaw / 2) * math.sin(pitch / 2), math.sin(yaw / 2) * math.cos(pitch / 2),
             -math.sin(yaw / 2) * math.sin(pitch / 2), math.cos(yaw / 2) * math.cos(pitch / 2))
        with open(log, "w") as f:
            f.write("t_ns,device,px,py,pz,qx,qy,qz,qw\n0,head,%.17g,%.17g,%.17g," % (x, y, z))
            f.write("%.17g,%.17g,%.17g,%.17g\n" % q)
        subprocess.run([self.program, "replay", "--headset", profile, "--frames", "0:1", "--force",
                        "--out", folder, *options, log], check=True, stderr=subprocess.DEVNULL)
        return folder

    def keep(self, folder, name, which="left"):
        with open(os.path.join(folder, "000000-%s.png" % which), "rb") as f:
            data = f.read()
        with open(os.path.join(self.out, name + ".png"), "wb") as f:
            f.write(data)
        print("%s.png" % name)

    def plot(self, name, script, size="640,420"):
        path = os.path.join(self.out, name + ".png")
        text = ('set terminal pngcairo size %s noenhanced font "DejaVu Sans,10"\nset output "%s"\n'
                % (size, path)) + script
        subprocess.run(["gnuplot", "--default-settings"], input=text, text=True, check=True)
        print("%s.png" % name)


def read_png(path):
    """Rows of bytes R, G, B of an 8-bit RGB picture that is not interlaced."""
    data, at, packed = open(path, "rb").read(), 8, b""
    while at < len(data):
        length, kind = int.from_bytes(data[at:at + 4], "big"), data[at + 4:at + 8]
        body = data[at + 8:at + 8 + length]
        if kind == b"IHDR":
            width, height = (int.from_bytes(body[i:i + 4], "big") for i in (0, 4))
            assert body[8:13] == b"\x08\x02\0\0\0", "not 8-bit RGB"
        elif kind == b"IDAT":
            packed += body
        at += 12 + length
    raw, rows, stride = zlib.decompress(packed), [], 3 * width
    before = bytearray(stride)
    for j in range(height):
        kind, line = raw[j * (stride + 1)], bytearray(raw[j * (stride + 1) + 1:(j + 1) * (stride + 1)])
        for i in range(stride):
            a = line[i - 3] if i >= 3 else 0
            b, c = before[i], before[i - 3] if i >= 3 else 0
            if kind == 1:
                line[i] = (line[i] + a) & 255
            elif kind == 2:
                line[i] = (line[i] + b) & 255
            elif kind == 3:
                line[i] = (line[i] + (a + b) // 2) & 255
            elif kind == 4:
                p = a + b - c
                near = min((abs(p - a), 0, a), (abs(p - b), 1, b), (abs(p - c), 2, c))
                line[i] = (line[i] + near[2]) & 255
        rows.append(bytes(line))
        before = line
    return rows


def linear(byte):
    v = byte / 255
    return v / 12.92 if v <= 0.04045 else ((v + 0.055) / 1.055) ** 2.4


def disc(rows, index, middle, reach):
    """Area in pixels and centre of a disc of which `index` (0 red, 1 green, 2 blue) is full, on a
    black ground, within `reach` pixels of where it should be: by its share of light."""
    area = x = y = 0.0
    for j in range(max(0, int(middle[1] - reach)), min(len(rows), int(middle[1] + reach) + 1)):
        for i in range(max(0, int(middle[0] - reach)), min(len(rows[0]) // 3, int(middle[0] + reach) + 1)):
            share = linear(rows[j][3 * i + index])
            area, x, y = area + share, x + share * (i + 0.5), y + share * (j + 0.5)
    return area, x / area, y / area


def cone_of(area, centre):
    """The half-angle of a cone whose picture has this area and this centre, all tangents."""
    off, half = math.atan(centre), 0.0
    for _ in range(20):  # the picture's centre is not the axis's
        half = cone_at(area, off)
        off = math.atan(centre * (1 - (math.sin(half) / math.cos(off)) ** 2))
    return half


def cone_at(area, off):
    low, high = 0.0, math.pi / 2 - off - 1e-6
    for _ in range(60):
        s = math.sin((low + high) / 2)
        det = math.cos(off) ** 2 - s * s
        grows = math.pi * s * s * math.cos((low + high) / 2) / det ** 1.5 < area if det > 0 else False
        low, high = ((low + high) / 2, high) if grows else (low, (low + high) / 2)
    return (low + high) / 2


def tables(studio):
    # Above: under the lamp. (Closer to it, in s3, its picture by the long way round fills the sky.)
    for space, up, above, wide in (("h3", 1.42, 0.88, 0.74), ("s3", 1.3, 0.27, 1.22), ("e3", 1.45, 0.9, 0.74)):
        folder = studio.shoot(space + "-player", (0.25, up, 0.98, 0.2, -0.62),
                              half=0.8 if space == "s3" else 0.6, options=["--space", space])
        studio.keep(folder, "table-%s-player" % space)
        folder = studio.shoot(space + "-above", (0, 0.75 + above, 0, 0, -math.pi / 2), half=wide,
                              size=(440, 440),
                              options=["--space", space, "--tracker", "anchor"])
        studio.keep(folder, "table-%s-above" % space)
    # A corner of s3's from straight above it: a right angle.
    folder = studio.shoot("s3-corner", (0, 0.75 + 0.3, 0.5, 0, -math.pi / 2), half=0.8, size=(440, 440),
                          options=["--space", "s3", "--tracker", "anchor"])
    studio.keep(folder, "table-s3-corner")
    # With one eye, and as a tourist: the same place.
    for name, more in (("tourist", ["--view", "tourist"]), ("one-eye", ["--eye", "left"])):
        folder = studio.shoot("h3-" + name, (0.25, 1.42, 0.98, 0.2, -0.62), size=(480, 360),
                              options=["--space", "h3", *more])
        studio.keep(folder, "table-h3-" + name, "sbs")


def readme(studio):
    folder = studio.shoot("readme", (0.18, 1.36, 0.86, 0.16, -0.72), size=(548, 400), half=0.62,
                          options=["--space", "h3"])
    studio.keep(folder, "h3-sbs", "sbs")


def dodecahedra(studio):
    """The tilings of h3 by right-angled dodecahedra and of s3 by those with angles of 120 degrees."""
    for name, symbol in (("h3", "5,3,4"), ("s3", "5,3,3")):
        folder = studio.shoot("dodecahedra-" + name, (0.05, 0.03, 0.1, 0.4, 0.15), half=0.75,
                              options=["--scene", "honeycomb:" + symbol])
        studio.keep(folder, "dodecahedra-" + name)


def sizes(studio):
    """Balls in s3 that look smaller and then larger; their angular size against the exact one."""
    rho, s, half, size = 1.0, 0.035, 0.75, (960, 400)
    distances = [0.3, 0.5, 0.8, 1.15, math.pi / 2, 2.0, 2.35, 2.65, 2.85]
    angles = [math.radians(a) for a in (-34, -23, -14, -7, 0, 7, 14, 23, 34)]
    colors = ["#ff0000", "#00ff00", "#ff0001", "#00ff01", "#ff0002", "#00ff02", "#ff0003",
              "#00ff03", "#ff0004"]
    balls = [{"ball": {"at_m": [d * math.sin(a), 0, -d * math.cos(a)], "radius_m": s, "color": c,
                       "lit": False}} for d, a, c in zip(distances, angles, colors)]
    scene = studio.scene("sizes", "s3", rho, balls, "#000000")
    # Seen by one eye alone, the left; so the nose is moved to the right by half the eyes' distance.
    folder = studio.shoot("sizes", (0.032, 1e-9, 0, 0, 0), size=size, half=half,
                          options=["--scene", scene, "--view", "tourist"])
    studio.keep(folder, "s3-sizes")
    rows = read_png(os.path.join(folder, "000000-left.png"))
    px = size[0] / 2 / math.tan(half)
    data, worst = "", 0
    for k, (d, a) in enumerate(zip(distances, angles)):
        want = math.asin(math.sin(s / rho) / math.sin(d / rho))
        middle = (size[0] / 2 + px * math.tan(a), size[1] / 2)
        area, x, _ = disc(rows, k % 2, middle, 1.4 * px * want / math.cos(a) ** 2 + 4)
        got = cone_of(area / px ** 2, abs(x - size[0] / 2) / px)
        worst = max(worst, abs(got / want - 1))
        data += "%.9g %.9g %.9g\n" % (d, math.degrees(2 * got), math.degrees(2 * want))
        print("  s3, %.3f m: %.4f degrees across in the picture, exactly %.4f" %
              (d, math.degrees(2 * got), math.degrees(2 * want)))
    print("  worst relative difference %.2g" % worst)
    studio.plot("s3-sizes-curve", '$d << EOD\n%sEOD\nset grid\nset xlabel "distance (m), radius of the space 1 m"\n'
                'set ylabel "looks so wide (degrees)"\nset yrange [0:16]\nset xrange [0:pi]\n'
                'plot 2*asin(sin(%g)/sin(x))*180/pi with lines lw 2 title "exact: 2 asin(sin s / sin d)", \\\n'
                ' 2*asin(%g/x)*180/pi with lines dt 2 title "in flat space", \\\n'
                ' $d using 1:2 with points pt 7 ps 1.2 title "measured in the picture"\n' % (data, s, s))


def cue_stick(studio):
    """The paper's points A to E on a straight stick a metre away, in native view."""
    names, text = "ABCDE", ""
    colors = ["#ff2020", "#20ff20", "#4060ff", "#ffff20", "#20ffff"]
    for space, rho, born in (("h3", 0.85, None), ("e3", 0.85, None), ("s3", 0.85, None),
                             ("e3", 0.85, "h3:0.85")):
        along = [-0.5, -0.25, 0, 0.25, 0.5]
        # Points of the geodesic through (0, 0, -1) at right angles to the line of sight.
        middle = 0.9
        matrices = studio.eval("%s %g walk 0 0 %g %g 0 0" % (space, rho, -middle, t) for t in along)
        at = studio.eval("%s %g log %s" % (space, rho, " ".join("%.17g" % (rho * m[i]) for i in
                                                              (3, 7, 11, 15))) for m in matrices)
        objects = [{"ball": {"at_m": p, "radius_m": 0.018, "color": c, "lit": False, "target": n}}
                   for p, c, n in zip(at, colors, names)]
        label = space if not born else "e3-native-of-h3"
        stick = {"stick": {"from_m": at[0], "to_m": at[4], "radius_m": 0.006}}
        # Measured without the stick, whose rim would touch the points'.
        for shown, which in ((objects + [stick], "seen"), (objects, "measured")):
            options = ["--scene", studio.scene("cue", space, rho, shown)]
            options += ["--native-of", born] if born else []
            folder = studio.shoot("cue-%s-%s" % (label, which), (0, 1e-9, 0, 0, 0), size=(1000, 300),
                                  half=0.75, options=options)
            if which == "seen":
                studio.keep(folder, "cue-" + label, "sbs")
        with open(os.path.join(folder, "vergence.csv")) as f:
            rows = {r["target"]: r for r in csv.DictReader(f)}
        text += "$%s << EOD\n" % label.replace("-", "_")
        for n, p in zip(names, at):
            true, seen = float(rows[n]["true_m"]), float(rows[n]["inferred_m"] or "nan")
            side = math.atan2(p[0], -p[2])
            text += "%.6f %.6f %.6f %.6f %s\n" % (seen * math.sin(side), seen * math.cos(side),
                                                  true * math.sin(side), true * math.cos(side), n)
            print("  cue %s, %s: %.4f m away, %.4f m by the two eyes' pictures, %+.3f px" %
                  (label, n, true, seen, float(rows[n]["error_px"] or "nan")))
        text += "EOD\n"
    studio.plot("cue-shape", text + 'set grid\nset size ratio -1\nset key outside bottom horizontal\n'
                'set xlabel "to the side (m)"\nset ylabel "ahead (m)"\nset yrange [0.55:1.1]\n'
                'set xrange [-0.75:0.75]\nplot '
                + ", \\\n".join('$%s using 3:4 smooth csplines lw 2 lc %d title "%s, exact", '
                                '$%s using 1:2 with points pt 7 lc %d title "measured"' %
                                (v, k, t, v, k) for k, (v, t) in
                                enumerate((("h3", "h3"), ("e3", "e3"), ("s3", "s3")), 1)) +
                ', \\\n $e3_native_of_h3 using 1:2 with linespoints pt 6 lc 4 dt 3 '
                'title "a stick of e3 as shown to one born in h3"\n', "760,480")


def holonomy(studio):
    """Carried round a square on the table without being turned, an arrow comes home turned."""
    for space in ("h3", "e3", "s3"):
        rho = RHO[space]
        side, n = 0.32 * (rho if space != "e3" else 0.85), 5
        steps = [(0, 0, -1), (-1, 0, 0), (0, 0, 1), (1, 0, 0)]
        start = "%.17g 0 %.17g" % (side / 2, side / 2)
        walked, asks = [], []
        for leg in range(4):
            for k in range(n):
                walked.append(steps[leg])
        for upto in range(4 * n + 1):
            for tip in ((0, 0.012, 0), (0, 0.012, -0.075)):
                lift, ahead = "0 %.17g 0" % tip[1], "0 0 %.17g" % tip[2]
                way = " ".join("%.17g %.17g %.17g" % tuple(c * side / n for c in w)
                               for w in walked[:upto])
                asks.append("%s %.17g walk %s %s %s %s" % (space, rho, start, way, ahead, lift))
        points = studio.eval(asks)
        logs = studio.eval("%s %.17g log %s" % (space, rho, " ".join("%.17g" % (rho * m[i]) for i in
                                                                   (3, 7, 11, 15))) for m in points)
        objects = [{"table": {}}]
        for k in range(4 * n + 1):
            foot, tip = logs[2 * k], logs[2 * k + 1]
            color = "#30ff50" if k == 0 else "#ff4030" if k == 4 * n else "#e8e8e8"
            r = 0.006 if k in (0, 4 * n) else 0.003
            objects += [{"ball": {"at_m": foot, "radius_m": 1.7 * r, "color": color}},
                        {"stick": {"from_m": foot, "to_m": tip, "radius_m": r, "color": color}}]
        a, b = points[0], points[2 * 4 * n]
        turned = math.degrees(math.atan2(a[0] * b[8] - a[8] * b[0], a[0] * b[0] + a[8] * b[8]))
        print("  %s: a square of %.3f m; the arrow comes home turned by %.2f degrees" %
              (space, side, -turned))
        scene = studio.scene("holonomy", space, rho, objects)
        folder = studio.shoot("holonomy-" + space, (0.0, 1.33, 0.3, 0, -1.1), half=0.42,
                              size=(440, 330),
                              options=["--scene", scene, "--tracker", "anchor"])
        studio.keep(folder, "holonomy-" + space)


def banana(studio):
    """What lies within a field of view of s3: from the eye to its antipode (one dimension less)."""
    studio.plot("view-banana", '''
set parametric
set view 70, 0, 1.35
set view equal xyz
unset border
unset tics
unset key
set isosamples 22, 15
set urange [0:pi]
set vrange [0:2*pi]
set samples 200
a = 0.42
e = 0.16
$e << EOD
0 0 1
EOD
$a << EOD
0 0 -1
EOD
set label 1 "eye" at 0, 0, 1.12
set label 2 "its antipode" at 0, 0, -1.12
set label 3 "near" at 0.22, -0.3, 0.99
splot sin(u)*cos(v), sin(u)*sin(v), cos(u) with lines lc rgb "#d0d4da" lw 0.6, \\
 sin(u)*cos(-pi/2-a), sin(u)*sin(-pi/2-a), cos(u) with lines lc rgb "#c02020" lw 3, \\
 sin(u)*cos(-pi/2+a), sin(u)*sin(-pi/2+a), cos(u) with lines lc rgb "#c02020" lw 3, \\
 sin(e)*cos(-pi/2-a+2*a*u/pi), sin(e)*sin(-pi/2-a+2*a*u/pi), cos(e)+0*u with lines lc rgb "#2050c0" lw 3, \\
 sin(pi-e)*cos(-pi/2-a+2*a*u/pi), sin(pi-e)*sin(-pi/2-a+2*a*u/pi), cos(pi-e)+0*u with lines lc rgb "#2050c0" lw 3, \\
 cos(-pi/2-a+2*a*u/pi), sin(-pi/2-a+2*a*u/pi), 0*u with lines lc rgb "#209040" dt 2 lw 2, \\
 $e using 1:2:3 with points pt 7 lc black, $a using 1:2:3 with points pt 6 lc black
''', "440,440")


def main(argv):
    program = "antipode"
    if len(argv) == 4 and argv[1] == "--antipode":
        program, argv = os.path.abspath(argv[2]), argv[2:]
    if len(argv) != 2 or argv[1].startswith("-"):
        print(__doc__, file=sys.stderr)
        return 2
    studio = Studio(program, argv[1])
    for figure in (readme, tables, sizes, cue_stick, holonomy, banana, dodecahedra):
        print("%s:" % figure.__name__, flush=True)
        figure(studio)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv))
