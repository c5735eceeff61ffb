// clang-format off
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>
// clang-format on
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "src/app/html.h"
#include "src/app/page.h"
#include "src/app/plots.h"
#include "src/base/file.h"
#include "tests/app/page/synth.h"

static const uint8_t RED[3] = {0xff, 0x20, 0x20};
static const char EVIL[] = "<script>alert('x')</script>\"&";

// A capture whose every text is hostile, read back from its folder.
static char *make(struct ap_space space, struct ap_capture *read) {
    char *dir = synth_folder();
    struct ap_capture c = synth_capture(dir, space, AP_VIEW_NATIVE, 4);
    synth_target(&c, EVIL, RED, (struct ap_vec3){0, 0.1, -0.8}, 0.05);
    snprintf(c.log_name, sizeof c.log_name, "%s", EVIL);
    snprintf(c.command, sizeof c.command, "antipode replay '%s'", EVIL);
    snprintf(c.tracker, sizeof c.tracker, "<b>anchor");
    snprintf(c.headset.name, sizeof c.headset.name, "%s", EVIL);
    c.interrupted = true;
    synth_write(&c);
    ap_capture_finish(&c);
    struct ap_error err = {""};
    if (ap_capture_read(&err, dir, read))
        fail_msg("%s", err.text);
    return dir;
}

static const char *const VOID_TAGS[] = {"meta", "input", "img", "br", NULL};

static bool is_void(const char *name) {
    for (const char *const *v = VOID_TAGS; *v; v++)
        if (strcmp(name, *v) == 0)
            return true;
    return false;
}

// Every tag that opens closes, in order; attributes are quoted. Scripts and styles are skipped.
static void check_nesting(const char *html) {
    char stack[64][16];
    int depth = 0;
    for (const char *p = strchr(html, '<'); p; p = strchr(p, '<')) {
        char name[16] = "";
        bool closing = p[1] == '/';
        if (p[1] == '!') {
            p++;
            continue;
        }
        sscanf(p + 1 + closing, "%15[a-z0-9]", name);
        if (!name[0])
            fail_msg("a bare '<' at \"%.40s\"", p);
        const char *end = p;
        for (bool quoted = false; *end && (quoted || *end != '>'); end++)
            quoted ^= *end == '"';
        if (!*end)
            fail_msg("a tag does not end: \"%.40s\"", p);
        if (closing) {
            if (depth == 0 || strcmp(stack[depth - 1], name) != 0)
                fail_msg("</%s> closes <%s>", name, depth ? stack[depth - 1] : "nothing");
            depth--;
        } else if (end[-1] != '/' && !is_void(name)) {
            assert_true(depth < 64);
            snprintf(stack[depth++], sizeof stack[0], "%s", name);
        }
        p = end;
        if (!closing && (strcmp(name, "script") == 0 || strcmp(name, "style") == 0)) {
            p = strstr(p, name[1] == 'c' ? "</script>" : "</style>");
            if (!p)
                fail_msg("<%s> does not end", name);
        }
    }
    if (depth != 0)
        fail_msg("<%s> is never closed", stack[depth - 1]);
}

static void check_page(const char *html, const char *escaped) {
    static const char *const never[] = {"http://",   "https://", "src=\"/", "url(",
                                        "@import",   "<link",    "<iframe", "alert('",
                                        "<b>anchor", ">nan",     "nan ",    "-nan"};
    const char *const always[] = {"<!doctype html>", "Content-Security-Policy", escaped,
                                  "interrupted", "iVBOR"};
    for (size_t i = 0; i < sizeof never / sizeof never[0]; i++) {
        const char *at = strstr(html, never[i]);
        if (at)
            fail_msg("\"%s\" in the page: \"%.60s\"", never[i], at);
    }
    for (size_t i = 0; i < sizeof always / sizeof always[0]; i++)
        if (!strstr(html, always[i]))
            fail_msg("no \"%s\" in the page", always[i]);
    check_nesting(html);
}

static void the_page_holds_itself_together(void **state) {
    (void)state;
    struct ap_capture c;
    char *dir = make((struct ap_space){-1, 0.85}, &c);
    struct ap_vergence_row *rows;
    size_t count;
    struct ap_error err = {""};
    assert_int_equal(ap_vergence_measure(&err, &c, &rows, &count), AP_OK);
    assert_int_equal(count, 2);
    assert_false(isnan(rows[0].measured_arcmin));
    rows[1].inferred_m = INFINITY;
    char *text[2];
    for (int i = 0; i < 2; i++) {
        if (ap_page_write(&err, &c, rows, count))
            fail_msg("%s", err.text);
        text[i] = synth_read_text(dir, "index.html");
    }
    assert_string_equal(text[0], text[1]);
    check_page(text[0], "&lt;script&gt;alert(&#39;x&#39;)&lt;/script&gt;&quot;&amp;");
    assert_non_null(strstr(text[0], "∞"));
    free(text[0]);
    free(text[1]);
    free(rows);
    ap_capture_finish(&c);
    synth_remove(dir);
}

