#ifndef ANTIPODE_SIM_HMD_INPUT_HAND_MODEL_H
#define ANTIPODE_SIM_HMD_INPUT_HAND_MODEL_H

#include "src/device/handlog.h"

// A made-up hand for where no recording has one: the hand that holds a controller at this grip
// pose. squeeze closes the fingers, trigger the index finger, both 0…1; at 0 it is relaxed. A pure
// function; bones have the lengths of a grown-up's.
void sim_make_hand(int hand, struct ap_pose stage_from_grip, double trigger, double squeeze,
                   struct ap_hand *out);

#endif
