#ifndef ANTIPODE_SIM_HMD_CORE_HOT_H
#define ANTIPODE_SIM_HMD_CORE_HOT_H

// A function that every frame goes through. The linker lays these side by side: the sleep between
// two frames of the real clock empties the caches, and what a frame costs is what it touches.
#define SIM_HOT __attribute__((hot))

#endif
