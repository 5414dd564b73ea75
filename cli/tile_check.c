// SPDX-License-Identifier: Apache-2.0
// knurl tiles --check: what is proved of one tile.
#include "cli/cli.h"

int cli_check_tile(cli_session *session, const kn_tile *tile, bool json)
{
    (void)json;
    kn_status status = kn_tile_check(cli_ctx(session), tile);
    if (status != KN_OK) return cli_fail(session, status, true);
    cli_error("tiles: --check cannot prove anything of %s yet", tile->name);
    return EXIT_FAILED;
}