static void a_page_without_anything_is_whole(void **state) {
    (void)state;
    struct ap_capture c;
    char *dir = make((struct ap_space){1, 0.6}, &c);
    c.frame_count = 0;
    c.step_count = 0;
    c.device_count = 0;
    c.target_count = 0;
    c.has_table = false;
    struct ap_error err = {""};
    if (ap_page_write(&err, &c, NULL, 0))
        fail_msg("%s", err.text);
    char *text = synth_read_text(dir, "index.html");
    check_nesting(text);
    free(text);
    ap_capture_finish(&c);
    synth_remove(dir);
}

static void the_tour_shows_all_spaces(void **state) {
    (void)state;
    struct ap_capture c[3];
    char *dir[3];
    struct ap_error err = {""};
    for (int i = 0; i < 3; i++) {
        dir[i] = make((struct ap_space){1 - i, 0.7}, &c[i]);
        struct ap_vergence_row *rows;
        size_t count;
        assert_int_equal(ap_vergence_measure(&err, &c[i], &rows, &count), AP_OK);
        assert_int_equal(ap_vergence_write(&err, &c[i], rows, count), AP_OK);
        free(rows);
    }
    char *path = synth_path(dir[0], "tour.html");
    char *argv[] = {"page", "--out", path, dir[0], dir[1], dir[2], NULL};
    if (ap_command_page.run(&err, 6, argv))
        fail_msg("%s", err.text);
    char *text = synth_read_text(dir[0], "tour.html");
    check_page(text, "&lt;b&gt;anchor");
    assert_non_null(strstr(text, "spherical space"));
    assert_non_null(strstr(text, "flat space"));
    assert_non_null(strstr(text, "hyperbolic space"));
    assert_non_null(strstr(text, "6 pairs"));
    free(text);
    char *lost[] = {"page", dir[0], NULL};
    assert_int_equal(ap_command_page.run(&err, 2, lost), AP_USAGE);
    free(path);
    for (int i = 0; i < 3; i++) {
        ap_capture_finish(&c[i]);
        synth_remove(dir[i]);
    }
}

static void texts_are_escaped(void **state) {
    (void)state;
    char *made = NULL;
    size_t size;
    FILE *f = open_memstream(&made, &size);
    assert_non_null(f);
    // Cut, overlong and surrogate sequences, a control character, and what is good.
    ap_html_text(f, "é€𝄞<&>'\"\xc3 \xc0\xaf \xed\xa0\x80 \xf5\x01");
    fclose(f);
#define BAD "\xef\xbf\xbd"
    assert_string_equal(made,
                        "é€𝄞&lt;&amp;&gt;&#39;&quot;" BAD " " BAD BAD " " BAD BAD BAD " " BAD BAD);
    free(made);
}

// With the exact product of the four translations in `naive`, and nothing in the others.
static void trackers_bring_the_hand_back(void **state) {
    (void)state;
    static const struct ap_space spaces[] = {{-1, 0.85}, {0, 1}, {1, 0.573}, {-1, 3}, {1, 2}};
    for (int s = 0; s < 5; s++)
        for (int t = 0; t < 3; t++) {
            enum ap_tracker_kind kind = (enum ap_tracker_kind)t;
            struct ap_coherence w;
            struct ap_error err = {""};
            if (ap_coherence_walk(&err, spaces[s], kind, &w))
                fail_msg("%s", err.text);
            double turn = w.turn_deg[AP_LOOP_STEPS], offset = w.offset_mm[AP_LOOP_STEPS];
            double theta = AP_LOOP_SIDE_M / spaces[s].rho_m;
            print_message("%s %.3g m %s: %.4g mm, %.4g deg, defect %.2g (tolerance 1e-12)\n",
                          ap_space_name(spaces[s]), spaces[s].rho_m, ap_tracker_kind_name(kind),
                          offset, turn, w.defect);
            if (!(w.defect < 1e-12))
                fail_msg("defect %g, tolerance 1e-12", w.defect);
            bool drifts = kind == AP_TRACKER_NAIVE && spaces[s].kappa != 0;
            double expected = drifts ? theta * theta * 180 / M_PI : 0;
            if (!(fabs(turn - expected) <= 0.15 * expected + 1e-9))
                fail_msg("turn %g degrees, expected about %g", turn, expected);
            if (!drifts && !(offset < 1e-9))
                fail_msg("offset %g mm, expected 0", offset);
        }
}

// A world whose cells are millimetres wide has a page too, without that chart and without NaN.
static void a_radius_of_a_millimetre_has_no_loop(void **state) {
    (void)state;
    for (int i = 0; i < 2; i++) {
        struct ap_space space = {-1, i ? 1e-3 : 0.05};
        struct ap_error err = {""};
        char *text = NULL;
        size_t size = 0;
        FILE *f = open_memstream(&text, &size);
        assert_int_equal(ap_svg_coherence(&err, f, space), AP_OK);
        fclose(f);
        assert_non_null(strstr(text, "too large for doubles"));
        assert_null(strstr(text, "nan"));
        assert_null(strstr(text, "<svg"));
        free(text);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(texts_are_escaped),
        cmocka_unit_test(trackers_bring_the_hand_back),
        cmocka_unit_test(a_radius_of_a_millimetre_has_no_loop),
        cmocka_unit_test(the_page_holds_itself_together),
        cmocka_unit_test(a_page_without_anything_is_whole),
        cmocka_unit_test(the_tour_shows_all_spaces),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
