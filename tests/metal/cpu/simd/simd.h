#include "tests/metal/cpu/msl_cpu.h"
