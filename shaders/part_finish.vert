#version 450
#define FINISH
#extension GL_GOOGLE_include_directive : require
#include "part.glsl"
