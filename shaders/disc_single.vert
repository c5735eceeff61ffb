#version 450
#define SINGLE
#extension GL_GOOGLE_include_directive : require
#include "disc.glsl"
