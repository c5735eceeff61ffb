#version 450
#define GUARD
#extension GL_GOOGLE_include_directive : require
#include "part.glsl"
