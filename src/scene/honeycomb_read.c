#include "src/scene/honeycomb.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// {"honeycomb": …} and {"quotient": …}, and their short forms on a command line.

static const struct {
    const char *name;
    struct ap_symbol symbol;
} named[] = {{"torus", {4, 3, 4}},
             {"poincare-dodecahedral", {5, 3, 3}},
             {"seifert-weber", {5, 3, 5}},
             {"mirrored-dodecahedron", {5, 3, 4}}};
enum { NAMED = sizeof named / sizeof *named };

static enum ap_status read_whole(struct ap_error *err, const struct ap_json_at *at,
                                 const char *what, int low, int high, int *value) {
    if (!json_is_integer(at->value) || json_integer_value(at->value) < low ||
        json_integer_value(at->value) > high)
        return ap_json_fail(err, at, "expected %s, a whole number from %d to %d", what, low, high);
    *value = (int)json_integer_value(at->value);
    return AP_OK;
}

static enum ap_status read_symbol(struct ap_error *err, const struct ap_json_at *at,
                                  struct ap_honeycomb_plan *plan) {
    int n[3] = {0};
    if (!json_is_array(at->value) || json_array_size(at->value) != 3)
        return ap_json_fail(err, at, "expected a Schläfli symbol of three numbers, as [5, 3, 4]");
    for (int i = 0; i < 3; i++) {
        struct ap_json_at item = ap_json_element(at, (size_t)i);
        enum ap_status st = read_whole(err, &item, "a number of the symbol", 0, 1000, &n[i]);
        if (st)
            return st;
    }
    plan->symbol = (struct ap_symbol){n[0], n[1], n[2]};
    struct ap_error why = {""};
    if (ap_symbol_space(&why, plan->symbol, &plan->kappa))
        return ap_json_fail(err, at, "%s", why.text);
    return AP_OK;
}

static enum ap_status read_size(struct ap_error *err, const struct ap_json_at *at, const char *key,
                                double low, double high, double *value) {
    if (!ap_json_has(at, key))
        return AP_OK;
    double v;
    enum ap_status st = ap_json_number(err, at, key, &v);
    struct ap_json_at member = ap_json_member(at, key);
    if (!st && !(v >= low && v <= high))
        st = ap_json_fail(err, &member, "expected a number from %g to %g, not %g", low, high, v);
    if (!st)
        *value = v;
    return st;
}

static enum ap_status read_show(struct ap_error *err, const struct ap_json_at *at,
                                struct ap_honeycomb_look *look) {
    if (!json_is_array(at->value))
        return ap_json_fail(err, at, "expected a list of \"walls\", \"struts\", \"balls\"");
    for (size_t i = 0; i < json_array_size(at->value); i++) {
        struct ap_json_at item = ap_json_element(at, i);
        const char *word = json_string_value(item.value);
        bool *flag = !word                         ? NULL
                     : strcmp(word, "walls") == 0  ? &look->walls
                     : strcmp(word, "struts") == 0 ? &look->struts
                     : strcmp(word, "balls") == 0  ? &look->balls
                                                   : NULL;
        if (!flag)
            return ap_json_fail(err, &item, "expected \"walls\", \"struts\" or \"balls\"");
        *flag = true;
    }
    return AP_OK;
}

static enum ap_status read_look(struct ap_error *err, const struct ap_json_at *at,
                                struct ap_honeycomb_look *look) {
    *look = (struct ap_honeycomb_look){.width = 0.2, .horizon_px = 12, .budget_mib = 512};
    struct ap_json_at show = ap_json_member(at, "show");
    enum ap_status st = AP_OK;
    if (show.value)
        st = read_show(err, &show, look);
    else
        look->walls = true;
    if (!st)
        st = read_size(err, at, "width", 0.01, 0.9, &look->width);
    if (!st)
        st = read_size(err, at, "horizon_px", 0.1, 1e4, &look->horizon_px);
    if (!st)
        st = read_size(err, at, "budget_mib", 0.1, 1e5, &look->budget_mib);
    return st ? st : read_size(err, at, "edge_m", 1e-3, 1e6, &look->edge_m);
}

