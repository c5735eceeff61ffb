#!/bin/sh
# installed_headers.sh SOURCE OUT STAMP: the headers as they install, spelled antipode/…, under OUT, so
# that the examples of docs/ compile in the tree as they do against an installed antipode.
set -e
for header in base/status geom/vec geom/pose geom/space geom/isometry geom/table track/anchored \
	track/tracker track/setup; do
	mkdir -p "$2/antipode/${header%/*}"
	sed 's|#include "src/|#include "antipode/|' "$1/src/$header.h" > "$2/antipode/$header.h"
done
: > "$3"
