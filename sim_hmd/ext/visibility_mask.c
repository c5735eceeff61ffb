#include "sim_hmd/core/session.h"
#include "src/device/headsets/hidden_area.h"

// XR_KHR_visibility_mask: the profile's hidden area. It never changes.

static XrResult kind_of(XrVisibilityMaskTypeKHR type, enum ap_mask_kind *kind) {
    switch (type) {
    case XR_VISIBILITY_MASK_TYPE_HIDDEN_TRIANGLE_MESH_KHR:
        *kind = AP_MASK_HIDDEN;
        return XR_SUCCESS;
    case XR_VISIBILITY_MASK_TYPE_VISIBLE_TRIANGLE_MESH_KHR:
        *kind = AP_MASK_VISIBLE;
        return XR_SUCCESS;
    case XR_VISIBILITY_MASK_TYPE_LINE_LOOP_KHR:
        *kind = AP_MASK_OUTLINE;
        return XR_SUCCESS;
    default:
        return XR_ERROR_VALIDATION_FAILURE;
    }
}

static XrResult fill(const struct ap_mask *mask, XrVisibilityMaskKHR *out) {
    out->vertexCountOutput = mask->vertex_count;
    out->indexCountOutput = mask->index_count;
    // A capacity of zero asks for both counts, whatever the other is.
    if (!out->vertexCapacityInput || !out->indexCapacityInput)
        return XR_SUCCESS;
    if (!out->vertices || !out->indices)
        return XR_ERROR_VALIDATION_FAILURE;
    if (out->vertexCapacityInput < mask->vertex_count ||
        out->indexCapacityInput < mask->index_count)
        return XR_ERROR_SIZE_INSUFFICIENT;
    for (uint32_t i = 0; i < mask->vertex_count; i++)
        out->vertices[i] = (XrVector2f){(float)mask->vertex[i][0], (float)mask->vertex[i][1]};
    for (uint32_t i = 0; i < mask->index_count; i++)
        out->indices[i] = mask->index[i];
    return XR_SUCCESS;
}

XrResult XRAPI_CALL xrGetVisibilityMaskKHR(XrSession handle, XrViewConfigurationType views,
                                           uint32_t view, XrVisibilityMaskTypeKHR type,
                                           XrVisibilityMaskKHR *out) {
    SIM_LOCKED;
    struct sim_session *session;
    XrResult result = sim_session_get(handle, &session);
    if (result != XR_SUCCESS)
        return result;
    if (views != XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO)
        return XR_ERROR_VIEW_CONFIGURATION_TYPE_UNSUPPORTED;
    enum ap_mask_kind kind;
    result = kind_of(type, &kind);
    if (result != XR_SUCCESS)
        return result;
    if (view > 1 || !sim_is(out, XR_TYPE_VISIBILITY_MASK_KHR))
        return XR_ERROR_VALIDATION_FAILURE;
    struct ap_mask mask;
    ap_hidden_area_mask(&session->instance->settings.profile.eye[view], kind, &mask);
    return fill(&mask, out);
}

const struct sim_function sim_functions_KHR_visibility_mask[] = {
    SIM_FUNCTION(xrGetVisibilityMaskKHR),
    {0},
};
