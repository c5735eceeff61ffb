#!/bin/sh
# Reads every include line of the tree against the table of who may know whom, and fails on one that
# the table does not allow, or that is not spelled from the root. The folders inside of src/render
# have a table of their own: they know nothing of the files above them.
cd "${ANTIPODE_SOURCE:?}" || exit 1
find src xr sim_hmd tests -name '*.[ch]' -print | sort | xargs awk '
	BEGIN {
		may["src/base"] = ""
		may["src/geom"] = "src/base"
		may["src/device"] = "src/geom src/base"
		may["src/track"] = "src/geom src/base"
		may["src/scene"] = "src/geom src/base"
		may["src/view"] = "src/geom src/base"
		may["src/gpu"] = "src/base"
		may["src/image"] = "src/base"
		may["src/render"] = "src/gpu src/view src/scene src/geom src/base shaders"
		may["src/game"] = "src/scene src/track src/geom src/base"
		may["xr"] = "src/geom src/base"
		may["sim_hmd"] = "src/device src/gpu src/image src/geom src/base shaders"
		may["src/app"] = "src/base src/geom src/device src/track src/scene src/view src/image src/gpu src/render src/game xr"
		inside["src/render/logmap"] = inside["src/render/mesh"] = ""
		inside["src/render/pass"] = inside["src/render/place"] = "src/render/mesh"
		inside["src/render/refine"] = "src/render/mesh src/render/place"
	}
	function folder(path) {
		sub(/\/[^\/]*$/, "", path)
		return path
	}
	function room(path, part, n) {
		n = split(path, part, "/")
		return part[1] == "src" ? part[1] "/" part[2] : part[1]
	}
	/^[ \t]*#[ \t]*include[ \t]*"/ {
		match($0, /"[^"]*"/)
		target = substr($0, RSTART + 1, RLENGTH - 2)
		from = room(FILENAME); to = room(target)
		lines++
		if (from == "tests")
			next
		if (target !~ /\// || target ~ /\.\./) {
			print FILENAME ":" FNR ": \"" target "\" is not spelled from the root"; bad++
		} else if (to == "tests" || (from != to && index(" " may[from] " ", " " to " ") == 0)) {
			print FILENAME ":" FNR ": " from " is not to know " to " (" target ")"; bad++
		} else if (to == "src/render" && folder(FILENAME) in inside && folder(target) != folder(FILENAME) &&
			index(" " inside[folder(FILENAME)] " ", " " folder(target) " ") == 0) {
			print FILENAME ":" FNR ": " folder(FILENAME) " is not to know " folder(target) " (" target ")"; bad++
		}
	}
	END {
		print lines + 0 " include lines read, " bad + 0 " wrong"
		exit bad > 0 || lines < 100
	}'
