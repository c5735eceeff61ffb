#include "src/device/inputlog.h"
#include "tests/device/memory_file.h"
#include "tests/device/mutate.h"

static void require(bool ok, const char *what) {
    if (ok)
        return;
    fprintf(stderr, "broken: %s\n", what);
    abort();
}

// What a log that was read promises to everybody behind.
static void check_log(const struct ap_inputlog *log) {
    int64_t end = ap_inputlog_end_ns(log);
    for (int c = 0; c < ap_inputlog_channel_count(log); c++) {
        struct ap_input_channel channel = ap_inputlog_channel(log, c);
        require(ap_inputlog_find(log, channel.device, channel.path) == c, "one channel a path");
        require(strlen(channel.path) < AP_INPUT_PATH_MAX, "length of a path");
        float v[2];
        require(ap_inputlog_at(log, c, end, v), "a value at the end");
        for (int i = 0; i < 2; i++)
            require(v[i] >= -1 && v[i] <= 1, "-1 to 1");
        ap_inputlog_at(log, c, INT64_MIN, v);
        ap_inputlog_at(log, c, end / 2, v);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t len) {
    struct memory_file file = memory_file(bytes, len);
    const char *paths[] = {file.path, file.path};
    for (size_t count = 1; count <= 2; count++) {
        struct ap_error err = {""};
        struct ap_inputlog *log = NULL;
        if (ap_inputlog_load(&err, paths, count, &log))
            require(err.text[0] && !log, "a sentence with the error");
        else
            check_log(log);
        ap_inputlog_destroy(log);
    }
    close(file.fd);
    return 0;
}

#ifndef ANTIPODE_LIBFUZZER
int main(int argc, char **argv) {
    static const char *const seeds[] = {
        "t_ns,device,path,value,value2\n# x\n0,left,/input/trigger/value,0.7\n"
        "1500000000,right,/input/thumbstick,0.5,-0.2\n1500000001,right,/input/a/click,1\r\n",
        "-1,gamepad,/input/dpad_up/click,1\n4,head,/input/system/click,0\n"
        "4,treadmill,/input/x,1e-3\n",
        "{\"schema\":[[0,{\"handedness\":\"right\",\"hasGamepad\":true,\"numButtons\":5,"
        "\"numAxes\":4}],[1,{}]],\"frames\":[[5,0,0,0,0,0,0,1,[0,0,0,0,0,0,0,1,[[0,1,0.5],[0,0,0],"
        "null,[1,1,1],[1,0,1],0,0,0.5,-1]]],[6.1,0,0,0,0,0,0,1,[1,0,0,0,0,0,0,1]]]}",
        "\xef\xbb\xbf\r\n", ""};
    static const char *const words[] = {"\n",      "\r\n",  ",",
                                        "/",       "#",     "nan",
                                        "-",       "1e308", "9223372036854775807",
                                        "0",       "1",     "left",
                                        "/input",  "click", "_",
                                        "value",   "pose",  "\xef\xbb\xbf",
                                        "1e-9",    "t_ns",  "right",
                                        "-0.5",    "0.5",   ".",
                                        "/input/", "4"};
    return mutate_run(seeds, sizeof seeds / sizeof *seeds, words, sizeof words / sizeof *words,
                      argc > 1 ? atoi(argv[1]) : 8000);
}
#endif
