// SPDX-License-Identifier: Apache-2.0
// The one place where the templates that json_once.h names are compiled.
#define DPL_JSON_TEMPLATE template
#include "tools/cmake/json_once.h"
