#version 450
#extension GL_GOOGLE_include_directive : require
#define ONE
#include "resolve.glsl"
