#version 450
#define SINGLE
#define GUARD
#extension GL_GOOGLE_include_directive : require
#include "part.glsl"
