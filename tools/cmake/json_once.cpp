// SPDX-License-Identifier: Apache-2.0
// Compiles the templates that json_once.h declares as extern.
#define DPL_JSON_TEMPLATE template
#include "tools/cmake/json_once.h"
