// SPDX-License-Identifier: Apache-2.0
// Names of the status codes, and the version.
#include <knurl/base.h>

const char *kn_status_name(kn_status status)
{
    switch (status) {
    case KN_OK: return "KN_OK";
    case KN_ENOMEM: return "KN_ENOMEM";
    case KN_EDOMAIN: return "KN_EDOMAIN";
    case KN_ELIMIT: return "KN_ELIMIT";
    case KN_EUNDEFINED: return "KN_EUNDEFINED";
    case KN_EUNDECIDED: return "KN_EUNDECIDED";
    case KN_EPARSE: return "KN_EPARSE";
    case KN_EIO: return "KN_EIO";
    case KN_ECANCELLED: return "KN_ECANCELLED";
    case KN_ENOTBUILT: return "KN_ENOTBUILT";
    }
    return "KN_?";
}

const char *kn_version(void)
{
    return KN_VERSION_STRING;
}