static enum ap_status read_pair(struct ap_error *err, const struct ap_json_at *at,
                                struct ap_face_pair *pair) {
    static const char *const keys[] = {"face", "to", "turn", "mirrored", NULL};
    static const char *const what[] = {"a face", "a face", "a turn"};
    int n[3] = {0};
    enum ap_status st = ap_json_check_keys(err, at, keys);
    for (int i = 0; i < 3 && !st; i++) {
        struct ap_json_at member = ap_json_member(at, keys[i]);
        st = read_whole(err, &member, what[i], i < 2 ? 0 : -1000, i < 2 ? AP_CELL_FACES : 1000,
                        &n[i]);
    }
    *pair = (struct ap_face_pair){n[0], n[1], n[2], false};
    if (!st && ap_json_has(at, "mirrored"))
        st = ap_json_bool(err, at, "mirrored", &pair->mirrored);
    return st;
}

static enum ap_status read_pairs(struct ap_error *err, const struct ap_json_at *at,
                                 struct ap_honeycomb_plan *plan) {
    size_t count = json_is_array(at->value) ? json_array_size(at->value) : 0;
    if (count == 0 || count > AP_CELL_FACES)
        return ap_json_fail(err, at, "expected a list of 1 to %d pairs of faces", AP_CELL_FACES);
    for (size_t i = 0; i < count; i++) {
        struct ap_json_at item = ap_json_element(at, i);
        enum ap_status st = read_pair(err, &item, &plan->pairs[i]);
        if (st)
            return st;
    }
    plan->pair_count = (int)count;
    return AP_OK;
}

static enum ap_status read_quotient(struct ap_error *err, const struct ap_json_at *at,
                                    struct ap_honeycomb_plan *plan) {
    bool by_name = ap_json_has(at, "name");
    struct ap_json_at name = ap_json_member(at, "name"), cell = ap_json_member(at, "cell");
    struct ap_json_at pairs = ap_json_member(at, "pairs");
    plan->quotient = true;
    if (by_name == ap_json_has(at, "cell") || by_name == ap_json_has(at, "pairs"))
        return ap_json_fail(err, at, "expected a \"name\", or a \"cell\" and its \"pairs\"");
    if (!by_name) {
        enum ap_status st = read_symbol(err, &cell, plan);
        return st ? st : read_pairs(err, &pairs, plan);
    }
    const char *text = json_string_value(name.value);
    for (int i = 0; text && i < NAMED; i++)
        if (strcmp(text, named[i].name) == 0) {
            plan->name = named[i].name;
            plan->symbol = named[i].symbol;
            return ap_symbol_space(err, plan->symbol, &plan->kappa);
        }
    return ap_json_fail(err, &name,
                        "expected \"torus\", \"poincare-dodecahedral\", \"seifert-weber\" or "
                        "\"mirrored-dodecahedron\"");
}

enum ap_status ap_honeycomb_plan_read(struct ap_error *err, const struct ap_json_at *at,
                                      struct ap_honeycomb_plan *plan) {
    static const char *const honeycomb_keys[] = {"symbol",     "show",       "width", "edge_m",
                                                 "horizon_px", "budget_mib", NULL};
    static const char *const quotient_keys[] = {
        "name", "cell", "pairs", "show", "width", "edge_m", "horizon_px", "budget_mib", NULL};
    *plan = (struct ap_honeycomb_plan){0};
    bool quotient = strcmp(at->key, "quotient") == 0;
    enum ap_status st = ap_json_check_keys(err, at, quotient ? quotient_keys : honeycomb_keys);
    struct ap_json_at symbol = ap_json_member(at, "symbol");
    if (!st)
        st = quotient ? read_quotient(err, at, plan) : read_symbol(err, &symbol, plan);
    return st ? st : read_look(err, at, &plan->look);
}

bool ap_scene_is_named(const char *text) {
    size_t n = strcspn(text, ",:");
    if (strncmp(text, "honeycomb:", 10) == 0)
        return true;
    for (int i = 0; i < NAMED; i++)
        if (strlen(named[i].name) == n && strncmp(text, named[i].name, n) == 0)
            return text[n] != ':';
    return false;
}

static const char *const word_keys[][2] = {
    {"horizon", "horizon_px"}, {"budget", "budget_mib"}, {"edge", "edge_m"}, {"width", "width"}};
