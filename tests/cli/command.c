// SPDX-License-Identifier: Apache-2.0
#include "tests/cli/command.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

char printed[TEXT_BYTES], complained[TEXT_BYTES];

void slurp(const char *path, char text[TEXT_BYTES])
{
    char *all = test_read_file(path, NULL);
    assert_non_null(all);
    snprintf(text, TEXT_BYTES, "%s", all);
    free(all);
}

void write_text(const char *path, const char *text)
{
    test_write_file(path, text, strlen(text));
}

bool exists(const char *path)
{
    return access(path, F_OK) == 0;
}

int run(const char *format, ...)
{
    char out[PATH_BYTES], err[PATH_BYTES], arguments[2048], line[4096];
    test_tmp_path(out, "cli.out");
    test_tmp_path(err, "cli.err");
    va_list list;
    va_start(list, format);
    vsnprintf(arguments, sizeof arguments, format, list);
    va_end(list);
    snprintf(line, sizeof line, "'%s' %s >'%s' 2>'%s'", getenv("KNURL"), arguments, out, err);
    int status = system(line);
    slurp(out, printed);
    slurp(err, complained);
    assert_true(WIFEXITED(status));
    return WEXITSTATUS(status);
}

json_t *printed_json(void)
{
    json_t *root = json_loads(printed, 0, NULL);
    assert_non_null(root);
    return root;
}

// The format runs the first variable fastest, a kn_spline the last one.
static void write_points(FILE *f, const kn_spline *s)
{
    size_t n = kn_spline_count(s);
    int at[KN_MAX_VARS] = {0};
    for (size_t k = 0; k < n; k++) {
        size_t flat = 0;
        for (int d = 0; d < s->nvars; d++) flat = flat * (size_t)s->count[d] + (size_t)at[d];
        for (int c = 0; c < s->ncomp; c++) fprintf(f, "%.17g ", s->coef[(size_t)c * n + flat]);
        fputc('\n', f);
        for (int d = 0; d < s->nvars && ++at[d] == s->count[d]; d++) at[d] = 0;
    }
}

void write_g2(const char *path, const kn_spline *s)
{
    FILE *f = fopen(path, "w");
    assert_non_null(f);
    fprintf(f, "%d 1 0 0\n%d %d\n", s->nvars == 1 ? 100 : s->nvars == 2 ? 200 : 700, kn_spline_dim(s), s->rational);
    for (int d = 0; d < s->nvars; d++) {
        fprintf(f, "%d %d\n", s->count[d], s->degree[d] + 1);
        for (int i = 0; i <= s->count[d] + s->degree[d]; i++) fprintf(f, "%.17g ", s->knots[d][i]);
        fputc('\n', f);
    }
    write_points(f, s);
    assert_int_equal(fclose(f), 0);
}
