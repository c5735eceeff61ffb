#include "sim_hmd/core/instance.h"
#include "sim_hmd/core/pacer.h"

// XR_KHR_convert_timespec_time: XrTime and the machine's CLOCK_MONOTONIC.

XrResult XRAPI_CALL xrConvertTimespecTimeToTimeKHR(XrInstance handle,
                                                   const struct timespec *timespec, XrTime *time) {
    SIM_LOCKED;
    struct sim_instance *instance = sim_instance_get(handle);
    if (!instance)
        return XR_ERROR_HANDLE_INVALID;
    if (!timespec || !time)
        return XR_ERROR_VALIDATION_FAILURE;
    int64_t ns;
    if (timespec->tv_nsec < 0 || timespec->tv_nsec > 999999999 ||
        __builtin_mul_overflow((int64_t)timespec->tv_sec, (int64_t)1000000000, &ns) ||
        __builtin_add_overflow(ns, timespec->tv_nsec, &ns) ||
        __builtin_sub_overflow(ns, instance->epoch_ns - SIM_FIRST_TIME_NS, &ns) || ns <= 0)
        return XR_ERROR_TIME_INVALID;
    *time = ns;
    return XR_SUCCESS;
}

XrResult XRAPI_CALL xrConvertTimeToTimespecTimeKHR(XrInstance handle, XrTime time,
                                                   struct timespec *timespec) {
    SIM_LOCKED;
    struct sim_instance *instance = sim_instance_get(handle);
    if (!instance)
        return XR_ERROR_HANDLE_INVALID;
    if (!timespec)
        return XR_ERROR_VALIDATION_FAILURE;
    int64_t ns;
    if (time <= 0 || __builtin_add_overflow(time, instance->epoch_ns - SIM_FIRST_TIME_NS, &ns) ||
        ns < 0)
        return XR_ERROR_TIME_INVALID;
    timespec->tv_sec = ns / 1000000000;
    timespec->tv_nsec = ns % 1000000000;
    return XR_SUCCESS;
}

const struct sim_function sim_functions_KHR_convert_timespec_time[] = {
    SIM_FUNCTION(xrConvertTimespecTimeToTimeKHR),
    SIM_FUNCTION(xrConvertTimeToTimespecTimeKHR),
    {0},
};
