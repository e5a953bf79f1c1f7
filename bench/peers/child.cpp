// SPDX-License-Identifier: MPL-2.0
#include "peers/child.h"

#include "volume/errors.h"

#include <fmt/format.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>

namespace isocast {

ScratchFolder::ScratchFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "isocast-peer-XXXXXX").string();
    if (!mkdtemp(name.data())) throw ResourceError("cannot make a temporary folder: " + name);
    path_ = name;
}

ScratchFolder::~ScratchFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
}

std::string run_child(const std::string& command) {
    std::FILE* pipe = popen((command + " 2>&1").c_str(), "r");
    if (!pipe) throw ResourceError("cannot run " + command);
    std::string output;
    std::array<char, 4096> buffer{};
    while (const std::size_t count = std::fread(buffer.data(), 1, buffer.size(), pipe))
        output.append(buffer.data(), count);
    const int status = pclose(pipe);
    if (status != 0)
        throw ResourceError(fmt::format("status {} of {}\n{}", status, command, output));
    return output;
}

std::vector<bool> read_mask(const std::string& path, int width, int height) {
    std::ifstream file(path, std::ios::binary);
    const auto next_word = [&] {
        std::string word;
        while (file >> word && word.starts_with('#')) std::getline(file, word); // a comment
        return word;
    };
    const std::string kind = next_word();
    const std::string columns = next_word();
    const std::string rows = next_word();
    next_word(); // the greatest value
    file.get();
    const std::string samples(std::istreambuf_iterator<char>(file), {});
    if (kind != "P5" || columns != std::to_string(width) || rows != std::to_string(height) ||
        std::ssize(samples) != std::ptrdiff_t{width} * height)
        throw ResourceError(fmt::format("{}: not a mask of {} x {} pixels", path, width, height));
    std::vector<bool> mask;
    for (const char sample : samples) mask.push_back(sample != 0);
    return mask;
}

} // namespace isocast
