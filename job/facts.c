// SPDX-License-Identifier: Apache-2.0
// What follows from a key, a cell or a surface.
#include "job/internal.h"

void kn_job_degree(const kn_job_key *key, int degree[KN_JOB_VARS])
{
    for (int d = 0; d < KN_JOB_VARS; d++) degree[d] = key->composed[d];
}

size_t kn_job_numbers(const int degree[KN_JOB_VARS])
{
    size_t n = 1;
    for (int d = 0; d < KN_JOB_VARS; d++) n *= (size_t)degree[d] + 1;
    return n;
}

size_t kn_job_columns(const kn_job_key *key)
{
    size_t n = 0;
    for (int t = 0; t < key->nterms; t++) n += (size_t)(key->degree[t][0] + 1) * (size_t)(key->degree[t][1] + 1);
    return n;
}

void kn_job_segments(const kn_job *job, const kn_job_key *key, int segments[KN_JOB_VARS])
{
    for (int d = 0; d < KN_JOB_VARS; d++) {
        int n = job->segments >> key->rect.level[d];
        segments[d] = n > 1 ? n : 1;
    }
}

void kn_job_coarsen(const kn_job *job, size_t cell, int segments[KN_JOB_VARS])
{
    for (int d = 0; d < KN_JOB_VARS && job->detail; d++) {
        int n = segments[d] >> job->detail[cell];
        segments[d] = n > 1 ? n : 1;
    }
}

size_t kn_job_triangles(int nvars, const int segments[KN_JOB_VARS], uint8_t hidden)
{
    size_t sum = 0;
    if (nvars == 2) return 2 * (size_t)segments[0] * (size_t)segments[1];
    for (int face = 0; face < 6 && nvars == 3; face++)
        if (!(hidden >> face & 1)) sum += 2 * (size_t)segments[face < 2 ? 1 : 0] * (size_t)segments[face < 4 ? 2 : 1];
    return sum;
}

size_t kn_job_components(const kn_job_surface *s)
{
    return kn_shell_surface(s->shell)->rational ? 4 : 3;
}

void kn_job_locate(const kn_job *job, size_t index, int *surface, int cell[2])
{
    int lo = 0, hi = job->nsurfaces - 1;
    while (lo < hi) {
        int middle = (lo + hi + 1) / 2;
        if (job->surfaces[middle].first_cell <= index)
            lo = middle;
        else
            hi = middle - 1;
    }
    size_t at = index - job->surfaces[lo].first_cell, row = (size_t)job->surfaces[lo].cells[1];
    *surface = lo;
    cell[0] = (int)(at / row);
    cell[1] = (int)(at % row);
}
