#include "src/scene/build.h"

// A hand closed round something of a finger's width, in OpenXR's grip frame: the held thing runs
// along z, the thumb's side toward −z, the wrist toward +y; the right hand's palm lies on the +x
// side. The left hand is its mirror image.
static const double finger_radius_m = 0.0085;

static void add_finger(struct ap_mesh *m, double z, double longer) {
    const struct ap_vec3 joint[] = {{0.029, -0.014, z},
                                    {0.014, -0.040 * longer, z},
                                    {-0.017, -0.034 * longer, z},
                                    {-0.025, -0.006, z}};
    for (int i = 0; i < 3; i++) {
        double r = finger_radius_m * (1.08 - 0.08 * i);
        ap_mesh_limb(m, joint[i], r, joint[i + 1], r * 0.94);
    }
}

static void add_thumb(struct ap_mesh *m) {
    const struct ap_vec3 joint[] = {{0.024, 0.038, -0.022},
                                    {0.010, 0.026, -0.047},
                                    {-0.014, 0.014, -0.050},
                                    {-0.027, -0.008, -0.045}};
    for (int i = 0; i < 3; i++)
        ap_mesh_limb(m, joint[i], 0.0135 - 0.0018 * i, joint[i + 1], 0.0117 - 0.0018 * i);
}

static void add_hand(struct ap_mesh *m) {
    struct ap_pose palm = AP_POSE_IDENTITY;
    palm.p = (struct ap_vec3){0.030, 0.020, 0};
    ap_mesh_ellipsoid(m, palm, (struct ap_vec3){0.0155, 0.046, 0.041});
    const double z[4] = {-0.030, -0.010, 0.010, 0.029}, longer[4] = {0.97, 1.08, 1.03, 0.86};
    for (int i = 0; i < 4; i++)
        add_finger(m, z[i], longer[i]);
    add_thumb(m);
    struct ap_vec3 wrist = {0.031, 0.050, 0}, cuff = {0.034, 0.100, 0.003};
    ap_mesh_limb(m, wrist, 0.026, cuff, 0.024);
}

static void add_sleeve(struct ap_mesh *m) {
    struct ap_vec3 cuff = {0.034, 0.098, 0.003}, elbow = {0.038, 0.165, 0.006};
    ap_mesh_limb(m, cuff, 0.033, elbow, 0.037);
}

static struct ap_part hand_part(struct ap_scene_build *build, void (*shape)(struct ap_mesh *),
                                bool mirrored, unsigned rgb) {
    struct ap_part part = ap_solid_part(AP_ISO_IDENTITY, 0, rgb);
    for (int k = 0; k < AP_MESH_LEVELS; k++) {
        struct ap_mesh mesh = {.mirrored = mirrored, .sagitta_m = ap_mesh_sagitta_m(k)};
        shape(&mesh);
        int at = ap_build_level(build, &mesh, k, &part.radius_m);
        part.solid = k == 0 ? at : part.solid;
    }
    part.solid_levels = AP_MESH_LEVELS;
    part.one_sided = true;
    return part;
}

void ap_furnish_hands(struct ap_scene_build *build) {
    for (int side = 0; side < 2; side++) {
        void (*const shape[2])(struct ap_mesh *) = {add_hand, add_sleeve};
        const unsigned rgb[2] = {0xd9a078, 0x34507a};
        for (int i = 0; i < 2; i++) {
            struct ap_part part = hand_part(build, shape[i], side == 0, rgb[i]);
            part.carrier = side == 0 ? AP_CARRIER_LEFT : AP_CARRIER_RIGHT;
            ap_build_part(build, part);
        }
    }
}

// Held by the right hand a quarter of a metre from its butt, pointing along the grip's −z.
void ap_furnish_cue(struct ap_scene_build *build) {
    static const struct {
        double butt_z, tip_z, butt_radius, tip_radius;
        unsigned rgb;
    } piece[] = {
        {0.250, 0.230, 0.0140, 0.0140, 0x202020},   // bumper
        {0.230, -0.080, 0.0140, 0.0115, 0x5a2d1a},  // butt
        {-0.080, -0.095, 0.0117, 0.0115, 0xd8c060}, // ring
        {-0.095, -0.725, 0.0114, 0.0064, 0xd9b27c}, // shaft
        {-0.725, -0.744, 0.0066, 0.0063, 0xf2efe6}, // ferrule
        {-0.744, -0.750, 0.0062, 0.0058, 0x2f62a8}, // tip
    };
    for (size_t i = 0; i < sizeof piece / sizeof *piece; i++) {
        double middle = (piece[i].butt_z + piece[i].tip_z) / 2;
        struct ap_part part =
            ap_stick_part(ap_shift(build->scene->space, 0, 0, middle),
                          piece[i].butt_z - piece[i].tip_z, piece[i].tip_radius, piece[i].rgb);
        part.radius2_m = piece[i].butt_radius;
        part.finish = i == 1 || i == 3 ? AP_FINISH_WOOD : AP_FINISH_MATTE;
        part.carrier = AP_CARRIER_RIGHT;
        ap_build_part(build, part);
    }
}
