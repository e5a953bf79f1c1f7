// What a viewer drew, step by step, for --trace: a line of JSON for each.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "apps/view/canvas.h"

#include <array>
#include <fstream>
#include <map>

namespace isocast::view {

class Trace {
public:
    /// path  none if empty: nothing is written
    /// throws  InputError if it cannot be written
    explicit Trace(const std::filesystem::path& path);

    void step(const Step& step);
    /// A picture of the window: how many so far, and what panels and the rest of it took.
    void screen(double milliseconds);
    /// Controls by name, if they are elsewhere than before [window units].
    void places(const std::map<std::string, std::array<float, 4>>& places);
    void event(const std::string& what, const std::string& text);

private:
    std::ofstream file_;
    std::map<std::string, std::array<float, 4>> places_;
    int screens_ = 0;
};

} // namespace isocast::view
