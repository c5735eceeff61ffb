#include "src/render/pass/kind.h"

enum ap_pipeline_kind ap_pipeline_for(const struct ap_part *part, bool plain) {
    bool closed = part->one_sided || part->kind == AP_PART_BALL || part->kind == AP_PART_STICK;
    if (part->lit && part->finish == AP_FINISH_MATTE && closed && !plain)
        return part->kind == AP_PART_BALL ? AP_PIPELINE_MATTE_BALLS
               : part->form == AP_FORM_PLANE && part->kind == AP_PART_SOLID ? AP_PIPELINE_PLANES
                                                                            : AP_PIPELINE_MATTE;
    if (part->lit && part->finish != AP_FINISH_PLAIN && !plain)
        return part->kind == AP_PART_BALL    ? AP_PIPELINE_BALLS
               : part->kind == AP_PART_STICK ? AP_PIPELINE_STICKS
                                             : AP_PIPELINE_SHEETS;
    return closed ? AP_PIPELINE_CLOSED : AP_PIPELINE_TWOSIDED;
}

bool ap_pipeline_is_guarded(enum ap_pipeline_kind pipeline) {
    return pipeline >= AP_PIPELINE_GUARD && pipeline < AP_PIPELINE_GUARD_END;
}

static bool is_matte(enum ap_pipeline_kind pipeline) {
    return pipeline == AP_PIPELINE_MATTE_BALLS || pipeline == AP_PIPELINE_MATTE ||
           pipeline == AP_PIPELINE_PLANES;
}

bool ap_pipeline_is_closed(enum ap_pipeline_kind pipeline) {
    return ap_pipeline_is_guarded(pipeline)
               ? (pipeline - AP_PIPELINE_GUARD) & AP_GUARD_CLOSED
               : pipeline == AP_PIPELINE_CLOSED || is_matte(pipeline) ||
                     pipeline == AP_PIPELINE_BALLS || pipeline == AP_PIPELINE_STICKS;
}

enum ap_pipeline_kind ap_pipeline_looked_at(enum ap_pipeline_kind pipeline, bool one_sided) {
    unsigned draws = is_matte(pipeline)               ? AP_GUARD_MATTE
                     : pipeline == AP_PIPELINE_BALLS  ? AP_GUARD_BALLS
                     : pipeline == AP_PIPELINE_STICKS ? AP_GUARD_STICKS
                     : pipeline == AP_PIPELINE_SHEETS ? AP_GUARD_SHEETS
                                                      : 0;
    return AP_PIPELINE_GUARD + draws +
           (one_sided && ap_pipeline_is_closed(pipeline) ? AP_GUARD_CLOSED : 0);
}

enum ap_pipeline_kind ap_pipeline_exact(enum ap_pipeline_kind pipeline) {
    if (!ap_pipeline_is_guarded(pipeline))
        pipeline = ap_pipeline_looked_at(pipeline, true);
    return AP_PIPELINE_GUARD + ((pipeline - AP_PIPELINE_GUARD) | AP_GUARD_EXACT);
}
