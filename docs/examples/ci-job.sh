#!/bin/sh
# A CI job for an OpenXR program: runs it on the simulated headset for 300 frames, lints its calls,
# and compares what the eyes were shown with a stored reference.
#   ci-job.sh REFERENCE PROGRAM [ARGS…]
# A reference that does not exist is made: look at its pictures, then commit the folder.
#   ANTIPODE_OPTIONS   further options of `antipode sim` ("--poses walk.csv --input keys.csv")
#   ANTIPODE_LIMITS    of `antipode compare`; "" asks for the same bytes
# Exit status: 0; 1 the pictures differ, or a call breaks the specification; else the program's own.
set -eu
reference=${1:?"usage: ci-job.sh REFERENCE PROGRAM [ARGS...]"}
shift
out=${OUT:-antipode-out}

antipode sim --headset ci --clock virtual --frames 300 --timeout 120 --hold-stdin --strict \
	--capture "$out/run" --capture-frames ::30 --force ${ANTIPODE_OPTIONS:-} -- "$@"
if [ ! -e "$reference/frames.jsonl" ]; then
	mkdir -p "$reference"
	cp "$out"/run/* "$reference"
	echo "ci-job: $reference is new: look at its pictures and keep it"
	exit 0
fi
antipode compare --quiet ${ANTIPODE_LIMITS---min-psnr 40} --out "$out/diff" "$reference" "$out/run"
