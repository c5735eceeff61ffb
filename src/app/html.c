#include "src/app/html.h"

#include <inttypes.h>
#include <math.h>
#include <png.h>
#include <stdlib.h>
#include <string.h>

#include "src/base/file.h"
#include "src/base/utf8.h"
#include "src/image/image.h"

static enum ap_status no_memory(struct ap_error *err) {
    return ap_fail(err, AP_ENVIRONMENT, "out of memory");
}

// --- text

void ap_html_text(FILE *f, const char *text) {
    for (const unsigned char *t = (const unsigned char *)text; *t;) {
        int n = ap_utf8_length((const char *)t);
        switch (*t) {
        case '&':
            fputs("&amp;", f);
            break;
        case '<':
            fputs("&lt;", f);
            break;
        case '>':
            fputs("&gt;", f);
            break;
        case '"':
            fputs("&quot;", f);
            break;
        case '\'':
            fputs("&#39;", f);
            break;
        default:
            if (n == 0 || *t < 0x20 || *t == 0x7f)
                fputs("\xef\xbf\xbd", f);
            else
                fwrite(t, 1, (size_t)n, f);
        }
        t += n ? n : 1;
    }
}

static void write_base64(FILE *f, const unsigned char *bytes, size_t len) {
    static const char digit[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (size_t i = 0; i < len; i += 3) {
        size_t left = len - i;
        unsigned v = (unsigned)bytes[i] << 16 | (left > 1 ? (unsigned)bytes[i + 1] << 8 : 0) |
                     (left > 2 ? (unsigned)bytes[i + 2] : 0);
        char four[4] = {digit[v >> 18], digit[v >> 12 & 63], left > 1 ? digit[v >> 6 & 63] : '=',
                        left > 2 ? digit[v & 63] : '='};
        fwrite(four, 1, 4, f);
    }
}

// --- what the page says

const char *ap_html_space_title(struct ap_space space) {
    return space.kappa > 0 ? "spherical space" : space.kappa ? "hyperbolic space" : "flat space";
}

void ap_html_space_text(FILE *f, struct ap_space space) {
    if (space.kappa > 0)
        fputs("<p>In spherical space there is less room than you are used to. Lines that set out "
              "side by side close in on each other, the rim of a circle falls short, and three "
              "square corners already make a whole table: a triangle, each edge exactly as long as "
              "an edge of the real, square table in the room. What moves away from you shrinks "
              "only for a quarter of the way round the world; then it grows again, until, at the "
              "antipode, it fills the sky. And every line comes back, so that you see things "
              "twice: the short way, and from behind, the long way round.</p>\n",
              f);
    else if (space.kappa < 0)
        fputs("<p>In hyperbolic space there is more room than you are used to. Lines that set out "
              "side by side drift apart, the rim of a circle is longer than it should be, and it "
              "takes five square corners to close a table: a pentagon, each edge exactly as long "
              "as an edge of the real, square table in the room. Once round the real table brings "
              "you past four of the five edges; go on, and the fifth is there. Whatever moves away "
              "shrinks fast, because the space between you and it widens at every step.</p>\n",
              f);
    else
        fputs("<p>This is the space that we live in, drawn by the same machinery as the curved "
              "ones, for comparison. The virtual table is a square, like the real one, and lies "
              "exactly where the real one stands.</p>\n",
              f);
}

void ap_html_view_text(FILE *f, struct ap_space space, enum ap_view_mode view, double ipd_m) {
    if (view == AP_VIEW_NATIVE) {
        fputs("<p>The <b>native</b> view shows the world as somebody sees it who grew up there: "
              "each thing stands in its true direction and at its true distance from the nose, and "
              "the two eyes agree about that.</p>\n",
              f);
        return;
    }
    if (view == AP_VIEW_BORN) {
        fputs(
            "<p>The <b>native-of</b> view shows the world as somebody sees it who was born in "
            "another space: each thing stands in its true direction and at its true distance from "
            "her nose, but in the space that her eyes have learned, and from there each eye looks "
            "at it.</p>\n",
            f);
        return;
    }
    fputs("<p>The <b>tourist</b> view gives each eye the light that reaches it through the curved "
          "space. A visitor from a flat world misreads it: ",
          f);
    if (space.kappa < 0)
        fprintf(f,
                "the eyes must always converge, and however far a thing is, it seems no farther "
                "than %.2f m.</p>\n",
                ipd_m / 2 / sinh(ipd_m / 2 / space.rho_m));
    else if (space.kappa > 0)
        fprintf(f,
                "past a quarter of the way round, %.2f m, the lines of sight part, and things "
                "seem to lie beyond infinity.</p>\n",
                M_PI / 2 * space.rho_m);
    else
        fputs("but here, in a flat one, there is nothing to misread.</p>\n", f);
}

static const char STYLE[] =
    ":root{--bg:#0e1116;--card:#161a21;--line:#272d37;--text:#d9dde3;--dim:#8f98a5;--head:#f4f1ea;"
    "--amber:#f0b45b;--teal:#5bc0be;--violet:#b39cf5}\n"
    "*{box-sizing:border-box}\n"
    "html{background:var(--bg);color:var(--text);font:16px/1.6 system-ui,-apple-system,\"Segoe UI\","
    "Roboto,\"DejaVu Sans\",sans-serif;-webkit-text-size-adjust:100%}\n"
    "body{margin:0}\nmain{max-width:1120px;margin:0 auto;padding:0 24px 72px}\n"
    "header{padding:64px 0 12px}\n"
    "h1,h2,h3{font-family:\"Iowan Old Style\",\"Palatino Linotype\",Palatino,Georgia,\"DejaVu "
    "Serif\",serif;color:var(--head);font-weight:500;line-height:1.2;margin:0}\n"
    "h1{font-size:clamp(2rem,5vw,3.2rem);letter-spacing:-.01em}\n"
    "h2{font-size:1.55rem;margin:56px 0 14px}\nh3{font-size:1.15rem;margin:20px 0 8px}.card h3{margin-top:0}\n"
    "p{margin:0 0 1em;max-width:72ch}\nb{color:var(--head)}\n"
    ".sub{color:var(--dim);margin:12px 0 0}.sub span+span::before{content:\"·\";margin:0 .6em}\n"
    ".banner{border:1px solid #7a5a22;background:#2a2112;color:#f6d59b;border-radius:10px;"
    "padding:12px 18px;margin:24px 0 0}\n"
    ".viewer{margin:0;min-width:0}.viewer canvas{display:block;width:100%;max-height:76vh;"
    "object-fit:contain;background:#000;border-radius:12px;border:1px solid var(--line)}\n"
    ".viewer figcaption,.note{color:var(--dim);font-size:.85rem;margin-top:6px}\n"
    ".solo{max-width:720px;margin:0 auto}\n"
    ".row{margin-top:12px;display:grid;grid-template-columns:repeat(auto-fit,minmax(280px,1fr));gap:20px}\n"
    ".controls{display:flex;flex-wrap:wrap;gap:10px 14px;align-items:center;justify-content:center;"
    "margin:18px 0 8px}\n"
    ".controls button{font:inherit;font-size:.9rem;color:var(--text);background:var(--card);"
    "border:1px solid var(--line);border-radius:999px;padding:5px 15px;cursor:pointer}\n"
    ".controls button:hover{border-color:var(--amber)}\n"
    ".controls button[aria-pressed=true]{background:var(--amber);border-color:var(--amber);"
    "color:#1b1408}\n"
    ".controls input{flex:1 1 220px;max-width:420px;accent-color:var(--amber)}\n"
    ".controls button:focus-visible,.controls input:focus-visible,.thumbs button:focus-visible"
    "{outline:2px solid var(--teal);outline-offset:2px}\n"
    ".card{background:var(--card);border:1px solid var(--line);border-radius:14px;"
    "padding:20px 22px;margin:0 0 20px}\n"
    ".card svg,.plain svg{display:block;width:100%;height:auto}\n"
    ".row .sub{margin:0 0 10px;font-size:.85rem}\n"
    "svg text{font:12px system-ui,\"DejaVu Sans\",sans-serif;fill:#aab2be}\n"
    "svg text.t{font-size:13px;fill:#e6e8ec}\n"
    ".thumbs{display:grid;grid-template-columns:repeat(auto-fill,minmax(112px,1fr));gap:8px}\n"
    ".thumbs button{padding:0;border:1px solid var(--line);border-radius:8px;overflow:hidden;"
    "background:#000;cursor:pointer;line-height:0}\n"
    ".thumbs button[aria-current=true]{border-color:var(--amber);box-shadow:0 0 0 1px var(--amber)}"
    "\n.thumbs img{width:100%;height:auto}\n"
    ".scroll{overflow:auto;max-height:440px;border:1px solid var(--line);border-radius:12px}\n"
    "table{border-collapse:collapse;width:100%;font-size:.88rem;font-variant-numeric:tabular-nums}"
    "\nth,td{padding:6px 14px;text-align:right;white-space:nowrap;"
    "border-bottom:1px solid var(--line)}\n"
    "th{color:var(--dim);font-weight:500;position:sticky;top:0;background:var(--card)}\n"
    "th:first-child,td:first-child,.l{text-align:left!important}\ntr:last-child td{border-bottom:0}"
    "\n.dot{display:inline-block;width:.72em;height:.72em;border-radius:50%;margin-right:.6em}\n"
    "dl{display:grid;grid-template-columns:max-content 1fr;gap:4px 24px;margin:0}"
    "dt{color:var(--dim)}dd{margin:0;overflow-wrap:anywhere}\n"
    "pre{background:#0a0c10;border:1px solid var(--line);border-radius:10px;padding:14px 16px;"
    "overflow:auto;font:13px/1.5 ui-monospace,\"DejaVu Sans Mono\",monospace;white-space:pre-wrap;"
    "overflow-wrap:anywhere}\n"
    "details{margin-top:16px}summary{cursor:pointer;color:var(--dim);margin-bottom:10px}\n"
    "footer{color:var(--dim);font-size:.85rem;margin-top:56px}\n"
    "@media (max-width:600px){main{padding:0 14px 48px}header{padding-top:36px}"
    "th,td{padding:5px 8px}}\n";

// One controller for all viewers of the page; `at` runs from 0 to 1, so that walks of different
// lengths stay at the same moment.
static const char SCRIPT[] =
    "(()=>{'use strict';\n"
    "const $=(s,e=document)=>[...e.querySelectorAll(s)],one=s=>document.querySelector(s);\n"
    "const sets=$('.viewer').map(el=>({el,canvas:el.querySelector('canvas'),"
    "cap:el.querySelector('figcaption'),shift:+el.dataset.shift,"
    "frames:JSON.parse(el.querySelector('script').textContent).map(([n,t,...e])=>({n,t,"
    "eye:e.map(src=>{const i=new Image();i.src='data:image/png;base64,'+src;i.onload=()=>draw();"
    "return i})}))})).filter(s=>s.frames.length);\n"
    "const slider=one('#at');if(!sets.length||!slider)return;\n"
    "const most=Math.max(...sets.map(s=>s.frames.length));slider.max=most-1;\n"
    "let k=0,mode='left',swap=0,player=0,wiggler=0;\n"
    "const tint=document.createElement('canvas');\n"
    "function eye(s,i,color,gray){tint.width=i.naturalWidth;tint.height=i.naturalHeight;"
    "const c=tint.getContext('2d');if(gray)c.filter='grayscale(1)';c.drawImage(i,0,0);"
    "c.filter='none';c.globalCompositeOperation='multiply';c.fillStyle=color;"
    "c.fillRect(0,0,tint.width,tint.height);return tint}\n"
    "function one_set(s){const f=s.frames[Math.round(k*(s.frames.length-1)/Math.max(1,most-1))],"
    "[l,r]=f.eye;if(!l.complete||!r.complete||!l.naturalWidth||!r.naturalWidth)return;"
    "const c=s.canvas,x=c.getContext('2d'),w=l.naturalWidth,h=l.naturalHeight;"
    "const pair=mode==='pair',both=mode==='anaglyph'||mode==='wiggle',"
    "m=both?Math.round(s.shift*w):0,a=-Math.max(m,0),b=Math.min(m,0);"
    "c.width=pair?2*w:w-Math.abs(m);c.height=h;"
    "if(mode==='anaglyph'){x.drawImage(eye(s,l,'#f00',1),a,0);x.globalCompositeOperation='lighter';"
    "x.drawImage(eye(s,r,'#0ff',0),b,0)}"
    "else if(pair){x.drawImage(r,0,0,w,h);x.drawImage(l,w,0,w,h)}"
    "else if(mode==='right'||(mode==='wiggle'&&swap))x.drawImage(r,both?b:0,0);"
    "else x.drawImage(l,a,0);"
    "s.cap.textContent='frame '+f.n+', '+f.t.toFixed(2)+' s'}\n"
    "function draw(){sets.forEach(one_set);slider.value=k;"
    "$('.thumbs button').forEach((b,i)=>b.setAttribute('aria-current',i===k))}\n"
    "function go(n){k=(n+most)%most;draw()}\n"
    "function set(m){mode=m;$('[data-mode]').forEach(b=>b.setAttribute('aria-pressed',"
    "b.dataset.mode===m));clearInterval(wiggler);wiggler=0;"
    "if(m==='wiggle')wiggler=setInterval(()=>{swap^=1;draw()},170);draw()}\n"
    "function play(){const b=one('#play');if(player){clearInterval(player);player=0;"
    "b.textContent='▶ play'}else{player=setInterval(()=>go(k+1),260);b.textContent='❚❚ pause'}}\n"
    "$('[data-mode]').forEach(b=>b.onclick=()=>set(b.dataset.mode));\n"
    "slider.oninput=()=>{k=+slider.value;draw()};one('#play').onclick=play;\n"
    "const thumbs=one('.thumbs');if(thumbs)sets[0].frames.forEach((f,i)=>{"
    "const b=document.createElement('button'),m=new Image();m.src=f.eye[0].src;m.alt='frame '+f.n;"
    "b.title='frame '+f.n;b.append(m);b.onclick=()=>{go(i);one('.viewer').scrollIntoView({block:"
    "'center',behavior:'smooth'})};thumbs.append(b)});\n"
    "addEventListener('keydown',e=>{if(e.target===slider)return;if(e.key==='ArrowRight')go(k+1);"
    "if(e.key==='ArrowLeft')go(k-1)});\nset('left')})();\n";

void ap_html_begin(FILE *f, const char *title) {
    fputs("<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
          "<meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\n"
          "<meta name=\"color-scheme\" content=\"dark\">\n"
          // Whatever slips through the escaping: nothing may be loaded, and no markup that came
          // with a name can call home.
          "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; "
          "img-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'\">\n<title>",
          f);
    ap_html_text(f, title);
    fprintf(f, "</title>\n<style>\n%s</style>\n</head>\n<body>\n<main>\n", STYLE);
}

void ap_html_end(FILE *f) {
    fprintf(f,
            "<footer>Made by antipode.</footer>\n</main>\n<script>\n%s</script>\n</body>\n"
            "</html>\n",
            SCRIPT);
}

void ap_html_controls(FILE *f) {
    static const char *const modes[] = {"left", "right", "wiggle", "anaglyph", "pair"};
    static const char *const labels[] = {"left eye", "right eye", "wiggle", "red-cyan",
                                         "cross-eyed"};
    fputs("<div class=\"controls\"><button id=\"play\" type=\"button\">▶ play</button>"
          "<input id=\"at\" type=\"range\" min=\"0\" max=\"0\" value=\"0\" "
          "aria-label=\"frame\">",
          f);
    for (int i = 0; i < 5; i++)
        fprintf(f, "<button type=\"button\" data-mode=\"%s\" aria-pressed=\"%s\">%s</button>",
                modes[i], i ? "false" : "true", labels[i]);
    fputs("</div>\n", f);
}

// --- the viewer

struct shot {
    int64_t frame, t_ns;
    unsigned char *png[2];
    size_t len[2];
};

static enum ap_status encode(struct ap_error *err, const struct ap_image *image,
                             unsigned char **bytes, size_t *len) {
    png_image png = {.version = PNG_IMAGE_VERSION,
                     .width = image->width,
                     .height = image->height,
                     .format = PNG_FORMAT_RGB};
    png_alloc_size_t room = PNG_IMAGE_PNG_SIZE_MAX(png);
    unsigned char *made = malloc(room);
    if (!made)
        return no_memory(err);
    if (!png_image_write_to_memory(&png, made, &room, 0, image->rgb, 0, NULL)) {
        free(made);
        return ap_fail(err, AP_ENVIRONMENT, "a picture cannot be packed: %s", png.message);
    }
    unsigned char *exact = realloc(made, room);
    *bytes = exact ? exact : made;
    *len = room;
    return AP_OK;
}

// A small picture's file is taken as it is; one that says in its head that it is wider is shrunk.
static bool is_small_png(const unsigned char *bytes, size_t len, uint32_t width_px) {
    static const unsigned char head[] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n', 0, 0, 0, 13};
    enum { WIDTH_AT = 16 };
    if (len < WIDTH_AT + 4 || memcmp(bytes, head, sizeof head) != 0)
        return false;
    const unsigned char *w = bytes + WIDTH_AT;
    return ((uint32_t)w[0] << 24 | (uint32_t)w[1] << 16 | (uint32_t)w[2] << 8 | w[3]) <= width_px;
}

// Left as it is where the picture is missing: png stays NULL. The pictures have been read as a
// whole before (ap_pictures_write).
static enum ap_status load_eye(struct ap_error *err, const char *path, uint32_t width_px,
                               unsigned char **bytes, size_t *len) {
    enum { LARGEST_BYTES = 64 << 20 };
    struct ap_image image = {0}, small = {0};
    char *file;
    size_t size;
    if (!ap_file_exists(path))
        return AP_OK;
    enum ap_status st = ap_file_read(err, path, LARGEST_BYTES, &file, &size);
    if (!st && is_small_png((unsigned char *)file, size, width_px)) {
        *bytes = (unsigned char *)file;
        *len = size;
        return AP_OK;
    }
    if (!st) {
        free(file);
        st = ap_png_read(err, path, &image);
    }
    if (st)
        return st;
    uint32_t width = image.width < width_px ? image.width : width_px;
    uint32_t height = (uint32_t)((uint64_t)image.height * width / image.width);
    st = ap_image_shrink(err, &image, width, height ? height : 1, &small);
    if (!st)
        st = encode(err, &small, bytes, len);
    ap_image_finish(&image);
    ap_image_finish(&small);
    return st;
}

static enum ap_status load_shot(struct ap_error *err, const struct ap_capture *c, size_t k,
                                uint32_t width_px, struct shot *shot) {
    enum ap_status st = AP_OK;
    shot->frame = c->frames[k].frame;
    shot->t_ns = c->frames[k].t_ns - c->frames[0].t_ns;
    for (int e = 0; e < 2 && !st; e++) {
        char *path = ap_capture_picture_path(c, shot->frame, e ? "right.png" : "left.png");
        st = path ? load_eye(err, path, width_px, &shot->png[e], &shot->len[e]) : no_memory(err);
        free(path);
    }
    return st;
}

// Index i of n, evenly chosen among `of`, first and last included.
static size_t choose(size_t i, size_t n, size_t of) {
    return n > 1 ? i * (of - 1) / (n - 1) : 0;
}

static size_t shots_size(const struct shot *shots, size_t n, size_t of) {
    size_t sum = 0;
    for (size_t i = 0; i < n; i++) {
        const struct shot *s = &shots[choose(i, n, of)];
        sum += (s->len[0] + s->len[1]) / 3 * 4;
    }
    return sum;
}

static void write_shots(FILE *f, const struct shot *shots, size_t n, size_t of) {
    bool first = true;
    for (size_t i = 0; i < n; i++) {
        const struct shot *s = &shots[choose(i, n, of)];
        if (!s->png[0] || !s->png[1])
            continue;
        fprintf(f, "%s\n[%" PRId64 ",%.4f,\"", first ? "" : ",", s->frame, (double)s->t_ns / 1e9);
        write_base64(f, s->png[0], s->len[0]);
        fputs("\",\"", f);
        write_base64(f, s->png[1], s->len[1]);
        fputs("\"]", f);
        first = false;
    }
}

enum ap_status ap_html_viewer_write(struct ap_error *err, FILE *f, const struct ap_capture *capture,
                                    const struct ap_html_viewer *viewer) {
    enum { SHOTS_MAX = 48 };
    struct shot shots[SHOTS_MAX] = {{0}};
    size_t n = capture->frame_count < SHOTS_MAX ? capture->frame_count : SHOTS_MAX, fit = n;
    enum ap_status st = AP_OK;
    for (size_t i = 0; i < n && !st; i++)
        st = load_shot(err, capture, choose(i, n, capture->frame_count), viewer->width_px,
                       &shots[i]);
    while (!st && fit > 1 && shots_size(shots, fit, n) > viewer->budget)
        fit--;
    if (!st) {
        // Red-cyan and wiggle turn about what is an arm and a half away.
        fprintf(f, "<figure class=\"viewer\" data-shift=\"%.5f\">",
                ap_capture_eye_shift(capture, 1));
        fputs("<canvas role=\"img\" aria-label=\"what the eyes see\">"
              "</canvas><figcaption>the pictures need a script to be shown</figcaption>"
              "<script type=\"application/json\">[",
              f);
        write_shots(f, shots, fit, n);
        fputs("\n]</script></figure>\n", f);
    }
    for (size_t i = 0; i < n; i++)
        for (int e = 0; e < 2; e++)
            free(shots[i].png[e]);
    return st;
}
