// XYZ: a count, a comment, and a line "element x y z …" for each atom; more frames may follow.
// SPDX-License-Identifier: MPL-2.0
#include "quadrics/elements.h"
#include "quadrics/molecule_parsers.h"
#include "quadrics/text_lines.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace isocast {

namespace {

/// Takes the first word off `line`.
std::string_view take_word(std::string_view& line) {
    line = trimmed(line);
    const std::string_view word = line.substr(0, line.find_first_of(" \t"));
    line.remove_prefix(word.size());
    return word;
}

} // namespace

MoleculeFile parse_xyz(std::string_view bytes, const std::string& name) {
    MoleculeFile file;
    TextLines lines(bytes, name);
    for (int model = 1; !lines.is_at_end(); ++model) {
        const std::string_view count_text = trimmed(lines.next());
        if (count_text.empty()) { // blank lines after a frame are none of the format's, but common
            --model;
            continue;
        }
        const std::optional<int> count = whole_number(count_text);
        if (!count || *count < 0) lines.fail("the number of atoms is expected here");
        if (lines.is_at_end()) lines.fail("the file ends before the comment");
        const std::string_view comment = trimmed(lines.next());
        if (model == 1) file.title = comment;
        for (int k = 0; k < *count; ++k) {
            if (lines.is_at_end())
                lines.fail(fmt::format("the file ends after {} of {} atoms", k, *count));
            std::string_view line = lines.next();
            const std::string_view symbol = take_word(line);
            Atom atom{.name = std::string(symbol), .model = model};
            const std::optional<int> number = whole_number(symbol);
            atom.element = number && *number <= last_atomic_number ? std::max(*number, 0)
                                                                   : atomic_number_of(symbol);
            if (atom.element == 0 && symbol != "X" && symbol != "0")
                lines.fail("the line does not start with an element");
            for (double& x : atom.position)
                if (std::isnan(x = number_or_nan(take_word(line))))
                    lines.fail("three coordinates that are numbers are expected after the element");
            if (!(atom.position.cwiseAbs().maxCoeff() <= largest_coordinate_angstrom))
                lines.fail("a coordinate is beyond 1e6 angstrom");
            file.atoms.push_back(std::move(atom));
        }
    }
    return file;
}

} // namespace isocast
