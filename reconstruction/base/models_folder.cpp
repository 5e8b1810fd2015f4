// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/base/models_folder.h"

#include <cstdlib>

namespace dpl {

namespace fs = std::filesystem;

fs::path userModelsFolder() {
    const char* data = std::getenv("XDG_DATA_HOME");
    if (data && fs::path(data).is_absolute()) return fs::path(data) / "doppel" / "models";
    const char* home = std::getenv("HOME");
    return home && *home ? fs::path(home) / ".local" / "share" / "doppel" / "models" : fs::path();
}

fs::path installedModels() {
    const fs::path folder = userModelsFolder();
    std::error_code error;
    return !folder.empty() && fs::is_regular_file(folder / network_files::kPose, error) ? folder : fs::path();
}

std::string howToGetNetworks() {
    const std::string run = "run doppel setup";
    return userModelsFolder().empty()
               ? run + " with --out DIR, and name DIR by --models, because neither HOME nor XDG_DATA_HOME says where networks are"
               : run + ", or name a folder of networks by --models";
}

}  // namespace dpl
