// SPDX-License-Identifier: Apache-2.0
#include "tests/metal/cpu/msl_cpu.h"
