/* SPDX-License-Identifier: Apache-2.0 */
/* What the module CDoppel holds: the headers of the C interface that concern Apple's platforms. A test holds this list against
 * sdk/include/doppel. */
#ifndef CDOPPEL_H
#define CDOPPEL_H

#include <doppel/doppel.h>
#include <doppel/doppel_convert.h>
#include <doppel/doppel_posed.h>
#include <doppel/doppel_surface.h>
#define DPL_METAL_POINTERS /* Metal objects are plain pointers, so this module has the same types on every platform */
#include <doppel/doppel_metal.h>

#endif
