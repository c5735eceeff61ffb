#version 450
#define EXACT
#extension GL_GOOGLE_include_directive : require
#include "part_guard.glsl"
