// What every draw of a frame shares, and what belongs to one draw; src/render/place/frame.h is the same in
// C. Lengths in metres, points of the space over rho.

struct View {
    mat4 eye_from_tangent; // native: rigid, metres; native-of: of her space, over its radius
    vec4 projection;       // clip x = x·projection.x + z·projection.z; y likewise with .y and .w
};

layout(std140, set = 0, binding = 0) uniform Frame {
    View view[2];
    vec4 depth[2]; // tourist: depth = (w·depth.x − z·depth.y)/−z, one for each image
    float rho;      // metres
    float near;     // metres; native: depth = near/−z
    float forbidden; // nothing nearer than so many metres to the eye or its antipode is drawn
    float forbidden_sine; // S(forbidden/rho)
    float born_rho;       // native-of: of the space she was born in
    // Native s3: depth of what is seen the long way round = long_way·(angle from the nose the short way);
    // 0: near/−z there, too.
    float long_way;
    vec4 lamp_light; // S² of the distance where its light is 1; S of its radius; angle of a pixel
};

// What a pipeline draws, so that none pays for what the others are made of (software Vulkan goes
// through both sides of an if): nothing that is made of something; balls; sticks; sheets and solids;
// what is matte; of that what is a plane (part_matte.frag).
const int NOTHING = 0, BALLS = 1, STICKS = 2, SHEETS = 3, MATTE_ONLY = 4, PLANES = 5;
layout(constant_id = 0) const int DRAWS = NOTHING;

// Fixed when a pipeline is made, so that no other world's arithmetic is in it: the sign of the
// space's curvature, how it is looked at, and the sign of the space that she was born in.
layout(constant_id = 1) const int kappa = 0;
layout(constant_id = 2) const int mode = 0;
layout(constant_id = 3) const int born_kappa = 0;

// mode
const int NATIVE = 0, TOURIST = 1, BORN = 2;

// Kinds of Draw.shape.z
const float MESH = 0.0, BALL = 1.0, SHEET = 2.0;

// Draw.finish.z: the geodesic surface that a part's facets stand for (enum ap_form).
const int FACETS = 0, PLANE = 1, TUBE = 2, SPHERE = 3, STICK = 4;

// Draw.finish.x, on parts that are looked at fragment by fragment
const int PLAIN = 0, MATTE = 1, CLOTH = 2, WOOD = 3, POOL = 4, STRIPED = 5;

struct Draw {
    mat4 to[2];  // native: nose_from_part, twice; tourist: eye_from_part of each eye
    vec4 lamp;   // the lamp in the part's coordinates
    vec4 nose;   // the nose likewise
    vec4 color;  // linear; a is 1 where the part is lit
    vec4 shape;  // of a ball S and C of its radius; kind; image + 2·way (native-of: 1,
                 // seen the long way round her own s3)
    vec4 finish; // what it is made of; layer of its text, or −1; its form; 1: takes marks
    vec4 root;   // 1.055·color^(1/2.4); half of a stick's length over rho
};

layout(std430, set = 0, binding = 1) readonly buffer Draws {
    Draw draws[];
};
