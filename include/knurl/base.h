// SPDX-License-Identifier: Apache-2.0
// Status codes, versions and the context that every call of knurl takes.
#ifndef KNURL_BASE_H
#define KNURL_BASE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define KN_VERSION_MAJOR 0
#define KN_VERSION_MINOR 1
#define KN_VERSION_PATCH 0
#define KN_VERSION_STRING "0.1.0"

// KN_API marks the functions that the shared library exports; all else is hidden.
#if defined(__GNUC__)
#define KN_API __attribute__((visibility("default")))
#define KN_CHECKED __attribute__((warn_unused_result))
#define KN_PRINTF(string, first) __attribute__((format(printf, string, first)))
#else
#define KN_API
#define KN_CHECKED
#define KN_PRINTF(string, first)
#endif

// Named limits. Beyond them a call answers KN_ELIMIT before it counts or allocates anything.
enum {
    KN_MAX_VARS = 8,    // variables of one spline
    KN_MAX_DEGREE = 56, // in one variable: every C(56, k) is below 2^53, so binomials are exact doubles
    KN_MAX_COMPS = 64,  // components, the weight included
};
#define KN_MAX_COEFS ((size_t)1 << 28) // coefficients of one spline, all components together

#ifdef __cplusplus
extern "C" {
#endif

typedef enum kn_status {
    KN_OK = 0,
    KN_ENOMEM,     // the allocator answered NULL
    KN_EDOMAIN,    // arguments that do not fit each other, or lie outside what the call is defined for
    KN_ELIMIT,     // a named limit (KN_MAX_*) would be passed
    KN_EUNDEFINED, // mathematically undefined: no normal at a cone's apex, a division by zero weight
    KN_EUNDECIDED, // the answer exists, and this computation could not decide it
    KN_EPARSE,     // bad input data; the message names file, line and value
    KN_EIO,        // the system refused to read or write; the message says which file and why
    KN_ECANCELLED, // the progress callback asked to stop
    KN_ENOTBUILT,  // the feature needs a library that this build was made without
} kn_status;

// The name of a status, "KN_ENOMEM" for example; "KN_?" for a number that is none. Static storage.
KN_API const char *kn_status_name(kn_status status);

// The version of the library that is running, "0.1.0". Compare with KN_VERSION_STRING.
KN_API const char *kn_version(void);

// A context carries allocator, callbacks, thread count, scratch memory and the last error.
// One thread at a time may use one context; any number of contexts may exist.
typedef struct kn_ctx kn_ctx;

// All three NULL means malloc, realloc and free. They may be called from several threads at once when
// threads > 1. Blocks must be aligned for any type, as malloc's are. resize(user, NULL, n) is never called.
typedef struct kn_allocator {
    void *(*allocate)(void *user, size_t bytes);
    void *(*resize)(void *user, void *block, size_t bytes);
    void (*release)(void *user, void *block);
    void *user;
} kn_allocator;

typedef enum kn_log_level { KN_LOG_DEBUG, KN_LOG_INFO, KN_LOG_WARNING } kn_log_level;

// Zero means the default in every field. log and progress are called only from the thread that called knurl.
typedef struct kn_ctx_options {
    kn_allocator allocator;
    void (*log)(void *user, kn_log_level level, const char *message); // NULL: silent
    int (*progress)(void *user, const char *stage, double fraction);  // nonzero cancels; NULL: never
    void *user;                                                       // passed to log and progress
    int threads;                                                      // 0: one per online processor
} kn_ctx_options;

KN_API kn_ctx_options kn_ctx_defaults(void);

// A new context in *out. options may be NULL. The caller owns it: kn_ctx_destroy.
// fails: KN_ENOMEM, KN_EDOMAIN (some allocator callbacks set and others not, threads < 0); *out unchanged.
KN_API KN_CHECKED kn_status kn_ctx_create(kn_ctx **out, const kn_ctx_options *options);
// Releases the context and its scratch memory; NULL is fine. Results stay valid no longer: clear them first.
KN_API void kn_ctx_destroy(kn_ctx *ctx);

// The first error since the context was made or kn_ctx_clear_error was called: its status, its message (never
// NULL, "" when none) and the source file and line that raised it (NULL and 0 when none). A fixed buffer inside
// the context: running out of memory is described too.
KN_API kn_status kn_ctx_error(const kn_ctx *ctx);
KN_API const char *kn_ctx_message(const kn_ctx *ctx);
KN_API const char *kn_ctx_error_file(const kn_ctx *ctx);
KN_API int kn_ctx_error_line(const kn_ctx *ctx);
KN_API void kn_ctx_clear_error(kn_ctx *ctx);

KN_API int kn_ctx_threads(const kn_ctx *ctx);

// Frees an array that a call of knurl handed out (pieces, readers' arrays); NULL is fine.
KN_API void kn_free(kn_ctx *ctx, void *block);

typedef struct kn_counters {
    size_t live_blocks, live_bytes; // held now by results and scratch
    size_t peak_bytes;              // the most that was ever live
    size_t allocations;             // successful allocations and resizes so far
} kn_counters;
KN_API kn_counters kn_ctx_counters(const kn_ctx *ctx);

#ifdef __cplusplus
}
#endif
#endif
