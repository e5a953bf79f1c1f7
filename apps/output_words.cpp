// SPDX-License-Identifier: MPL-2.0
#include "apps/output_words.h"

#include "apps/inputs.h"

#include <fmt/format.h>

#include <bit>
#include <charconv>

namespace isocast {

PictureSize size_from(std::string_view text) {
    PictureSize size;
    const char* end = text.data() + text.size();
    const auto [x, no_width] = std::from_chars(text.data(), end, size.width);
    if (no_width == std::errc{} && x != end && *x == 'x') {
        const auto [rest, no_height] = std::from_chars(x + 1, end, size.height);
        if (no_height == std::errc{} && rest == end && size.width > 0 && size.height > 0)
            return size;
    }
    throw UsageError(fmt::format("'{}' is not WxH in pixels, like 1024x768", text));
}

int samples_from(int count) {
    if (count < 1 || count > 64 || !std::has_single_bit(static_cast<unsigned>(count)))
        throw UsageError(fmt::format("{} is not one of 1, 2, 4, 8, 16, 32, 64", count));
    return count;
}

FrameRange frames_from(const std::string& text) {
    try {
        const auto dots = text.find("..");
        const FrameRange frames = dots == std::string::npos
                                      ? FrameRange{0, integer_from(text) - 1}
                                      : FrameRange{integer_from(text.substr(0, dots)),
                                                   integer_from(text.substr(dots + 2))};
        // 10^6: ten hours of film.
        if (frames.first >= 0 && frames.last >= frames.first && frames.last < 1'000'000)
            return frames;
    } catch (const UsageError&) { // the message below says more
    }
    throw UsageError(
        fmt::format("'{}' is neither a number of frames nor A..B, below 1000000", text));
}

std::filesystem::path frame_path(const std::filesystem::path& pattern, int number) {
    const std::string name = pattern.filename().string();
    const auto percent = name.find('%');
    const auto d = percent == std::string::npos ? percent : name.find('d', percent);
    int digits = 0;
    if (d != std::string::npos) {
        const char* end = name.data() + d;
        const auto [rest, error] = std::from_chars(name.data() + percent + 1, end, digits);
        if (rest == end && digits <= 9 && name.find('%', d) == std::string::npos)
            return pattern.parent_path() / fmt::format("{}{:0{}}{}", name.substr(0, percent),
                                                       number, digits, name.substr(d + 1));
    }
    throw UsageError(fmt::format(
        "{}: the name of a sequence must hold one %d or %04d for the frame's number", name));
}

} // namespace isocast
