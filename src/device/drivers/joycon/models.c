#include "src/device/drivers/joycon/joycon.h"

// The table: what differs between the controllers, and who is which.

enum { NINTENDO = 0x057e, A_BUTTON = 3, RIGHT_ARROW = 18 };

static const struct ap_joycon_model left = {.side = "left", .selects = RIGHT_ARROW};
static const struct ap_joycon_model right = {
    .side = "right", .is_upside_down = true, .selects = A_BUTTON};
static const struct ap_joycon_model pro = {.selects = A_BUTTON};

const struct ap_driver_ids ap_joycon_ids[] = {
    {AP_PRODUCT(NINTENDO, 0x2006), .model = &left},
    {AP_PRODUCT(NINTENDO, 0x2007), .model = &right},
    {AP_PRODUCT(NINTENDO, 0x2009), .model = &pro},
    {0},
};
