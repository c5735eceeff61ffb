#include "src/app/play/settings.h"

#include <jansson.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "src/base/file.h"
#include "src/base/json.h"
#include "src/base/number.h"

enum { VERSION = 1 };

#define WORDS(...) ((const char *const[]){__VA_ARGS__, NULL})

static const struct ap_play_setting_info infos[AP_PLAY_SETTING_COUNT] = {
    [AP_PLAY_SPACE] = {"space", "space", "", WORDS("h3", "s3", "e3"), 0, true},
    [AP_PLAY_TABLE_EDGE] = {"table_edge_m", "table's edge", "m",
                            WORDS("0.6", "0.7", "0.8", "0.9", "1", "1.2", "1.5", "2"), 3, true},
    [AP_PLAY_WALK] = {"tracker", "body hangs on", "", WORDS("billiards", "anchor", "naive"), 0,
                      true},
    [AP_PLAY_VIEW] = {"view", "view", "", WORDS("native", "tourist"), 0, false},
    [AP_PLAY_EYE] = {"eye", "eyes open", "", WORDS("both", "left", "right"), 0, false},
    [AP_PLAY_ERROR] = {"max_error_px", "error bound", "px",
                       WORDS("0.05", "0.1", "0.25", "0.5", "1", "2", "4"), 2, true},
    [AP_PLAY_DETAIL] = {"detail", "detail", "", WORDS("auto", "full"), 0, false},
    [AP_PLAY_SPEED] = {"speed_mps", "flying speed", "m/s", WORDS("0.25", "0.5", "1", "2", "4"), 2,
                       false},
    [AP_PLAY_TURN] = {"turn_deg", "turning", "deg", WORDS("15", "30", "45", "90", "smooth"), 1,
                      false},
    [AP_PLAY_VIGNETTE] = {"vignette", "vignette while flying", "", WORDS("on", "off"), 0, false},
    [AP_PLAY_FENCE] = {"fence", "fence at the room's end", "", WORDS("on", "off"), 0, false},
    [AP_PLAY_RATE] = {"rate", "frame rate shown", "", WORDS("on", "off"), 1, false},
    [AP_PLAY_GAME] = {"game", "game", "", WORDS("free", "eight-ball", "nine-ball", "none"), 0,
                      true},
    [AP_PLAY_LINES] = {"lines", "path of the next shot", "", WORDS("off", "on"), 0, false},
};

const struct ap_play_setting_info *ap_play_setting_info(enum ap_play_setting setting) {
    return &infos[setting];
}

struct ap_play_settings ap_play_settings_standard(void) {
    struct ap_play_settings s = {{0}};
    for (int i = 0; i < AP_PLAY_SETTING_COUNT; i++)
        s.values[i] = infos[i].standard;
    return s;
}

const char *ap_play_word(const struct ap_play_settings *s, enum ap_play_setting setting) {
    return infos[setting].choices[s->values[setting]];
}

double ap_play_number(const struct ap_play_settings *s, enum ap_play_setting setting) {
    const char *word = ap_play_word(s, setting);
    double value;
    return ap_parse_double(word, strlen(word), &value) ? value : NAN;
}

bool ap_play_is(const struct ap_play_settings *s, enum ap_play_setting setting, const char *word) {
    return strcmp(ap_play_word(s, setting), word) == 0;
}

bool ap_play_choose(struct ap_play_settings *s, enum ap_play_setting setting, const char *word) {
    for (int i = 0; infos[setting].choices[i]; i++)
        if (strcmp(infos[setting].choices[i], word) == 0) {
            s->values[setting] = i;
            return true;
        }
    return false;
}

void ap_play_step(struct ap_play_settings *s, enum ap_play_setting setting, int by) {
    int count = 0;
    while (infos[setting].choices[count])
        count++;
    s->values[setting] = ((s->values[setting] + by) % count + count) % count;
}

char *ap_play_settings_path(void) {
    const char *config = getenv("XDG_CONFIG_HOME"), *home = getenv("HOME");
    if (config && config[0] == '/')
        return ap_path_join(config, "antipode/play.json");
    return home && home[0] == '/' ? ap_path_join(home, ".config/antipode/play.json") : NULL;
}

static enum ap_status read_word(struct ap_error *err, const struct ap_json_at *root,
                                enum ap_play_setting setting, struct ap_play_settings *s) {
    const struct ap_play_setting_info *info = &infos[setting];
    const char *word;
    if (!ap_json_has(root, info->key))
        return AP_OK;
    enum ap_status st = ap_json_string(err, root, info->key, &word);
    if (st || ap_play_choose(s, setting, word))
        return st;
    char list[256] = "";
    for (int i = 0; info->choices[i]; i++) {
        strncat(list, i ? ", " : "", sizeof list - strlen(list) - 1);
        strncat(list, info->choices[i], sizeof list - strlen(list) - 1);
    }
    struct ap_json_at at = ap_json_member(root, info->key);
    return ap_json_fail(err, &at, "'%.40s' is none of %s", word, list);
}

enum ap_status ap_play_settings_read(struct ap_error *err, const char *path,
                                     struct ap_play_settings *settings) {
    struct ap_play_settings s = ap_play_settings_standard();
    json_t *root = NULL;
    if (!ap_file_exists(path)) {
        *settings = s;
        return AP_OK;
    }
    enum ap_status st = ap_json_read(err, path, &root);
    if (st)
        return st;
    struct ap_json_at at = ap_json_root(root, path);
    const char *keys[AP_PLAY_SETTING_COUNT + 2] = {"antipode_play"};
    for (int i = 0; i < AP_PLAY_SETTING_COUNT; i++)
        keys[1 + i] = infos[i].key;
    double version = 0;
    st = ap_json_number(err, &at, "antipode_play", &version);
    if (!st && version != VERSION)
        st = ap_fail(err, AP_INPUT,
                     "%s: /antipode_play: version %g, this program reads version %d: move the file "
                     "away to begin anew",
                     path, version, VERSION);
    if (!st)
        st = ap_json_check_keys(err, &at, keys);
    for (int i = 0; !st && i < AP_PLAY_SETTING_COUNT; i++)
        st = read_word(err, &at, (enum ap_play_setting)i, &s);
    json_decref(root);
    if (!st)
        *settings = s;
    return st;
}

static enum ap_status make_folder(struct ap_error *err, const char *path) {
    char *folder = strdup(path);
    if (!folder)
        return ap_fail(err, AP_ENVIRONMENT, "out of memory");
    *strrchr(folder, '/') = '\0';
    enum ap_status st = ap_make_dirs(err, folder);
    free(folder);
    return st;
}

enum ap_status ap_play_settings_write(struct ap_error *err, const char *path,
                                      const struct ap_play_settings *settings) {
    enum ap_status st = make_folder(err, path);
    if (st)
        return st;
    json_t *root = json_pack("{s:i}", "antipode_play", VERSION);
    bool ok = root != NULL;
    for (int i = 0; ok && i < AP_PLAY_SETTING_COUNT; i++)
        ok = json_object_set_new(root, infos[i].key,
                                 json_string(ap_play_word(settings, (enum ap_play_setting)i))) == 0;
    char *text = ok ? json_dumps(root, JSON_INDENT(2)) : NULL;
    json_decref(root);
    if (!text)
        return ap_fail(err, AP_ENVIRONMENT, "out of memory");
    st = ap_file_write(err, path, text, strlen(text));
    free(text);
    return st;
}
