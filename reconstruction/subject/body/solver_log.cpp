// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/body/solver_log.h"

#ifdef DOPPEL_GLOG
#include <glog/logging.h>
#endif

namespace dpl {

void silenceSolverLog() {
#ifdef DOPPEL_GLOG
    FLAGS_minloglevel = google::GLOG_FATAL;
#endif
}

}  // namespace dpl
