#ifndef ANTIPODE_SIM_HMD_WINDOW_INPUT_H
#define ANTIPODE_SIM_HMD_WINDOW_INPUT_H

#include <stdbool.h>
#include <stdint.h>

// The window's keyboard and mouse, for poses {"window": true}. keys is what is held now.
enum sim_key {
    SIM_KEY_FORWARD = 1 << 0,     // W
    SIM_KEY_BACK = 1 << 1,        // S
    SIM_KEY_LEFT = 1 << 2,        // A
    SIM_KEY_RIGHT = 1 << 3,       // D
    SIM_KEY_UP = 1 << 4,          // E
    SIM_KEY_DOWN = 1 << 5,        // Q
    SIM_KEY_SLOW = 1 << 6,        // Shift
    SIM_KEY_TRIGGER = 1 << 7,     // left mouse button, Space
    SIM_KEY_SQUEEZE = 1 << 8,     // right mouse button
    SIM_KEY_HAND_LEFT = 1 << 9,   // 1: the mouse moves the left hand
    SIM_KEY_HAND_RIGHT = 1 << 10, // 2
    SIM_KEY_RECENTRE = 1 << 11,   // R: LOCAL comes to where the head is
    // Sticks and buttons of the controllers.
    SIM_KEY_STICK_UP = 1 << 12,          // I: the left one's
    SIM_KEY_STICK_DOWN = 1 << 13,        // K
    SIM_KEY_STICK_LEFT = 1 << 14,        // J
    SIM_KEY_STICK_RIGHT = 1 << 15,       // L
    SIM_KEY_TURN_LEFT = 1 << 16,         // U: the right one's
    SIM_KEY_TURN_RIGHT = 1 << 17,        // O
    SIM_KEY_X = 1 << 18,                 // X
    SIM_KEY_Y = 1 << 19,                 // Y
    SIM_KEY_A = 1 << 20,                 // C
    SIM_KEY_B = 1 << 21,                 // V
    SIM_KEY_MENU = 1 << 22,              // M, F1
    SIM_KEY_STICK_CLICK = 1 << 23,       // F12: the left one's
    SIM_KEY_RIGHT_STICK_CLICK = 1 << 24, // F11
    SIM_KEY_RIGHT_STICK_UP = 1 << 25,    // T
    SIM_KEY_RIGHT_STICK_DOWN = 1 << 26,  // G
};
struct sim_window_input {
    uint32_t keys;
    double mouse_x_px, mouse_y_px; // accumulated motion since the start (turns the head)
    double wheel;                  // accumulated
    bool closed;                   // the person closed the window: the program is asked to end
};

#endif
