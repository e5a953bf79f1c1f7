// How much memory this process may still take.
// SPDX-License-Identifier: MPL-2.0
#include "volume/available_memory.h"

#include <sys/resource.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>

namespace isocast {

namespace {

constexpr double unlimited = std::numeric_limits<double>::infinity();

/// The bytes that `key`, as "VmData:", has in a file of lines of KEY KIBIBYTES kB.
double bytes_of(const char* path, const std::string& key) {
    std::ifstream file(path);
    for (std::string word; file >> word; std::getline(file, word)) {
        double kibibytes = 0;
        if (word == key && file >> kibibytes) return kibibytes * 1024;
    }
    return unlimited;
}

/// The least limit of the control groups that hold this process, and of those that hold them.
double control_group_bytes() {
    double least = unlimited;
    std::ifstream groups("/proc/self/cgroup"); // lines of NUMBER:CONTROLLERS:PATH
    for (std::string line; std::getline(groups, line);) {
        const std::size_t first = line.find(':');
        const std::size_t second = line.find(':', first + 1);
        if (second == std::string::npos) continue;
        const std::string controllers = line.substr(first + 1, second - first - 1);
        const bool is_unified = controllers.empty(); // version 2
        if (!is_unified && controllers != "memory") continue;
        const std::string root = is_unified ? "/sys/fs/cgroup" : "/sys/fs/cgroup/memory";
        const char* const limit_name = is_unified ? "/memory.max" : "/memory.limit_in_bytes";
        for (std::filesystem::path group = line.substr(second + 1);; group = group.parent_path()) {
            double limit = 0; // version 2 writes "max" for none
            if (std::ifstream(root + group.string() + limit_name) >> limit)
                least = std::min(least, limit);
            if (group == group.parent_path()) break;
        }
    }
    return least;
}

double data_limit_bytes() {
    rlimit limit{};
    if (::getrlimit(RLIMIT_DATA, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return unlimited;
    return std::max(0.0,
                    static_cast<double>(limit.rlim_cur) - bytes_of("/proc/self/status", "VmData:"));
}

} // namespace

double available_memory_bytes() {
    return std::min(
        {bytes_of("/proc/meminfo", "MemAvailable:"), control_group_bytes(), data_limit_bytes()});
}

} // namespace isocast
