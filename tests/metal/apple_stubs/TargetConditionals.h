// SPDX-License-Identifier: Apache-2.0
// Which Apple system a file is checked for: -DDPL_CHECK_MAC=1 or 0.
#pragma once
#ifndef DPL_CHECK_MAC
#define DPL_CHECK_MAC 1
#endif
#define TARGET_OS_OSX DPL_CHECK_MAC
#define TARGET_OS_IPHONE (!DPL_CHECK_MAC)