enum { WORD_KEYS = sizeof word_keys / sizeof *word_keys };

// One word after the name: a number of the symbol, what to show, or key=value.
static bool take_word(json_t *object, json_t *symbol, json_t *show, const char *word) {
    char *end;
    long n = strtol(word, &end, 10);
    const char *equals = strchr(word, '=');
    if (symbol && *word && !*end)
        return n >= 0 && n <= 1000 && json_array_append_new(symbol, json_integer(n)) == 0;
    if (!equals)
        return (strcmp(word, "walls") == 0 || strcmp(word, "struts") == 0 ||
                strcmp(word, "balls") == 0) &&
               json_array_append_new(show, json_string(word)) == 0;
    double value = strtod(equals + 1, &end);
    for (size_t i = 0; i < WORD_KEYS; i++)
        if (strlen(word_keys[i][0]) == (size_t)(equals - word) &&
            strncmp(word, word_keys[i][0], strlen(word_keys[i][0])) == 0)
            return equals[1] && !*end && isfinite(value) &&
                   json_object_set_new(object, word_keys[i][1], json_real(value)) == 0;
    return false;
}

// Of a message about the document that a name stands for: no places in it, but the words given.
static void tell_by_words(struct ap_error *err) {
    char *from = err ? strstr(err->text, "/objects/0/") : NULL,
         *end = from ? strstr(from, ": ") : NULL;
    if (!end)
        return;
    *end = 0;
    const char *last = strrchr(from, '/') + 1, *word = "";
    for (size_t i = 0; i < WORD_KEYS; i++)
        if (strcmp(last, word_keys[i][1]) == 0)
            word = word_keys[i][0];
    size_t n = strlen(word); // shorter than the place it stands in
    memcpy(from, word, n);
    memmove(from + n, n ? ": " : "", n ? 2 : 0);
    memmove(from + n + (n ? 2 : 0), end + 2, strlen(end + 2) + 1);
}

enum ap_status ap_scene_named(struct ap_error *err, const char *text,
                              const struct ap_scene_params *params, struct ap_scene **scene) {
    bool quotient = strncmp(text, "honeycomb:", 10) != 0, good = true;
    char *copy = strdup(quotient ? text : text + 10), *rest = NULL, *bad = NULL;
    json_t *object = json_object(), *show = json_array(), *symbol = quotient ? NULL : json_array();
    json_t *root = json_object(), *objects = json_array(), *item = json_object();
    enum ap_status st = AP_OK;
    if (!copy || !object || !show || !root || !objects || !item || (!quotient && !symbol)) {
        st = ap_fail(err, AP_ENVIRONMENT, "out of memory for a scene");
        goto out;
    }
    char *word = strtok_r(copy, ",", &rest);
    if (quotient) {
        good = json_object_set_new(object, "name", json_string(word)) == 0;
        word = strtok_r(NULL, ",", &rest);
    }
    for (; word && good; word = strtok_r(NULL, ",", &rest)) {
        good = take_word(object, symbol, show, word);
        bad = word;
    }
    if (!good)
        st = ap_fail(err, AP_USAGE,
                     "--scene %s: '%s' is not understood: expected after the name " AP_SCENE_WORDS,
                     text, bad ? bad : "");
    else if (symbol && json_array_size(symbol) != 3)
        st = ap_fail(err, AP_USAGE, "--scene %s: expected honeycomb: and one of " AP_SCENE_SYMBOLS,
                     text);
    if (st)
        goto out;
    if (symbol)
        json_object_set(object, "symbol", symbol);
    if (json_array_size(show) > 0)
        json_object_set(object, "show", show);
    json_object_set(item, quotient ? "quotient" : "honeycomb", object);
    json_array_append(objects, item);
    json_array_append_new(objects, json_pack("{s:{}}", "hands"));
    json_object_set(root, "objects", objects);
    json_object_set_new(root, "background", json_string("#070a12"));
    st = ap_scene_from_json(err, text, root, params, scene);
    if (st)
        tell_by_words(err);
out:
    free(copy);
    json_decref(object);
    json_decref(show);
    json_decref(symbol);
    json_decref(item);
    json_decref(objects);
    json_decref(root);
    return st;
}
