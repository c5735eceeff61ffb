#version 450
#define SINGLE
#define FINISH
#extension GL_GOOGLE_include_directive : require
#include "part.glsl"
