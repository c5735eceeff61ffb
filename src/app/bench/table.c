#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "src/app/bench/bench.h"
#include "src/app/gnuplot.h"

double ap_bench_cpu_ms(void) {
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec * 1e3 + (double)t.tv_nsec * 1e-6;
}

static int by_size(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

struct ap_spread ap_bench_spread(double *values, int count) {
    qsort(values, (size_t)count, sizeof *values, by_size);
    return (struct ap_spread){values[count / 4], values[count / 2], values[3 * count / 4]};
}

enum ap_status ap_bench_begin(struct ap_error *err, const char *name, const char *header,
                              struct ap_bench_table *table) {
    *table = (struct ap_bench_table){.name = name};
    table->csv = open_memstream(&table->text, &table->size);
    if (!table->csv)
        return ap_fail(err, AP_ENVIRONMENT, "out of memory");
    fprintf(table->csv, "%s\n", header);
    return AP_OK;
}

void ap_bench_drop(struct ap_bench_table *table) {
    if (table->csv)
        fclose(table->csv);
    free(table->text);
    *table = (struct ap_bench_table){0};
}

static enum ap_status path_of(struct ap_error *err, const struct ap_bench *bench, const char *name,
                              const char *suffix, char **path) {
    char file[64];
    snprintf(file, sizeof file, "%s%s", name, suffix);
    *path = ap_path_join(bench->out, file);
    return *path ? AP_OK : ap_fail(err, AP_ENVIRONMENT, "out of memory");
}

// A device's name is somebody else's text: letters, digits and what cannot end a string.
static void plain_text(FILE *f, const char *text) {
    for (; *text; text++)
        fputc(strchr("\"\\`$'", *text) || (unsigned char)*text < ' ' ? ' ' : *text, f);
}

static void write_script(FILE *f, const struct ap_bench_table *table, const char *title,
                         const char *device, const char *script) {
    fprintf(f, "set terminal pngcairo size 980,640 noenhanced font 'DejaVu Sans,10' background rgb "
               "'#ffffff'\nset encoding utf8\nset datafile separator ','\n$data << EOD\n");
    fwrite(table->text, 1, table->size, f);
    fprintf(f,
            "EOD\nset grid lc rgb '#dddddd'\nset key noenhanced\nset border lc rgb '#555555'\n"
            "heading = \"%s\\n",
            title);
    plain_text(f, device);
    fprintf(f, "\"\n%s", script);
}

static enum ap_status write_plot(struct ap_error *err, const struct ap_bench *bench,
                                 const struct ap_bench_table *table, const char *title,
                                 const char *device, const char *script) {
    char *text = NULL, *path = NULL;
    size_t size = 0;
    FILE *memory = open_memstream(&text, &size), *file = tmpfile();
    enum ap_status st =
        memory && file ? AP_OK : ap_fail(err, AP_ENVIRONMENT, "%s", strerror(errno));
    if (memory) {
        write_script(memory, table, title, device, script);
        fclose(memory);
    }
    if (!st)
        st = path_of(err, bench, table->name, ".gnuplot", &path);
    if (!st)
        st = ap_file_write(err, path, text, size);
    free(path);
    path = NULL;
    if (!st)
        st = path_of(err, bench, table->name, ".png", &path);
    if (!st && fwrite(text, 1, size, file) != size)
        st = ap_fail(err, AP_ENVIRONMENT, "a temporary file cannot be written");
    if (!st)
        st = ap_gnuplot(err, file, path);
    free(path);
    free(text);
    if (file)
        fclose(file);
    return st;
}

enum ap_status ap_bench_end(struct ap_error *err, const struct ap_bench *bench,
                            struct ap_bench_table *table, const char *title, const char *device,
                            const char *script) {
    char *path = NULL;
    bool whole = fclose(table->csv) == 0;
    table->csv = NULL;
    enum ap_status st = whole ? AP_OK : ap_fail(err, AP_ENVIRONMENT, "out of memory");
    if (!st)
        st = path_of(err, bench, table->name, ".csv", &path);
    if (!st)
        st = ap_file_write(err, path, table->text, table->size);
    if (!st)
        st = write_plot(err, bench, table, title, device, script);
    if (!st)
        printf("%s and its plot\n%s\n", path, table->text);
    fflush(stdout);
    free(path);
    ap_bench_drop(table);
    return st;
}
